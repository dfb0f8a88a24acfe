"""The choice of a rally point: the nearest one that can be reached within the fence. And when home is not known."""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.fence import HOME, WITHIN, Fence, Place

_NEAR = 30.0
"""A position that is known so well, m, is good enough for every way home."""


def nearest_rally_point(places: Iterable[Place], fence: Fence, x: float, y: float) -> Place | None:
    """Return the nearest place that a straight leg from (x, y), m, reaches without leaving the fence; None without one.

    From outside the fence every leg begins outside: then a place only has to be inside.
    """
    outside = fence.breach_at(x, y) != WITHIN
    for place in sorted(places, key=lambda place: math.hypot(place.x - x, place.y - y)):
        if not (fence.breach_at(*place) if outside else fence.leg_problem(x, y, *place)):
            return place
    return None


def home_not_known(x: float, y: float, std: float) -> tuple[Event, ...]:
    """Return the event that nothing is gained by going home from (x, y), m, which are known to `std`, m; or none.

    So it is where the position is farther off than home is away.
    """
    distance = math.hypot(x - HOME.x, y - HOME.y)
    if std <= max(distance, _NEAR):
        return ()
    return (event(EventKind.HOME_NOT_KNOWN, numbers=(distance, std)),)


def unreachable(places: Iterable[Place]) -> Event:
    """Return the event that no straight leg within the fence leads to any of the places."""
    kind = EventKind.HOME_UNREACHABLE if tuple(places) == (HOME,) else EventKind.RALLY_POINT_UNREACHABLE
    return event(kind)


def seen_from(target: Place | None, x: float, y: float, across: float, psi: float) -> tuple[float, float]:
    """Return distance, m, and bearing, rad, of a target from (x, y), m.

    Without one: the distance `across` from the leg that is flown, m (NaN: from none), and the heading `psi`, rad.
    """
    if target is None:
        return abs(across) if math.isfinite(across) else 0.0, psi
    north, east = target.x - x, target.y - y
    return math.hypot(north, east), math.atan2(east, north)
