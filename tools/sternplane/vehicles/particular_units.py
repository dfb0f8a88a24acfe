"""Units in which a published table gives particulars of a hull, and what each is in the unit of our key."""

from __future__ import annotations

import math
import re

from firmware_py.error_text import quoted
from firmware_py.params import ParamError

G = 9.81
_KNOT = 1852.0 / 3600.0
_UNITS: dict[str, dict[str, float]] = {
    "_kg_m3": {"kg/m3": 1.0, "kgm-3": 1.0, "g/cm3": 1000.0, "kg/l": 1000.0},
    "_kg_m2": {"kgm2": 1.0, "nms2": 1.0},
    "_deg_s": {"deg/s": 1.0, "°/s": 1.0, "rad/s": math.degrees(1.0)},
    "_m_s": {"m/s": 1.0, "ms-1": 1.0, "kn": _KNOT, "kt": _KNOT, "kts": _KNOT, "knots": _KNOT, "km/h": 1.0 / 3.6},
    "_rpm": {
        "rpm": 1.0,
        "rev/min": 1.0,
        "1/min": 1.0,
        "rev/s": 60.0,
        "rps": 60.0,
        "1/s": 60.0,
        "rad/s": 30.0 / math.pi,
    },
    "_deg": {"deg": 1.0, "°": 1.0, "rad": math.degrees(1.0)},
    "_kg": {"kg": 1.0, "g": 0.001, "t": 1000.0, "lb": 0.45359237},
    "_m": {"m": 1.0, "mm": 0.001, "cm": 0.01, "in": 0.0254, "ft": 0.3048},
    "_n": {"n": 1.0, "kgm/s2": 1.0, "kn": 1000.0, "kg": G, "kgf": G, "lbf": 4.4482216},
}
"""By the end of our key; the first that fits counts. Small letters, without blanks, ^ and signs of multiplication."""
_POWERS = str.maketrans("¹²³⁻−", "123--")
_PLAIN = {"-": 1.0, "1": 1.0}


def factor(key: str, unit: str) -> float:
    """Return what a value in a unit, as a table writes it, is to be multiplied by for our key; "" is that of the key.

    Raises:
        ParamError: it is no unit of such a quantity.
    """
    if not unit.strip():
        return 1.0
    known = next((units for end, units in _UNITS.items() if key.endswith(end)), _PLAIN)
    plain = re.sub(r"[\s^*·⋅]", "", unit.lower().translate(_POWERS))
    if plain not in known:
        raise ParamError(f"the unit {quoted(unit)} is not understood; known are {', '.join(known)}")
    return known[plain]
