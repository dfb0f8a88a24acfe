"""Where the vehicle may be, and where it had best come up: areas of the local frame, in the plain form of a log too.

How deep it may be is no matter of the fence: `SafetyParams.depth_max` says that.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

MOST_CORNERS = 120
"""Corners and circles of a fence: each costs the cycle about a tenth of a microsecond."""


class Disc(NamedTuple):
    """A circle's area: centre and radius, m."""

    x: float
    y: float
    radius: float

    def holds(self, x: float, y: float) -> bool:
        """True for a point in it."""
        return math.hypot(x - self.x, y - self.y) <= self.radius


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


Area = Disc | Polygon


@dataclass(frozen=True, slots=True)
class Fence:
    """The vehicle shall be in one of `within`, if there are any, and in none of `without`."""

    within: tuple[Area, ...] = ()
    without: tuple[Area, ...] = ()

    def breach(self, x: float, y: float) -> str:
        """What is wrong with being at (x, y), m, in words for people; "" if nothing is. Of NaN nothing is known."""
        if math.isnan(x + y):
            return ""
        for i, area in enumerate(self.without, 1):
            if area.holds(x, y):
                return f"within exclusion {i} of the fence"
        if self.within and not any(area.holds(x, y) for area in self.within):
            return "outside the fence"
        return ""


NO_FENCE = Fence()


class Place(NamedTuple):
    """A place on the surface, m."""

    x: float
    y: float


def plain(fence: Fence) -> dict[str, Any]:
    """{"within": [area, ...], "without": ...}; an area is [x, y, radius], or a list of corners [[x, y], ...]."""
    return {"within": [*map(_plain, fence.within)], "without": [*map(_plain, fence.without)]}


def from_plain(table: Mapping[str, Any]) -> Fence:
    """The fence that `plain` made the table of; an empty table is none."""
    return Fence(*(tuple(map(_area, table.get(side, ()))) for side in ("within", "without")))


def rally_from_plain(table: Mapping[str, Any]) -> tuple[Place, ...]:
    """Rally points from {"points": [[x, y], ...]}; an empty table has none."""
    return tuple(Place(*point) for point in table.get("points", ()))


def nearest(places: Iterable[Place], x: float, y: float) -> Place | None:
    """The place that is nearest to (x, y), m; None if there are none."""
    return min(places, key=lambda place: math.hypot(place.x - x, place.y - y), default=None)


def _plain(area: Area) -> list[Any]:
    return list(area) if isinstance(area, Disc) else [list(corner) for corner in area.corners]


def _area(plain: list[Any]) -> Area:
    return Polygon(tuple((x, y) for x, y in plain)) if isinstance(plain[0], list) else Disc(*plain)
