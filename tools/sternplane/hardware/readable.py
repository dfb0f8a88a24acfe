"""What a role of the vehicle measures, in units for people."""

from __future__ import annotations

import math
from typing import Any

from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Hardpoint


def readable(role: str, value: Any) -> str:
    """Return a value of `SensorFrame` with its unit; what is not known is "?"."""
    match value:
        case Ahrs(phi, theta, psi, p, q, r):
            heading = math.degrees(psi) % 360.0 if math.isfinite(psi) else psi
            turning = max(abs(p), abs(q), abs(r)) if math.isfinite(p + q + r) else math.nan
            tilt = f"roll {_degrees(phi)}°, pitch {_degrees(theta)}°"
            return f"{tilt}, heading {_number(heading, 1)}°, turns at {_degrees(turning)}°/s"
        case Dvl(u, v, w, _, altitude):
            velocity = f"u {_number(u, 3)}, v {_number(v, 3)}, w {_number(w, 3)} m/s"
            return f"{velocity}, bottom {_number(altitude, 2)} m"
        case Fix(latitude, longitude, std):
            place = f"{_number(math.degrees(latitude), 5)}°, {_number(math.degrees(longitude), 5)}°"
            return f"{place} (north, east), within {_number(std, 1)} m"
        case Battery(voltage, current, remaining):
            return f"{_number(voltage, 1)} V, {_number(current, 1)} A, {_number(100.0 * remaining, 0)} % left"
        case Hardpoint(holds, load):
            return f"{'holds' if holds else 'has let go'}, {_number(load, 0)} N"
    if role.startswith("fin "):
        return f"{_degrees(value)}°"
    if role == "pressure":
        return f"{_number(value * 1e-3, 2)} kPa"
    if role == "altitude":
        return f"{_number(value, 2)} m"
    if role == "n":
        return f"{_number(value * 60.0, 0)} rpm"
    return f"{_number(100.0 * value, 0)} % humidity" if role == "leak" else f"{value}"


def _degrees(angle: float) -> str:
    return _number(math.degrees(angle), 1)


def _number(value: float, decimals: int) -> str:
    return f"{value:z.{decimals}f}" if math.isfinite(value) else "?"
