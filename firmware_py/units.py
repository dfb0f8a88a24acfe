"""Units of parameters: the suffix of a key in TOML, and the factor to SI."""

from __future__ import annotations

import enum
import math
from typing import Any

UNITS: dict[str, tuple[str, float]] = {
    "": ("", 1.0),
    "m": ("_m", 1.0),
    "m/s": ("_m_s", 1.0),
    "m/s^2": ("_m_s2", 1.0),
    "m^2": ("_m2", 1.0),
    "s": ("_s", 1.0),
    "ms": ("_ms", 1e-3),
    "us": ("_us", 1e-6),
    "1/s": ("_1_s", 1.0),
    "Hz": ("_hz", 1.0),
    "deg": ("_deg", math.pi / 180),
    "deg/s": ("_deg_s", math.pi / 180),
    "deg/m": ("_deg_m", math.pi / 180),
    "rad": ("_rad", 1.0),
    "rpm": ("_rpm", 1.0 / 60.0),
    "rpm/s": ("_rpm_s", 1.0 / 60.0),
    "kg": ("_kg", 1.0),
    "kg/m^3": ("_kg_m3", 1.0),
    "kg m^2": ("_kg_m2", 1.0),
    "N": ("_n", 1.0),
    "Pa": ("_pa", 1.0),
    "V": ("_v", 1.0),
    "A": ("_a", 1.0),
    "ohm": ("_ohm", 1.0),
    "W": ("_w", 1.0),
    "Wh": ("_wh", 3600.0),
    "K": ("_k", 1.0),
    "%": ("_pct", 0.01),
    "MB": ("_mb", 1e6),
}
"""Unit to (suffix of the TOML key, factor to SI)."""

_DECIMALS = 12
"""A value is written with at most so many decimals, if it reads back exactly."""


def to_si(value: Any, factor: float) -> Any:
    """Return a value, or a tuple of values, times `factor`; texts, truth values and choices as they are."""
    if isinstance(value, tuple):
        return tuple(to_si(v, factor) for v in value)
    if isinstance(value, bool | str | enum.Enum) or factor == 1.0:
        return value
    return value * factor


def from_si(value: float, factor: float) -> float:
    """Return the number whose product with `factor` is `value` to the last bit, where there is one."""
    guess = value / factor
    for candidate in (
        round(guess, _DECIMALS),
        guess,
        math.nextafter(guess, math.inf),
        math.nextafter(guess, -math.inf),
    ):
        if candidate * factor == value:
            return candidate
    return guess
