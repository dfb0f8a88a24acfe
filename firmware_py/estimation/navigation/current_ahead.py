"""The current along the hull as far as it is sure: what the propeller, SURFACE and the limits count on."""

from __future__ import annotations

import math

from firmware_py.estimation.navigation.velocity import VelocityMemory
from firmware_py.estimation.navigation.velocity_params import VelocityParams

_UNSURE = 0.2
"""What is known of a current may be off by so much, m/s, while it is learned, in eddies, or where it changes."""
_SIGMAS = 2.0


def current_ahead(params: VelocityParams, memory: VelocityMemory, t: float, theta: float, psi: float) -> float:
    """Return the current along the hull, m/s, ahead positive, less what it may be off by; 0 if that is more.

    It is the one that the coefficient filter knew last: behind a dropped weight no filter follows the hull any more.
    """
    current = memory.current
    std = current.std_at(params, t)
    if not std < params.lost_std:
        return 0.0
    along = (current.north * math.cos(psi) + current.east * math.sin(psi)) * math.cos(theta)
    return math.copysign(max(0.0, abs(along) - max(_UNSURE, _SIGMAS * std)), along)
