"""The mission's legs, one after another: which is being flown, and when the last is done."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.line_of_sight import Leg, leg, passed
from firmware_py.marine import wrap
from firmware_py.records.order import Mission, Waypoint


class Progress(NamedTuple):
    """The waypoint that is steered for (as many as there are: the last is passed), and where its leg starts."""

    next: int
    start: Waypoint | None


_SHARPEST = math.radians(120.0)
"""A sharper corner is rounded like this one: the way before it would else grow without bound."""


class Route:
    """Remembers `Progress`."""

    def __init__(self, mission: Mission) -> None:
        self._waypoints = mission.waypoints
        self._memory = Progress(0, None)

    def __len__(self) -> int:
        return len(self._waypoints)

    @property
    def index(self) -> int:
        """The waypoint that is steered for."""
        return self._memory.next

    @property
    def finished(self) -> bool:
        """True once the last waypoint is passed."""
        return self._memory.next == len(self._waypoints)

    @property
    def end(self) -> Waypoint:
        """The waypoint that is steered for; the last one after it was passed."""
        return self._waypoints[min(self._memory.next, len(self._waypoints) - 1)]

    def enter(self, x: float, y: float, z: float) -> None:
        """Starts a leg at this place, m, to the waypoint that is next."""
        self._memory = Progress(self._memory.next, Waypoint(x, y, z, self.end.u))

    def follow(self, x: float, y: float, acceptance: float, radius: float, lag: float) -> Leg:
        """The leg to fly from (x, y), m, once every waypoint within reach is passed; the last leg goes on for ever.

        Within reach is what is nearer than `acceptance`, or than the wheel-over point from which a turn of `radius`
        that begins `lag` later, m, ends on the next leg.
        """
        index, start = self._memory
        start = start or Waypoint(x, y, self.end.z, self.end.u)
        way = leg(start, self.end, x, y)
        while not self.finished and passed(way, max(acceptance, self._wheel_over(way, radius, lag)), acceptance):
            index += 1
            if index < len(self._waypoints):
                start = self._waypoints[index - 1]
            self._memory = Progress(index, start)
            way = leg(start, self.end, x, y)
        return way

    def _wheel_over(self, way: Leg, radius: float, lag: float) -> float:
        """How far before the waypoint to turn to the next leg, m: R tan(turn / 2) + lag, at most half a leg."""
        index = self._memory.next
        if index + 1 >= len(self._waypoints):
            return 0.0
        here, there = self._waypoints[index], self._waypoints[index + 1]
        dx, dy = there.x - here.x, there.y - here.y
        turn = min(abs(wrap(math.atan2(dy, dx) - way.course)), _SHARPEST)
        return min(radius * math.tan(0.5 * turn) + lag, 0.5 * way.length, 0.5 * math.hypot(dx, dy))

    def depth(self, way: Leg) -> float:
        """The depth, m, on the straight line from the leg's start to its end."""
        start, end = self._memory.start, self.end
        return end.z if start is None else start.z + way.share * (end.z - start.z)

    def reset(self) -> None:
        """Back to the first waypoint."""
        self._memory = Progress(0, None)

    def freeze(self) -> Progress:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: Progress) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory
