"""How a vehicle was steered, in words: its law, its gains, and the configuration that they come from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware_py import config_files
from firmware_py.control.control import ControlParams, LawKind
from firmware_py.control.sliding_mode_params import GainSet
from firmware_py.params import ParamError, to_toml_value


def control_of(header: Mapping[str, Any]) -> ControlParams | None:
    """Return the control parameters of a log's header; None if it has none that this version can read."""
    try:
        return config_files.autopilot_params(header["configuration"]).control
    except (KeyError, TypeError, ParamError):
        return None


def gains_text(control: ControlParams) -> str:
    """Return whose gains a law has."""
    papers = control.law is LawKind.SLIDING and control.gains is GainSet.PAPER
    return "the paper's" if papers else "of the configuration"


def steering_text(header: Mapping[str, Any]) -> str:
    """Return vehicle, law, gains and configuration in one line; "" for a header without."""
    control, files = control_of(header), header.get("configuration", {}).get("files", {})
    if control is None:
        return ""
    law = f"law {to_toml_value(control.law, 1.0)}"
    if control.law is LawKind.SLIDING:
        law += ", the paper's gains" if control.gains is GainSet.PAPER else ", gains of the configuration"
    name = header["configuration"].get("vehicle", {}).get("name", "")
    return " · ".join(part for part in (f"vehicle {name}" if name else "", law, files.get("autopilot", "")) if part)
