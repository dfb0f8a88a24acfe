"""Line of sight: steer for a point on the leg, a look-ahead distance in front of the vehicle (Fossen 2011, ch. 10.3).

The course that is asked for is the leg's plus atan(-cross_track / look_ahead), with that error a `lead` ahead, since
the heading reference lags. The heading is that course less the crab angle: a current across the leg then leaves no
offset. Where the water's velocity is estimated, the crab angle is the one at which the hull's own speed makes up for
what the water does across the course, at once. Else it is the angle over ground at the hull's pivot, where a turn shows
no sway, low-passed. All but the first is ours; with lead_s = 0 and crab_time_s = 0 this is the paper's line of sight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.mission import Waypoint


@dataclass(frozen=True, slots=True)
class LineOfSightParams:
    """Steering along a leg, and acceptance of its end."""

    look_ahead: float = param(
        15.0, unit="m", low=0.5, high=1000.0, doc="How far ahead it steers (paper: 15 m).", mav="LOOK_AHEAD"
    )
    acceptance: float = param(
        5.0, unit="m", low=0.0, high=1000.0, doc="A waypoint nearer than this is passed.", mav="ACCEPTANCE"
    )
    depth_acceptance: float = param(
        2.0,
        unit="m",
        low=0.1,
        high=1000.0,
        doc="A waypoint is passed no farther off its depth; who comes by farther off circles through it.",
        mav="ACC_DEPTH",
    )
    depth_time: float = param(
        300.0,
        unit="s",
        low=0.0,
        high=1e5,
        doc="A waypoint passed at another depth is circled for so long, then given up, with an event.",
        mav="ACC_TIME",
    )
    lead: float = param(
        2.0, unit="s", low=0.0, high=60.0, doc="How far ahead in time the cross-track error is taken.", mav="LEAD"
    )
    crab_time: float = param(
        10.0,
        unit="s",
        low=0.0,
        high=1000.0,
        doc="Time to learn the crab angle if no current is known; 0: none.",
        mav="CRAB_TIME",
    )
    crab_max: float = param(45.0, unit="deg", low=0.0, high=80.0, doc="Bound of the crab angle.", mav="CRAB_MAX")
    pivot: float = param(
        3.5, unit="m", low=0.0, high=100.0, doc="How far ahead of the origin a turn shows no sway.", mav="PIVOT"
    )
    u_min: float = param(
        0.3, unit="m/s", low=0.01, high=10.0, doc="Slower than this the crab angle is not learned.", mav="CRAB_U_MIN"
    )


_KNOWN = 0.1
"""1 sigma of a current that is known, m/s."""


class Leg(NamedTuple):
    """A straight leg between two positions, relative to the vehicle.

    `along` is the along-track distance, `across` the cross-track distance, positive to starboard, m; `course` in rad.
    """

    length: float
    course: float
    along: float
    across: float
    distance: float

    @property
    def share(self) -> float:
        """Share of the leg that is done, in [0, 1]; 1 if it has no length."""
        return clip(self.along / self.length, 0.0, 1.0) if self.length > 0.0 else 1.0


def leg(start: Waypoint, end: Waypoint, x: float, y: float) -> Leg:
    """Return the leg relative to (x, y), m."""
    dx, dy = end.x - start.x, end.y - start.y
    length = math.hypot(dx, dy)
    course = math.atan2(dy, dx)
    c, s = math.cos(course), math.sin(course)
    x0, y0 = x - start.x, y - start.y
    return Leg(length, course, c * x0 + s * y0, c * y0 - s * x0, math.hypot(end.x - x, end.y - y))


def is_passed(way: Leg, reach: float, shortest: float) -> bool:
    """Return whether the waypoint is within `reach` (m), or abeam or behind.

    A leg no longer than `shortest`, m, is too short to fly: its waypoint is passed with the one before it.
    """
    near = reach + way.length if way.length <= shortest else reach
    return way.distance <= near or way.along >= way.length


class LineOfSight:
    """Line-of-sight steering; it remembers the crab angle, rad."""

    def __init__(self, params: LineOfSightParams) -> None:
        self._params = params
        self._memory = 0.0

    def update(self, way: Leg, state: StateEstimate, dt: float) -> float:
        """Return the heading to steer, rad, not wrapped."""
        params = self._params
        u, v = state.nu.u, state.nu.v + params.pivot * state.nu.r
        off = state.eta.psi - way.course
        across = way.across + params.lead * (u * math.sin(off) + state.nu.v * math.cos(off))
        course = way.course - math.atan(across / params.look_ahead)
        if params.crab_time > 0.0 and u > params.u_min:
            through = state.through_water if state.water_std <= _KNOWN else 0.0
            if through > params.u_min:
                north, east = state.water
                drift = east * math.cos(course) - north * math.sin(course)
                self._memory = clip(math.asin(clip(drift / through, -1.0, 1.0)), -params.crab_max, params.crab_max)
            elif state.velocity_ok:
                crab = clip(math.atan2(v, u), -params.crab_max, params.crab_max)
                self._memory += min(dt / params.crab_time, 1.0) * (crab - self._memory)
        return course - self._memory

    def reset(self) -> None:
        """Clear the crab angle."""
        self._memory = 0.0

    def freeze(self) -> float:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
