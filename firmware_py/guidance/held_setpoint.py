"""What is held: the setpoint of HOLD, LOITER and GUIDED, as a station changes it."""

from __future__ import annotations

import math

from firmware_py.marine import clip
from firmware_py.records.order import Setpoint
from firmware_py.records.turning import Turning

USEFUL_SPEED = 0.5
"""Slower than this, m/s, fins hardly act and a current sets the vehicle back: it drifts, and is not under way."""


def held(wanted: Setpoint, ordered: Setpoint, turning: Turning) -> Setpoint:
    """Return what is wanted once an order is obeyed.

    To go to a place or to a depth takes way: an order without a speed, to a vehicle that is not under way, gets
    the cruising speed.
    """
    z_d = max(ordered.z_d, 0.0) if math.isfinite(ordered.z_d) else wanted.z_d
    psi_d = ordered.psi_d if math.isfinite(ordered.psi_d) else wanted.psi_d
    if math.isfinite(ordered.u_d):
        return Setpoint(z_d, psi_d, clip(ordered.u_d, 0.0, turning.speed_max))
    takes_way = math.isfinite(ordered.z_d) or math.isfinite(ordered.x + ordered.y)
    return Setpoint(z_d, psi_d, under_way(wanted.u_d, turning) if takes_way else wanted.u_d)


def under_way(u_d: float, turning: Turning) -> float:
    """Return a speed, m/s, or the cruising speed for one that is none."""
    return u_d if u_d >= USEFUL_SPEED else turning.speed(0.0)
