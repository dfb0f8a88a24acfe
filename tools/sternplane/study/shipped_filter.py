"""The settings of the filter that is judged: those of the shipped configuration, with what `--set` lays upon it."""

from __future__ import annotations

import functools

from firmware_py import config_files
from firmware_py.estimation.coefficient_params import CoefficientParams
from sternplane.sitl.flight import CONFIG
from sternplane.sitl.request import parse_settings
from sternplane.study.laid_settings import settings_now


def shipped() -> CoefficientParams:
    """Return the settings of the filter."""
    return _of(settings_now())


@functools.cache
def _of(settings: tuple[str, ...]) -> CoefficientParams:
    configuration = config_files.read_configuration(CONFIG, settings=parse_settings(settings))
    return config_files.autopilot_params(configuration).estimation.coefficients
