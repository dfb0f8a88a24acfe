"""When a waypoint is reached: a place in three dimensions, for a vehicle that cannot stand still.

Who passes a waypoint at another depth circles through it, around and around, and has reached it when it comes by at the
waypoint's depth. That is bounded in time; then the waypoint is given up, and an event says so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.circle import Circle, circle_through
from firmware_py.marine import wrap
from firmware_py.records.fence import Fence
from firmware_py.records.mission import Waypoint


class Reach(NamedTuple):
    """What is near enough to a waypoint, and what is flown about it.

    Attributes:
        acceptance: horizontal distance, m.
        depth: distance in depth, m.
        patience: how long to circle for the depth, s.
        circle_radius: of that circle, m.
        turn_radius: of the turn to the next leg, m.
        lag: way that is made before such a turn begins, m.
    """

    acceptance: float
    depth: float
    patience: float
    circle_radius: float
    turn_radius: float
    lag: float


class Spiral(NamedTuple):
    """The circle through a waypoint; bearing from its centre and angle gone around since there, rad; time spent, s."""

    circle: Circle
    bearing: float
    turned: float
    spent: float

    def advance(self, x: float, y: float, dt: float) -> Spiral:
        """Return the spiral after a tick that ends at (x, y), m."""
        bearing = math.atan2(y - self.circle.y, x - self.circle.x)
        gone = math.copysign(1.0, self.circle.radius) * wrap(bearing - self.bearing)
        return Spiral(self.circle, bearing, self.turned + gone, self.spent + dt)

    @property
    def turns(self) -> int:
        """Return how often it has come around."""
        return math.floor(self.turned / math.tau)


def begin_spiral(end: Waypoint, course: float, radius: float, fence: Fence, x: float, y: float) -> Spiral:
    """Return the spiral through a waypoint, passed on `course`, rad: to starboard, or to the side within the fence."""
    sides = (circle_through(end.x, end.y, course, side * radius) for side in (1.0, -1.0))
    within = (circle for circle in sides if not fence.circle_problem(circle.x, circle.y, radius))
    circle = next(within, None) or circle_through(end.x, end.y, course, radius)
    at_waypoint = math.atan2(end.y - circle.y, end.x - circle.x)
    return Spiral(circle, at_waypoint, 0.0, 0.0).advance(x, y, 0.0)
