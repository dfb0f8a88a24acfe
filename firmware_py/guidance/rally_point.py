"""The choice of a rally point: the nearest one that can be reached within the fence."""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.records.fence import WITHIN, Fence, Place


def nearest_rally_point(places: Iterable[Place], fence: Fence, x: float, y: float) -> Place | None:
    """Return the nearest place that a straight leg from (x, y), m, reaches without leaving the fence; None without one.

    From outside the fence every leg begins outside: then a place only has to be inside.
    """
    outside = fence.breach_at(x, y) != WITHIN
    for place in sorted(places, key=lambda place: math.hypot(place.x - x, place.y - y)):
        if not (fence.breach_at(*place) if outside else fence.leg_problem(x, y, *place)):
            return place
    return None
