"""What tells a vehicle from another."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from firmware_py.error_text import printable, quoted
from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

LONGEST = 200
"""Of a name or serial number, characters."""
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


def refuse_no_identity(found: Any) -> None:
    """Refuse what `identity` cannot have returned, or what cannot be printed.

    Raises:
        ParamError: in one line, which key.
    """
    if not isinstance(found, Mapping):
        raise ParamError("vehicle: must be a table")
    for key in ("name", "serial"):
        if not printable(found.get(key), LONGEST):
            raise ParamError(f"vehicle: {key} = {quoted(found.get(key))}: must be a text of up to {LONGEST} characters")
    for key in ("length_m", "height_m", "width_m"):
        if not isinstance(found.get(key), float):
            raise ParamError(f"vehicle: {key} = {quoted(found.get(key))}: must be a number")
    if not isinstance(found.get("fins"), list):
        raise ParamError(f"vehicle: fins = {quoted(found.get('fins'))}: must be a list")


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
