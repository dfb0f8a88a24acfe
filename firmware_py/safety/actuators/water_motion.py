"""The speed and the current by which fins are judged: of the DVL through the water, or of the propeller without it."""

from __future__ import annotations

import math

from firmware_py.marine import clip
from firmware_py.records.estimate import StateEstimate
from firmware_py.safety.actuators.hull_response import PERIOD
from firmware_py.safety.actuators.water_speed import WaterSpeed

_ACROSS_STD = 0.3
"""Yaw is not judged while the current across the hull is not known better than this, m/s."""
_SPEED_RATE = 0.2
"""The speed that fins are held to changes no faster, m/s^2: a step of it would look like an effect that they lack."""
_BRAKED = 0.7
"""Without DVL nothing tells how much the hull brakes in its turns: at full rudder it keeps this share of its speed."""


def least_speed(driven: float, before: float, state: StateEstimate, water: tuple[WaterSpeed, ...]) -> float:
    """Return the least speed that the hull may have, m/s, and not far from that of a period before.

    Args:
        driven: what the propeller makes of it in the end, m/s.
        before: that of a period before, m/s; NaN: none.
        state: what navigation knows, for a time without DVL.
        water: what speed and current may be by the DVL; empty without it.
    """
    u = min([driven, *[x.least for x in water]]) if water else _BRAKED * min(driven, state.nu.u)
    return clip(u, before - _SPEED_RATE * PERIOD, before + _SPEED_RATE * PERIOD) if before == before else u


def current_across(state: StateEstimate, water: tuple[WaterSpeed, ...]) -> tuple[float, bool]:
    """Return the current to starboard, m/s, and whether it is known well enough to judge yaw; see `least_speed`."""
    psi = state.eta.psi
    if water:
        return water[0].across(psi), water[0].across_std(psi) < _ACROSS_STD
    if not (state.velocity_ok and state.water_std < _ACROSS_STD):
        return 0.0, True
    north, east = state.water
    return east * math.cos(psi) - north * math.sin(psi), True
