"""Where the vehicle may be, and where it had best come up: areas of the local frame, in the plain form of a log too.

How deep the fence is says `SafetyParams.depth_max`: stations have no item for it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

MAX_CORNERS = 120
"""Corners and circles of a fence: each costs the cycle about a tenth of a microsecond."""
MAX_RALLY_POINTS = 32
"""Rally points: the way to each may have to be looked at in one cycle."""
_NOTHING = 1e-6
"""A shorter piece of a way, m, is rounding."""


class Disc(NamedTuple):
    """A circle's area: centre and radius, m."""

    x: float
    y: float
    radius: float

    def holds(self, x: float, y: float) -> bool:
        """True for a point in it."""
        return math.hypot(x - self.x, y - self.y) <= self.radius

    def crossings(self, x: float, y: float, dx: float, dy: float) -> Iterator[float]:
        """The shares of the way from (x, y) to (x + dx, y + dy), m, at which it crosses the edge."""
        x, y = x - self.x, y - self.y
        a, b, c = dx * dx + dy * dy, dx * x + dy * y, x * x + y * y - self.radius * self.radius
        root = b * b - a * c
        if a > 0.0 and root > 0.0:
            root = math.sqrt(root)
            yield from (share for share in ((-b - root) / a, (-b + root) / a) if 0.0 < share < 1.0)

    def cuts(self, x: float, y: float, radius: float) -> Iterator[float]:
        """The bearings, rad, at which the circle of a radius, m, about (x, y) crosses the edge."""
        away = math.hypot(self.x - x, self.y - y)
        if abs(self.radius - radius) < away < self.radius + radius:
            bearing = math.atan2(self.y - y, self.x - x)
            half = (away * away + radius * radius - self.radius * self.radius) / (2.0 * away * radius)
            half = math.acos(min(max(half, -1.0), 1.0))
            yield from (bearing - half, bearing + half)


class Polygon(NamedTuple):
    """An area with straight sides: at least three corners (x, y), m, in either sense."""

    corners: tuple[tuple[float, float], ...]

    def holds(self, x: float, y: float) -> bool:
        """True for a point in it: a ray to the east crosses its sides an odd number of times."""
        inside = False
        x0, y0 = self.corners[-1]
        for x1, y1 in self.corners:
            if (x0 > x) != (x1 > x) and y < y0 + (x - x0) / (x1 - x0) * (y1 - y0):
                inside = not inside
            x0, y0 = x1, y1
        return inside

    def crossings(self, x: float, y: float, dx: float, dy: float) -> Iterator[float]:
        """As those of a `Disc`."""
        x0, y0 = self.corners[-1]
        side0 = dx * (y0 - y) - dy * (x0 - x)  # positive to starboard of the way
        for x1, y1 in self.corners:
            side1 = dx * (y1 - y) - dy * (x1 - x)
            if (side0 > 0.0) != (side1 > 0.0):
                share = ((x0 - x) * (y1 - y) - (x1 - x) * (y0 - y)) / (side1 - side0)
                if 0.0 < share < 1.0:
                    yield share
            x0, y0, side0 = x1, y1, side1

    def cuts(self, x: float, y: float, radius: float) -> Iterator[float]:
        """As those of a `Disc`."""
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
    """Return what is wrong with a place by the fence, for people; "" if nothing is."""
    if breach == WITHIN:
        return ""
    return "outside the fence" if breach == OUTSIDE else f"within exclusion {breach:.0f} of the fence"


@dataclass(frozen=True, slots=True)
class Fence:
    """The vehicle shall be in one of `within`, if there are any, and in none of `without`."""

    within: tuple[Area, ...] = ()
    without: tuple[Area, ...] = ()

    def breached(self, x: float, y: float) -> int:
        """Return the number of the exclusion that (x, y), m, is in, from 1; OUTSIDE of all inclusions; or WITHIN.

        Of NaN nothing is known: WITHIN.
        """
        if math.isnan(x + y):
            return WITHIN
        for i, area in enumerate(self.without, 1):
            if area.holds(x, y):
                return i
        if self.within and not any(area.holds(x, y) for area in self.within):
            return OUTSIDE
        return WITHIN

    def breach(self, x: float, y: float) -> str:
        """Return what is wrong with being at (x, y), m, as `breach_text` says it; "" if nothing is."""
        return breach_text(self.breached(x, y))

    def barred(self, x0: float, y0: float, x1: float, y1: float) -> str:
        """What is wrong with the straight way from (x0, y0) to (x1, y1), m, as `breach` says it; "" if nothing is.

        Between two edges that it crosses a way is all within an area or all without.
        """
        dx, dy = x1 - x0, y1 - y0
        areas = (*self.within, *self.without)
        shares = sorted(share for area in areas for share in area.crossings(x0, y0, dx, dy))
        least = _NOTHING / (math.hypot(dx, dy) or 1.0)
        for a, b in itertools.pairwise((0.0, *shares, 1.0)):
            middle = 0.5 * (a + b)
            if b - a > least and (why := self.breach(x0 + middle * dx, y0 + middle * dy)):
                return why
        return self.breach(x1, y1)

    def ringed(self, x: float, y: float, radius: float) -> str:
        """What is wrong with the circle of a radius, m, about (x, y), as `barred` has it of a straight way."""
        areas = (*self.within, *self.without)
        bearings = sorted(bearing % math.tau for area in areas for bearing in area.cuts(x, y, radius)) or [0.0]
        for a, b in itertools.pairwise((*bearings, bearings[0] + math.tau)):
            middle = 0.5 * (a + b)
            there = x + radius * math.cos(middle), y + radius * math.sin(middle)
            if (b - a) * radius > _NOTHING and (why := self.breach(*there)):
                return why
        return ""


NO_FENCE = Fence()


class Place(NamedTuple):
    """A place on the surface, m."""

    x: float
    y: float


NOWHERE = Place(math.nan, math.nan)


def fence_to_plain(fence: Fence) -> dict[str, Any]:
    """{"within": [area, ...], "without": ...}; an area is [x, y, radius], or a list of corners [[x, y], ...]."""
    return {"within": [*map(_plain, fence.within)], "without": [*map(_plain, fence.without)]}


def fence_from_plain(table: Mapping[str, Any]) -> Fence:
    """The fence that `fence_to_plain` made the table of; an empty table is none."""
    return Fence(*(tuple(map(_area, table.get(side, ()))) for side in ("within", "without")))


def rally_from_plain(table: Mapping[str, Any]) -> tuple[Place, ...]:
    """Rally points from {"points": [[x, y], ...]}; an empty table has none."""
    return tuple(Place(*point) for point in table.get("points", ()))


def nearest_rally_point(places: Iterable[Place], fence: Fence, x: float, y: float) -> Place | None:
    """The nearest place to which a straight way from (x, y), m, keeps to the fence; None if there is none.

    From beyond the fence every way begins there: to be in it is then all that is asked of a place.
    """
    beyond = fence.breached(x, y) != WITHIN
    for place in sorted(places, key=lambda place: math.hypot(place.x - x, place.y - y)):
        if not (fence.breached(*place) if beyond else fence.barred(x, y, *place)):
            return place
    return None


def _plain(area: Area) -> list[Any]:
    return list(area) if isinstance(area, Disc) else [list(corner) for corner in area.corners]


def _area(numbers: list[Any]) -> Area:
    return Polygon(tuple((x, y) for x, y in numbers)) if isinstance(numbers[0], list) else Disc(*numbers)
