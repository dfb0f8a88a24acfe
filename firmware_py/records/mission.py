"""How files say a mission: the tables that mission.toml and scenarios have in common, and the plain form in a log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firmware_py.params import ParamError, dump, load, param
from firmware_py.records.order import Manoeuvre, Mission, Waypoint


@dataclass(frozen=True, slots=True)
class Point:
    """A waypoint."""

    x: float = param(unit="m", low=-1e5, high=1e5, doc="North of the origin.")
    y: float = param(unit="m", low=-1e5, high=1e5, doc="East of the origin.")
    depth: float = param(unit="m", low=0, high=6000, doc="To be at from here.")
    speed: float = param(unit="m/s", low=0, high=10, doc="To get here with; 0 is the cruising speed.")

    @property
    def waypoint(self) -> Waypoint:
        """As the vehicle is given it."""
        return Waypoint(self.x, self.y, self.depth, self.speed)


@dataclass(frozen=True, slots=True)
class Item:
    """One of the [[items]]: a waypoint or a manoeuvre."""

    waypoint: Point | None = None
    manoeuvre: Manoeuvre | None = None

    def __post_init__(self) -> None:
        if (self.waypoint is None) == (self.manoeuvre is None):
            raise ParamError("an item is either a waypoint = {...} or a manoeuvre = {...}; write one of them")


def mission_of(waypoints: Sequence[Point], items: Sequence[Item]) -> Mission:
    """The mission of a file that has either [[waypoints]] or [[items]].

    Raises:
        ParamError: it has both, and nobody knows in which order.
    """
    if waypoints and items:
        raise ParamError("there are [[waypoints]] and [[items]]; write all of them as [[items]], in their order")
    found = [item.manoeuvre or (item.waypoint and item.waypoint.waypoint) for item in items]
    return Mission(tuple(point.waypoint for point in waypoints) + tuple(item for item in found if item))


def plain(mission: Mission) -> dict[str, Any]:
    """Tables, lists and numbers: {"waypoints": [[x, y, z, u], ...], "manoeuvres": [{"after": n, ...}, ...]}.

    A manoeuvre comes `after` so many waypoints, and is otherwise as in a file.
    """
    waypoints: list[list[float]] = []
    manoeuvres: list[dict[str, Any]] = []
    for item in mission.items:
        if isinstance(item, Waypoint):
            waypoints.append(list(item))
        else:
            manoeuvres.append({"after": len(waypoints), **dump(item)})
    return {"waypoints": waypoints, "manoeuvres": manoeuvres}


def from_plain(table: Mapping[str, Any]) -> Mission:
    """The mission that `plain` made the table of; one without "manoeuvres" has none.

    Raises:
        ParamError: a manoeuvre that cannot be flown.
    """
    manoeuvres = [dict(manoeuvre) for manoeuvre in table.get("manoeuvres", ())]
    places = [manoeuvre.pop("after") for manoeuvre in manoeuvres]
    items: list[Waypoint | Manoeuvre] = [Waypoint(*point) for point in table["waypoints"]]
    for place, manoeuvre in reversed(list(zip(places, manoeuvres, strict=True))):
        items.insert(place, load(Manoeuvre, manoeuvre, "mission"))
    return Mission(tuple(items))
