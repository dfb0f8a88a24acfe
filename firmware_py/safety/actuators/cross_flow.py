"""The velocities across the hull through the water, and whether the water has just changed.

Heave and sway are carried on by the model, and corrected by the DVL slowly: the noise of single pings would turn the
modelled hull more than gyros are off.

A second sway, which the DVL does not correct, tells a current that steps from fins that are lost. For the same moment
in yaw water carries the hull along five times as fast as the fins of a NPS AUV would (N_v is small, Y_v is not), and to
the other side: a step of 0.5 m/s by 0.1 m/s in the first second, half a rudder at 10 deg by 0.01 m/s.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.records.sensing import Dvl, Heard

_TIME, _MOST = 2.0, 0.5
"""The velocity across the hull follows the DVL in this time, s; it is at most this share of the speed."""
_SMOOTH, _OFFSET = 0.2, 2.0
"""Pings less the uncorrected sway are averaged over so long, s; what lasts longer than this is an error of both."""
_GAP = 1.0
"""A ping counts for no longer than this, s; without pings what was seen fades."""
_USUAL_TIME, _USUAL_FIRST = 60.0, 0.02
"""Over so long, s, what eddies and noise make of it is judged, but not while the water changes, lest a step hide the
next; what it is taken for at first, m/s."""
_LEAST, _SIGMAS = 0.02, 2.0
"""More than this, m/s, and so many times what is usual is a change of the water."""
_JUMP = 0.1
"""So much more or less current across the hull in one step, m/s, is another source of it."""

Motion = tuple[float, float, float]
"""What changes a crosswise velocity: by u times itself, by u times the rate of turn, by u^2 times the fin angle."""


class CrossMemory(NamedTuple):
    """What is remembered.

    Attributes:
        velocities: w and v through the water, m/s, by the model and the DVL together.
        sway: v by the model alone, m/s.
        offset: what pings leave it by for long, m/s.
        off: what they leave it by beside that now, m/s.
        usual: mean square of that, m^2/s^2.
        t: of the last ping, s.
        across: the current across the hull that counted last, m/s.
    """

    velocities: tuple[float, float] = (0.0, 0.0)
    sway: float = 0.0
    offset: float = 0.0
    off: float = 0.0
    usual: float = _USUAL_FIRST**2
    t: float = -math.inf
    across: float = math.nan


class CrossFlow:
    """Follows w (axis 0) and v (axis 1) through the water; `memory` is what is remembered."""

    def __init__(self, dt: float) -> None:
        """`dt` is the step of `carry`, s."""
        self._dt, self.memory = dt, CrossMemory()

    @property
    def changes(self) -> bool:
        """Return whether the hull drifts as only water that has changed makes it."""
        return abs(self.memory.off) > self._limit

    @property
    def _limit(self) -> float:
        return _LEAST + _SIGMAS * math.sqrt(self.memory.usual)

    def jumped(self, across: float) -> bool:
        """Return whether the current across the hull, m/s, comes from elsewhere than in the last step."""
        before, self.memory = self.memory.across, self.memory._replace(across=across)
        return abs(across - before) > _JUMP

    def hear(self, ping: Heard[Dvl], across: float) -> None:
        """Take a ping in a current across the hull, m/s."""
        m = self.memory
        gap = min(ping.t_valid - m.t, _GAP)
        if not gap > 0.0:
            return
        left = ping.value.v - across - m.sway - m.offset
        off = m.off + (left - m.off) * gap / (gap + _SMOOTH)
        usual = m.usual if abs(off) > self._limit else m.usual + (off * off - m.usual) * (gap / _USUAL_TIME)
        self.memory = m._replace(offset=m.offset + left * gap / _OFFSET, off=off, usual=usual, t=ping.t_valid)

    def carry(self, axis: int, t: float, motion: Motion, u: float, turning: tuple[float, float], heard: float) -> float:
        """Return the velocity of an axis after a step, m/s.

        Args:
            axis: 0: heave; 1: sway.
            t: now, s.
            motion: of the axis.
            u: speed through the water, m/s.
            turning: rate of turn, rad/s, and fin angle, rad.
            heard: the velocity by the DVL, m/s; NaN: none.
        """
        m, dt, most = self.memory, self._dt, _MOST * u
        by_cross, (by_rate, by_fins), (rate, angle) = motion[0], motion[1:], turning
        driven = by_rate * rate + u * by_fins * angle
        cross = m.velocities[axis]
        cross += dt * u * (by_cross * cross + driven)
        if heard == heard:
            cross += (heard - cross) * (dt / _TIME)
        cross = clip(cross, -most, most)
        if axis == 0:
            self.memory = m._replace(velocities=(cross, m.velocities[1]))
            return cross
        sway = clip(m.sway + dt * u * (by_cross * m.sway + driven), -most, most)
        off = m.off if t - m.t < _GAP else m.off * (1.0 - dt / _OFFSET)
        self.memory = m._replace(velocities=(m.velocities[0], cross), sway=sway, off=off)
        return cross
