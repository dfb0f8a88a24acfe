"""What a bench tool reads of a vehicle: its io file and its configuration, with single keys set."""

from __future__ import annotations

import argparse
from pathlib import Path

from firmware_py import config_files
from firmware_py.adapters.fitting import actuators_of, at_desk
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.config_files import Configuration
from firmware_py.params import load, prefix_errors
from firmware_py.settings import lay_settings, of_file, parse_setting

_FILES = {**config_files.FILES, "io": IoParams}


def read_files(options: argparse.Namespace, io_file: Path) -> tuple[IoParams, Configuration]:
    """Return what the files of --config and of the devices say, as `fly` with the same options has it.

    Raises:
        ParamError: one of them, or of --set, cannot be used.
    """
    settings = [parse_setting(text, _FILES) for text in options.settings]
    io = load(IoParams, *lay_settings(IoParams, read_toml(io_file), of_file(settings, "io"), str(io_file)))
    configuration = config_files.read_configuration(options.config, settings=settings)
    with prefix_errors(str(io_file)):
        actuators_of(io, config_files.vehicle(configuration).fins)
    return at_desk(io, options.lines) if options.lines else io, configuration
