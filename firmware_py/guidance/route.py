"""The route through the mission's items: the current item, its leg, and the end of the mission."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from firmware_py.guidance.circle import Circle
from firmware_py.guidance.line_of_sight import Leg, is_passed, leg
from firmware_py.guidance.rally_point import nearest_rally_point
from firmware_py.guidance.waypoint_reach import Reach, Spiral, begin_spiral
from firmware_py.marine import wrap
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.fence import HOME, NO_FENCE, Fence, Place
from firmware_py.records.mission import Jump, Loiter, Mission, MissionItem, Surface, Waypoint


class RouteProgress(NamedTuple):
    """Progress of the mission.

    The item that is flown (as many as there are: all are), where its leg starts, and, for the jumps that were made, how
    often each; of a loiter the bearing from its centre, rad, the angle gone around, rad, and the time, s, since its
    circle was joined (NaN, 0, 0 before); of the way to a rally point that point, and whether there was none; of a
    waypoint that was passed at another depth the circle through it.
    """

    next: int
    start: Waypoint | None = None
    jumped: tuple[tuple[int, int], ...] = ()
    bearing: float = math.nan
    turned: float = 0.0
    spent: float = 0.0
    rally: Place | None = None
    rally_unreachable: bool = False
    spiral: Spiral | None = None


BEGINNING = RouteProgress(0)
_SHARPEST = math.radians(120.0)
"""A sharper turn is wheeled over like this one, or the distance before it would grow without bound."""


def heading_towards(place: Place | None, x: float, y: float, near: float) -> float:
    """Return the heading, rad, from (x, y), m, to a place; NaN within the distance `near`, m, or without a place."""
    if place is None or math.hypot(place.x - x, place.y - y) <= near:
        return math.nan
    return math.atan2(place.y - y, place.x - x)


class Route:
    """The route through a mission; it remembers `RouteProgress`, and chooses the `nearest_rally_point`."""

    def __init__(self, mission: Mission, rally: Sequence[Place] = (), fence: Fence = NO_FENCE) -> None:
        self._items = mission.items
        self._rally, self._fence = tuple(rally), fence
        before = 0
        self._before: list[int] = []
        for item in self._items:
            self._before.append(before)
            before += isinstance(item, Waypoint)
        self._before.append(before)
        self._memory = self._from(0, BEGINNING)
        self._missed = math.nan
        """How much too shallow the last waypoint was given up, m; NaN: it was not."""
        self.events: tuple[Event, ...] = ()
        """What the last `follow` reached, in its order."""

    def __len__(self) -> int:
        """Return the number of waypoints."""
        return self._before[-1]

    @property
    def item(self) -> int:
        """Index of the current item; the number of items once all are flown."""
        return self._memory.next

    @property
    def index(self) -> int:
        """Number of waypoints before the current item."""
        return self._before[self._memory.next]

    @property
    def empty(self) -> bool:
        """Whether the mission has no items."""
        return not self._items

    @property
    def finished(self) -> bool:
        """Whether all items are flown."""
        return self._memory.next == len(self._items)

    @property
    def current(self) -> MissionItem | None:
        """The current item, a `Waypoint` on the way to a rally point too; None once all are flown."""
        if self.finished:
            return None
        item, rally = self._items[self._memory.next], self._memory.rally
        if rally is not None:
            start = self._memory.start
            return Waypoint(*rally, *((start.z, 0.0, start.above) if start else (0.0, 0.0)))
        return item

    @property
    def entered(self) -> bool:
        """Whether the leg to the current item has a start: a mission that was replaced has none yet."""
        return self._memory.start is not None

    @property
    def rally(self) -> Place | None:
        """The rally point that the vehicle goes to, if any."""
        return self._memory.rally

    @property
    def rally_unreachable(self) -> bool:
        """Whether the mission ended because no rally point has a straight leg within the fence."""
        return self._memory.rally_unreachable

    @property
    def spiral(self) -> Circle | None:
        """The circle through the current waypoint that is flown for its depth, if any."""
        return self._memory.spiral.circle if self._memory.spiral else None

    def jump(self, item: int, x: float, y: float, z: float) -> None:
        """Continue with an item from this position, m, and clear the jump counts; ignore an index out of range."""
        if 0 <= item < len(self._items):
            self._go(item, BEGINNING, x, y, z)

    def enter(self, x: float, y: float, z: float) -> None:
        """Start the leg to the current item at this position, m."""
        self._memory = self._memory._replace(start=Waypoint(x, y, z, 0.0), bearing=math.nan, spiral=None)
        self._seek(x, y)

    def leave(self, x: float, y: float, z: float) -> None:
        """End the current item; the next leg starts at this position, m."""
        self._go(min(self._memory.next + 1, len(self._items)), self._memory, x, y, z)

    def follow(
        self,
        x: float,
        y: float,
        reach: Reach,
        shallow: Callable[[Waypoint], float],
        dt: float,
    ) -> Leg:
        """Return the leg from (x, y), m, to the next waypoint, after each one that is reached.

        Reached is what is nearer than `reach.acceptance`, or than the wheel-over point from which a turn ends on the
        next leg, if the vehicle is too `shallow` for it, m, or too deep, by no more than `reach.depth`. Where no
        waypoint follows, the leg stays the one behind. `dt` is the tick, s.
        """
        end, self.events = self.current, ()
        assert isinstance(end, Waypoint)
        start = self._memory.start or end._replace(x=x, y=y)
        way = leg(start, end, x, y)
        for _ in self._items:
            near = max(reach.acceptance, self._wheel_over(end, way, reach))
            if not self._is_reached(end, way, near, reach, shallow(end), x, y, dt):
                break
            self.events += (self._reached(),)
            self._memory = self._from(self._memory.next + 1, self._memory)
            self._memory = self._memory._replace(start=end)
            self._seek(x, y)
            after = self.current
            if not isinstance(after, Waypoint):
                break
            start, end = end, after
            way = leg(start, end, x, y)
        return way

    def circle(self, x: float, y: float, circle: Circle, slack: float, dt: float) -> bool:
        """Count turns and time on a loiter's circle, which is joined within `slack`, m; return whether it is over."""
        memory, item = self._memory, self._items[self._memory.next]
        assert isinstance(item, Loiter)
        bearing = math.atan2(y - circle.y, x - circle.x)
        off = abs(math.hypot(x - circle.x, y - circle.y) - abs(circle.radius))
        if math.isnan(memory.bearing):
            if off <= slack:
                self._memory = memory._replace(bearing=bearing)
            return False
        turned = memory.turned + math.copysign(1.0, circle.radius) * wrap(bearing - memory.bearing)
        spent = memory.spent + dt
        self._memory = memory._replace(bearing=bearing, turned=turned, spent=spent)
        return (item.turns > 0.0 and turned >= math.tau * item.turns) or (0.0 < item.duration <= spent)

    def depth(self, end: Waypoint, way: Leg) -> float:
        """Return the depth, m, on the straight line from the leg's start to its end."""
        start = self._memory.start
        return end.z if start is None or start.above else start.z + way.share * (end.z - start.z)

    def abandon(self) -> None:
        """End the mission here."""
        self._memory = RouteProgress(len(self._items))

    def reset(self) -> None:
        """Return to the first item."""
        self._memory = self._from(0, BEGINNING)

    def freeze(self) -> RouteProgress:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: RouteProgress) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _is_reached(
        self, end: Waypoint, way: Leg, near: float, reach: Reach, shallow: float, x: float, y: float, dt: float
    ) -> bool:
        """Return whether a waypoint is reached or given up; circle through one that is passed at another depth."""
        at_depth = self._memory.rally is not None or abs(shallow) <= reach.depth
        spiral, self._missed = self._memory.spiral, math.nan
        if spiral is None:
            if not is_passed(way, near, reach.acceptance):
                return False
            ahead = way.along < way.length and way.length > reach.acceptance
            if at_depth or ahead:
                return at_depth
            spiral = begin_spiral(end, way.course, reach.circle_radius, self._fence, x, y)
            came_by = False
        else:
            before, spiral = spiral, spiral.advance(x, y, dt)
            came_by = way.distance <= reach.acceptance or spiral.turns > before.turns
        if at_depth and came_by:
            return True
        if spiral.spent >= reach.patience:
            self._missed = shallow
            return True
        self._memory = self._memory._replace(spiral=spiral)
        return False

    def _reached(self) -> Event:
        """Return the event that the current waypoint is reached, or given up."""
        rally, which = self._memory.rally, (self.index + 1.0, float(len(self)))
        if rally is not None:
            return event(EventKind.HOME_REACHED if rally == HOME else EventKind.RALLY_POINT_REACHED)
        if math.isnan(self._missed):
            return event(EventKind.WAYPOINT_PASSED, numbers=which)
        return event(EventKind.WAYPOINT_MISSED, numbers=(*which, self._missed))

    def _go(self, item: int, memory: RouteProgress, x: float, y: float, z: float) -> None:
        self._memory = self._from(item, memory)
        self.enter(x, y, z)

    def _seek(self, x: float, y: float) -> None:
        """Choose the rally point if the item asks for one; without any, end the mission."""
        if not self.finished and self._memory.rally is None and isinstance(self._items[self._memory.next], Surface):
            rally = nearest_rally_point(self._rally, self._fence, x, y)
            done = len(self._items) if rally is None else self._memory.next
            self._memory = self._memory._replace(next=done, rally=rally, rally_unreachable=rally is None)

    def _from(self, item: int, memory: RouteProgress) -> RouteProgress:
        """Return the progress at the first item to fly from `item` on, after all jumps in between.

        Jumps that lead only to jumps end the mission.
        """
        jumped = dict(memory.jumped)
        if memory.rally is not None:
            item = len(self._items)
        for _ in range(2 * len(self._items)):
            here = self._items[item] if item < len(self._items) else None
            if isinstance(here, Jump):
                made = jumped.get(item, 0)
                if here.times < 0 or made < here.times:
                    jumped[item] = made + (here.times >= 0)
                    item = here.to
                else:
                    jumped.pop(item, None)  # a loop around this one finds it fresh
                    item += 1
            elif isinstance(here, Surface) and not (here.rally and self._rally):
                item = len(self._items)
            else:
                return RouteProgress(item, jumped=tuple(jumped.items()))
        return RouteProgress(len(self._items))

    def _wheel_over(self, here: Waypoint, way: Leg, reach: Reach) -> float:
        """Return the wheel-over distance before the waypoint, m: R tan(turn / 2) + lag, at most half a leg.

        0 if the next item is no waypoint.
        """
        after = self._memory.next + 1
        there = self._items[after] if after < len(self._items) and self._memory.rally is None else None
        if isinstance(there, Jump):
            after = self._from(after, self._memory).next
            there = self._items[after] if after < len(self._items) else None
        if not isinstance(there, Waypoint):
            return 0.0
        dx, dy = there.x - here.x, there.y - here.y
        turn = min(abs(wrap(math.atan2(dy, dx) - way.course)), _SHARPEST)
        return min(reach.turn_radius * math.tan(0.5 * turn) + reach.lag, 0.5 * way.length, 0.5 * math.hypot(dx, dy))
