"""How deep it gets, and how near to the bottom, until SURFACE has pulled up: the limits look so far ahead."""

from __future__ import annotations

from firmware_py.records.health import ActuatorFault
from firmware_py.records.order import Mode
from firmware_py.safety.conditions import Conditions
from firmware_py.safety.safety_params import SafetyParams

_LATE = {ActuatorFault.SLOW: 3.0, ActuatorFault.LAGGING: 6.0}
"""With a slow stern plane, and one that is too slow to steer with, the vehicle pulls up later by so much, s."""
_DEEPEST_DIVE = 20.0
"""By no dive that is steered by hand is more depth than this counted as lost, m."""
_ANSWERS = 1.0
"""A dive goes on steepening for so long, s, before the planes answer."""


def altitude_reached(c: Conditions, p: SafetyParams) -> float:
    """Return the altitude, m, to which it comes before it pulls up, climbs away, or stops; below 0: it runs aground."""
    slope, pull_up = c.slope + c.rise_slope, 0.0
    if not c.faults.plane:
        pull_up = _dive_left(c, p, slope, p.altitude_time) if _by_hand(c) else c.left.pull_up(slope)
    nearer = max(0.0, c.z_dot + c.rise) * p.altitude_ahead
    climbs = max(nearer, pull_up) + c.too_steep * p.stop_time  # a dive ends, and a climb begins, later
    return c.altitude - max(climbs, c.while_it_stops * p.stop_time)


def too_low(c: Conditions, p: SafetyParams) -> bool:
    """Return whether the bottom is too near, or will be."""
    return altitude_reached(c, p) < p.altitude_min


def _by_hand(c: Conditions) -> bool:
    return c.wanted is Mode.MANUAL or c.steered


def _dive_left(c: Conditions, p: SafetyParams, slope: float, time: float) -> float:
    """Return how much deeper SURFACE gets, m, from a dive by hand of `slope`, rad, which is seen for `time`, s.

    It brings the pitch up at its rate, or as fast as the fins do; no law has begun to pull up before.
    """
    z_dot = max(0.0, c.z_dot)
    pitches_up = 0.5 * max(0.0, c.slope) / p.ascent.pitch_rate
    return min(c.left.pull_up(slope) + z_dot * (time + _ANSWERS + pitches_up), _DEEPEST_DIVE)


def depth_reached(c: Conditions, p: SafetyParams) -> float:
    """Return the depth, m, with what is lost until it has pulled up: a law does so in time, as a sound vehicle can."""
    if c.faults.plane:
        return c.depth
    late = _LATE[c.faults.slow.fault] * max(0.0, c.z_dot) if c.faults.slow else 0.0
    lost = _dive_left(c, p, c.slope, p.depth_max_time) if _by_hand(c) else c.left.lost_height(c.slope)
    return c.depth + lost + late
