"""Units in which a published table gives particulars of a hull, and what each is in the unit of our key."""

from __future__ import annotations

import math

from firmware_py.error_text import quoted
from firmware_py.params import ParamError
from sternplane.vehicles.units import G, Unit, parse_unit

_UNITS = {
    "_kg_m3": ("kg/m3", "g/cm3", "kg/l"),
    "_kg_m2": ("kg m2", "N m s2"),
    "_deg_s": ("deg/s", "rad/s"),
    "_m_s": ("m/s", "kn", "km/h"),
    "_rpm": ("rpm", "rev/s", "rad/s"),
    "_deg": ("deg", "rad"),
    "_m3": ("m3", "l"),
    "_kg": ("kg", "g", "t", "lb"),
    "_m": ("m", "mm", "cm", "in", "ft"),
    "_n": ("N", "kN", "kg", "kgf", "lbf"),
}
"""By the end of our key; the first that fits counts. The first unit is that of the key, the others are usual too."""
_NONE = ("1", "-")


def factor(key: str, text: str) -> float:
    """Return what a value in a unit, as a table writes it, is to be multiplied by for our key; "" is that of the key.

    Raises:
        ParamError: it is no unit of such a quantity.
    """
    if not text.strip():
        return 1.0
    known = next((units for end, units in _UNITS.items() if key.endswith(end)), _NONE)
    ours, unit = parse_unit(known[0]), parse_unit(text)
    assert ours is not None
    if unit is not None and unit.dimension == (0, 0, -1, 0) and key.endswith("_rpm"):
        unit = unit.times(Unit(angle=1, factor=math.tau), 1)  # 1/s of a propeller are revolutions
    if unit is not None and unit.dimension == (1, 0, 0, 0) and key.endswith("_n"):
        unit = unit.times(Unit(m=1, s=-2, factor=G), 1)  # a weight in kg is that of a mass
    if unit is None or unit.dimension != ours.dimension:
        raise ParamError(f"the unit {quoted(text)} is not understood here; known are {', '.join(known)}")
    return unit.factor / ours.factor
