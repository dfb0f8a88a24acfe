"""The mission's items, one after another: which leg or manoeuvre is being flown, and when the last is done."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.line_of_sight import Leg, leg, passed
from firmware_py.marine import wrap
from firmware_py.records.order import Manoeuvre, Mission, Waypoint


class Progress(NamedTuple):
    """How far the mission has come.

    The waypoint that is steered for (as many as there are: the last is passed), how many of the manoeuvres before it
    are done, and where its leg starts.
    """

    next: int
    done: int
    start: Waypoint | None


BEGINNING = Progress(0, 0, None)
_SHARPEST = math.radians(120.0)
"""A sharper corner is rounded like this one: the way before it would else grow without bound."""


class Route:
    """Remembers `Progress`."""

    def __init__(self, mission: Mission) -> None:
        self._waypoints = mission.waypoints
        self._manoeuvres = _before_each_waypoint(mission)
        self._memory = BEGINNING

    def __len__(self) -> int:
        """How many waypoints there are."""
        return len(self._waypoints)

    @property
    def index(self) -> int:
        """The waypoint that is steered for."""
        return self._memory.next

    @property
    def empty(self) -> bool:
        """True if there is nothing to fly."""
        return not any((self._waypoints, *self._manoeuvres))

    @property
    def finished(self) -> bool:
        """True once the last waypoint is passed and nothing is left to be flown behind it."""
        return self._memory.next == len(self._waypoints) and self.manoeuvre is None

    @property
    def manoeuvre(self) -> Manoeuvre | None:
        """The manoeuvre that is to be flown where the boat is; None on a leg."""
        here = self._manoeuvres[self._memory.next]
        return here[self._memory.done] if self._memory.done < len(here) else None

    @property
    def end(self) -> Waypoint:
        """The waypoint that is steered for; the last one after it was passed."""
        return self._waypoints[min(self._memory.next, len(self._waypoints) - 1)]

    def enter(self, x: float, y: float, z: float) -> None:
        """Starts a leg at this place, m, to the waypoint that is next."""
        self._memory = self._memory._replace(start=Waypoint(x, y, z, self.end.u))

    def leave(self, x: float, y: float, z: float) -> None:
        """The manoeuvre is done: what comes next starts at this place, m."""
        self._memory = self._memory._replace(done=self._memory.done + 1)
        if self._memory.next < len(self._waypoints):
            self.enter(x, y, z)

    def follow(self, x: float, y: float, acceptance: float, radius: float, lag: float) -> Leg:
        """The leg to fly from (x, y), m, once every waypoint within reach is passed; the last leg goes on for ever.

        Within reach is what is nearer than `acceptance`, or than the wheel-over point from which a turn of `radius`
        that begins `lag` later, m, ends on the next leg. Where a manoeuvre follows, the leg stays the one behind.
        """
        start = self._memory.start or Waypoint(x, y, self.end.z, self.end.u)
        way = leg(start, self.end, x, y)
        while self._on_a_leg and passed(way, max(acceptance, self._wheel_over(way, radius, lag)), acceptance):
            after = self._memory.next + 1
            if after < len(self._waypoints):
                start = self.end
            self._memory = Progress(after, 0, start)
            if self._on_a_leg or self.finished:
                way = leg(start, self.end, x, y)
        return way

    @property
    def _on_a_leg(self) -> bool:
        return self._memory.next < len(self._waypoints) and self.manoeuvre is None

    def _wheel_over(self, way: Leg, radius: float, lag: float) -> float:
        """How far before the waypoint to turn to the next leg, m: R tan(turn / 2) + lag, at most half a leg.

        Not at all where there is no next, or a manoeuvre before it.
        """
        index = self._memory.next
        if index + 1 >= len(self._waypoints) or self._manoeuvres[index + 1]:
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
        """Back to the first item."""
        self._memory = BEGINNING

    def freeze(self) -> Progress:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: Progress) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory


def _before_each_waypoint(mission: Mission) -> tuple[tuple[Manoeuvre, ...], ...]:
    """The manoeuvres before each waypoint, and last those behind them all."""
    groups: list[list[Manoeuvre]] = [[]]
    for item in mission.items:
        if isinstance(item, Manoeuvre):
            groups[-1].append(item)
        else:
            groups.append([])
    return tuple(map(tuple, groups))
