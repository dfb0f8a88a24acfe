"""Fence and rally points in the local frame, and their plain form in a log.

The depth of the fence is `SafetyParams.depth_max`: stations have no item for it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

MAX_CORNERS = 120
"""Greatest number of corners and circles of a fence; each costs about 0.1 us per cycle."""
MAX_RALLY_POINTS = 32
"""Greatest number of rally points; the legs to all of them may have to be checked in one cycle."""
_NEGLIGIBLE = 1e-6
"""A shorter piece of a leg, m, comes from rounding."""


class Disc(NamedTuple):
    """A circular area: centre and radius, m."""

    x: float
    y: float
    radius: float

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point is inside."""
        return math.hypot(x - self.x, y - self.y) <= self.radius

    def crossings(self, x: float, y: float, dx: float, dy: float) -> Iterator[float]:
        """Yield where the leg from (x, y) to (x + dx, y + dy), m, crosses the edge, as shares of its length."""
        x, y = x - self.x, y - self.y
        a, b, c = dx * dx + dy * dy, dx * x + dy * y, x * x + y * y - self.radius * self.radius
        root = b * b - a * c
        if a > 0.0 and root > 0.0:
            root = math.sqrt(root)
            yield from (share for share in ((-b - root) / a, (-b + root) / a) if 0.0 < share < 1.0)

    def circle_crossings(self, x: float, y: float, radius: float) -> Iterator[float]:
        """Yield the bearings, rad, at which the circle of a radius, m, about (x, y) crosses the edge."""
        away = math.hypot(self.x - x, self.y - y)
        if abs(self.radius - radius) < away < self.radius + radius:
            bearing = math.atan2(self.y - y, self.x - x)
            half = (away * away + radius * radius - self.radius * self.radius) / (2.0 * away * radius)
            half = math.acos(min(max(half, -1.0), 1.0))
            yield from (bearing - half, bearing + half)


class Polygon(NamedTuple):
    """A polygonal area: at least three corners (x, y), m, in either sense."""

    corners: tuple[tuple[float, float], ...]

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point is inside: a ray to the east crosses its sides an odd number of times."""
        inside = False
        x0, y0 = self.corners[-1]
        for x1, y1 in self.corners:
            if (x0 > x) != (x1 > x) and y < y0 + (x - x0) / (x1 - x0) * (y1 - y0):
                inside = not inside
            x0, y0 = x1, y1
        return inside

    def crossings(self, x: float, y: float, dx: float, dy: float) -> Iterator[float]:
        """See `Disc`."""
        x0, y0 = self.corners[-1]
        side0 = dx * (y0 - y) - dy * (x0 - x)  # positive to starboard of the way
        for x1, y1 in self.corners:
            side1 = dx * (y1 - y) - dy * (x1 - x)
            if (side0 > 0.0) != (side1 > 0.0):
                share = ((x0 - x) * (y1 - y) - (x1 - x) * (y0 - y)) / (side1 - side0)
                if 0.0 < share < 1.0:
                    yield share
            x0, y0, side0 = x1, y1, side1

    def circle_crossings(self, x: float, y: float, radius: float) -> Iterator[float]:
        """See `Disc`."""
        x0, y0 = self.corners[-1]
        for x1, y1 in self.corners:
            ax, ay, dx, dy = x0 - x, y0 - y, x1 - x0, y1 - y0
            a, b, c = dx * dx + dy * dy, ax * dx + ay * dy, ax * ax + ay * ay - radius * radius
            root = b * b - a * c
            if a > 0.0 and root > 0.0:
                root = math.sqrt(root)
                for share in ((-b - root) / a, (-b + root) / a):
                    if 0.0 <= share <= 1.0:
                        yield math.atan2(ay + share * dy, ax + share * dx)
            x0, y0 = x1, y1


Area = Disc | Polygon


WITHIN, OUTSIDE = 0, -1
"""Within the fence; outside all of its inclusions. A positive number is that of an exclusion."""


def breach_text(breach: int) -> str:
    """Return what is wrong with a position, for people; "" if nothing is."""
    if breach == WITHIN:
        return ""
    return "outside the fence" if breach == OUTSIDE else f"within exclusion {breach:.0f} of the fence"


@dataclass(frozen=True, slots=True)
class Fence:
    """Areas of inclusion (`within`; none allows every position) and of exclusion (`without`)."""

    within: tuple[Area, ...] = ()
    without: tuple[Area, ...] = ()

    def breach_at(self, x: float, y: float) -> int:
        """Return the number of the exclusion that (x, y), m, is in, from 1; OUTSIDE of all inclusions; or WITHIN.

        Of NaN nothing is known: WITHIN.
        """
        if math.isnan(x + y):
            return WITHIN
        for i, area in enumerate(self.without, 1):
            if area.contains(x, y):
                return i
        if self.within and not any(area.contains(x, y) for area in self.within):
            return OUTSIDE
        return WITHIN

    def problem_at(self, x: float, y: float) -> str:
        """Return what is wrong with the position (x, y), m, as `breach_text` says it; "" if nothing is."""
        return breach_text(self.breach_at(x, y))

    def leg_problem(self, x0: float, y0: float, x1: float, y1: float) -> str:
        """Return what is wrong with the straight leg from (x0, y0) to (x1, y1), m, as `problem_at` says it.

        Between two edges that it crosses, a leg lies wholly inside an area or wholly outside.
        """
        dx, dy = x1 - x0, y1 - y0
        areas = (*self.within, *self.without)
        shares = sorted(share for area in areas for share in area.crossings(x0, y0, dx, dy))
        least = _NEGLIGIBLE / (math.hypot(dx, dy) or 1.0)
        for a, b in itertools.pairwise((0.0, *shares, 1.0)):
            middle = 0.5 * (a + b)
            if b - a > least and (why := self.problem_at(x0 + middle * dx, y0 + middle * dy)):
                return why
        return self.problem_at(x1, y1)

    def circle_problem(self, x: float, y: float, radius: float) -> str:
        """Return what is wrong with the circle of a radius, m, about (x, y), as `problem_at` says it."""
        areas = (*self.within, *self.without)
        bearings = sorted(bearing % math.tau for area in areas for bearing in area.circle_crossings(x, y, radius)) or [
            0.0
        ]
        for a, b in itertools.pairwise((*bearings, bearings[0] + math.tau)):
            middle = 0.5 * (a + b)
            there = x + radius * math.cos(middle), y + radius * math.sin(middle)
            if (b - a) * radius > _NEGLIGIBLE and (why := self.problem_at(*there)):
                return why
        return ""


NO_FENCE = Fence()


class Place(NamedTuple):
    """A horizontal position, m."""

    x: float
    y: float


NOWHERE = Place(math.nan, math.nan)
HOME = Place(0.0, 0.0)
"""The origin of the local frame, as stations are told (HOME_POSITION)."""


def fence_to_plain(fence: Fence) -> dict[str, Any]:
    """Return {"within": [area, ...], "without": ...}; an area is [x, y, radius], or corners [[x, y], ...]."""
    return {"within": [*map(_plain, fence.within)], "without": [*map(_plain, fence.without)]}


def fence_from_plain(table: Mapping[str, Any]) -> Fence:
    """Return the fence from what `fence_to_plain` returned; an empty table is no fence."""
    return Fence(*(tuple(map(_area, table.get(side, ()))) for side in ("within", "without")))


def rally_from_plain(table: Mapping[str, Any]) -> tuple[Place, ...]:
    """Return the rally points from {"points": [[x, y], ...]}; an empty table has none."""
    return tuple(Place(*point) for point in table.get("points", ()))


def _plain(area: Area) -> list[Any]:
    return list(area) if isinstance(area, Disc) else [list(corner) for corner in area.corners]


def _area(numbers: list[Any]) -> Area:
    return Polygon(tuple((x, y) for x, y in numbers)) if isinstance(numbers[0], list) else Disc(*numbers)
