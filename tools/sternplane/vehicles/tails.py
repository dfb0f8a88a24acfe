"""The tails that an import knows: fins by name, with hinge, and where they sit."""

from __future__ import annotations

import math

PLUS, X = "plus", "x"
TAILS = {
    PLUS: (("stern_port", 0.0), ("stern_starboard", 0.0), ("rudder_upper", 90.0), ("rudder_lower", 90.0)),
    X: (("upper_port", 45.0), ("upper_starboard", 135.0), ("lower_starboard", 45.0), ("lower_port", 135.0)),
}
"""Name and hinge, deg, of each fin. A hinge axis goes through the hull: fins that lie opposite have the same."""
_SIDES = {"stern_port": 180.0, "stern_starboard": 0.0, "rudder_upper": -90.0, "rudder_lower": 90.0}
_SIDES |= {"upper_port": -135.0, "upper_starboard": -45.0, "lower_starboard": 45.0, "lower_port": 135.0}
"""Where a fin sits about the hull, deg from starboard, down positive."""


def centres(tail: str, length: float, height: float) -> dict[str, tuple[float, float, float]]:
    """Return the centre of each fin's area, m: near the stern, two thirds of the height from the axis."""
    reach, angles = 0.67 * height, {name: math.radians(_SIDES[name]) for name, _ in TAILS[tail]}
    return {
        name: (-0.46 * length, round(reach * math.cos(angle), 4), round(reach * math.sin(angle), 4))
        for name, angle in angles.items()
    }
