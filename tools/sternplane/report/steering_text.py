"""How a vehicle was steered, in words: its law, its gains, and the configuration that they come from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from firmware_py import config_files
from firmware_py.control.control import ControlParams, LawKind
from firmware_py.control.sliding_mode_params import GainSet
from firmware_py.params import ParamError, load, to_toml_value
from firmware_py.vehicle.vehicle import Vehicle
from sternplane.logs.tracking import Array

_MUCH = 0.01
"""A speed that is off its reference by less, m/s, needs no words."""


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


def speed_text(header: Mapping[str, Any], u: Array, u_d: Array) -> str:
    """Return what the plot of the speed shows, and why the vehicle may be off its reference for minutes.

    Args:
        header: of the log.
        u: surge over the ground at the points that are drawn, m/s.
        u_d: its reference; NaN where there is none.
    """
    text = "Surge over the ground, as its reference."
    rests = (np.diff(u_d, prepend=np.nan) == 0.0) & (u_d > 0.0)
    off, time = float(np.median((u - u_d)[rests])) if rests.any() else 0.0, _integral_time(header)
    if not (abs(off) > _MUCH and math.isfinite(time)):
        return text
    far = f"{abs(off):.2f} m/s {'faster' if off > 0.0 else 'slower'} (median)"
    why = f"The integral of the speed law, which a run-up fills, takes that away with a time constant of {time:.0f} s."
    return f"{text} While that rests the vehicle is {far}. {why}"


def _integral_time(header: Mapping[str, Any]) -> float:
    """Return with which time constant the integral of the speed law takes away an error, s; NaN where it is not known.

    In slow motion u follows n by the trim: (n_trim / u_trim + k_p) du/dt = k_i (u_d - u).
    """
    control = control_of(header)
    try:
        propeller = load(Vehicle, header.get("configuration", {}).get("vehicle", {}), "vehicle").propeller
    except ParamError:
        return math.nan
    if control is None or control.speed.k_i == 0.0:
        return math.nan
    return (propeller.n_trim / propeller.u_trim + control.speed.k_p) / control.speed.k_i
