"""What tells a vehicle from another."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from firmware_py.error_text import quoted
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

_SAME = 1e-6
"""Two lengths are the same that differ by this share of them."""


def identity(vehicle: Vehicle) -> dict[str, Any]:
    """Return what tells a vehicle from another: name, serial number, the hull's size, and where the fins sit.

    Coefficients, mass and trim are not in it: they are what changes, and what is learned.
    """
    hull = vehicle.hull
    return {
        "name": vehicle.name,
        "serial": vehicle.serial,
        "length_m": hull.length,
        "height_m": hull.height,
        "width_m": hull.width,
        "fins": [[fin.name, fin.station.name.lower(), round(math.degrees(fin.hinge), 6)] for fin in vehicle.fins],
    }


def refuse_other_vehicle(found: Any, vehicle: Vehicle) -> None:
    """Refuse what another vehicle has left; `found` is what `identity` returned there.

    Raises:
        ParamError: in one line, what differs.
    """
    if not isinstance(found, Mapping):
        raise ParamError("vehicle: must be a table")
    for key, value in identity(vehicle).items():
        other = found.get(key)
        same = other == value if not isinstance(value, float) else _close(other, value)
        if not same:
            raise ParamError(f"is of another vehicle: its {key} is {quoted(other)}, and here {quoted(value)}")


def _close(other: Any, value: float) -> bool:
    return isinstance(other, float | int) and abs(other - value) <= _SAME * value
