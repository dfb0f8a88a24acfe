"""How files say a mission: the tables that mission.toml and scenarios have in common, and the plain form in a log."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firmware_py.params import ParamError, dump, load, param
from firmware_py.records.mission import (
    Jump,
    Loiter,
    Manoeuvre,
    Mission,
    MissionItem,
    Surface,
    Waypoint,
    leads_nowhere,
)

_NAMED: dict[str, Callable[..., MissionItem]] = {"loiter": Loiter, "jump": Jump, "surface": Surface}


@dataclass(frozen=True, slots=True, kw_only=True)
class WaypointTable:
    """A waypoint, at a depth or at an altitude above the bottom."""

    x: float = param(unit="m", low=-1e5, high=1e5, doc="North of the origin.")
    y: float = param(unit="m", low=-1e5, high=1e5, doc="East of the origin.")
    depth: float = param(math.nan, unit="m", low=0, high=6000, doc="To be at from here.")
    altitude: float = param(math.nan, unit="m", low=0, high=6000, doc="Instead of a depth: above the bottom.")
    speed: float = param(unit="m/s", low=0, high=10, doc="To get here with; 0 is the cruising speed.")

    def __post_init__(self) -> None:
        if math.isnan(self.depth) and math.isnan(self.altitude):
            raise ParamError("depth_m is missing; or give altitude_m, above the bottom")
        if math.isfinite(self.depth + self.altitude):
            raise ParamError("there are depth_m and altitude_m; leave one of them out")

    @property
    def item(self) -> Waypoint:
        """The item of the mission."""
        above = math.isnan(self.depth)
        return Waypoint(self.x, self.y, self.altitude if above else self.depth, self.speed, above)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoiterTable:
    """A circle about a place."""

    centre: WaypointTable
    radius: float = param(0.0, unit="m", low=-1000, high=1000, doc="Negative: to port; 0 is guidance.loiter_radius.")
    turns: float = param(0.0, low=0, high=1e4, doc="How often around; 0 is no end.")
    duration: float = param(0.0, unit="s", low=0, high=1e6, doc="How long; 0 is no end.")

    @property
    def item(self) -> Loiter:
        """The item of the mission."""
        return Loiter(*self.centre.item, self.radius, self.turns, self.duration)


@dataclass(frozen=True, slots=True)
class JumpTable:
    """A way back, or on, to another item."""

    to: int = param(low=0, high=1e4, doc="The item to go on with, counted from 0.")
    times: int = param(low=-1, high=1e4, doc="How often; -1 is for ever.")

    @property
    def item(self) -> Jump:
        """The item of the mission."""
        return Jump(self.to, self.times)


@dataclass(frozen=True, slots=True)
class SurfaceTable:
    """The end of the mission."""

    rally: bool = param(False, doc="First to the nearest rally point, home without one.")

    @property
    def item(self) -> Surface:
        """The item of the mission."""
        return Surface(self.rally)


@dataclass(frozen=True, slots=True)
class ItemTable:
    """One of the [[items]]: what it is says its only key."""

    waypoint: WaypointTable | None = None
    manoeuvre: Manoeuvre | None = None
    loiter: LoiterTable | None = None
    jump: JumpTable | None = None
    surface: SurfaceTable | None = None

    def __post_init__(self) -> None:
        if len([part for part in self._parts if part]) != 1:
            raise ParamError("an item is one of waypoint, manoeuvre, loiter, jump, surface = {...}; write one of them")

    @property
    def _parts(self) -> tuple[WaypointTable | Manoeuvre | LoiterTable | JumpTable | SurfaceTable | None, ...]:
        return self.waypoint, self.manoeuvre, self.loiter, self.jump, self.surface

    @property
    def item(self) -> MissionItem:
        """The item of the mission."""
        part = next(part for part in self._parts if part)
        return part if isinstance(part, Manoeuvre) else part.item


def mission_of(waypoints: Sequence[WaypointTable], items: Sequence[ItemTable]) -> Mission:
    """The mission of a file that has either [[waypoints]] or [[items]].

    Raises:
        ParamError: it has both, and nobody knows in which order; or its jumps lead nowhere.
    """
    if waypoints and items:
        raise ParamError("there are [[waypoints]] and [[items]]; write all of them as [[items]], in their order")
    for item in items:
        if item.jump and item.jump.to >= len(items):
            raise ParamError(f"items: jump to = {item.jump.to}: there are {len(items)} items, counted from 0")
    mission = Mission(tuple(point.item for point in waypoints) + tuple(item.item for item in items))
    if leads_nowhere(mission.items):
        raise ParamError("items: jumps lead to jumps alone; add an item that is flown, such as a waypoint")
    return mission


def mission_to_plain(mission: Mission) -> dict[str, Any]:
    """Tables, lists and numbers: {"waypoints": [[x, y, z, u], ...], "manoeuvres": [{"after": n, ...}, ...]}.

    A manoeuvre comes `after` so many waypoints, and is otherwise as in a file. Where there are such, "above" has the
    places among the waypoints of those above the bottom, and "others" [place among all items, kind, numbers ...].
    """
    waypoints: list[list[float]] = []
    manoeuvres: list[dict[str, Any]] = []
    above: list[int] = []
    others: list[list[Any]] = []
    for i, item in enumerate(mission.items):
        if isinstance(item, Waypoint):
            if item.above:
                above.append(len(waypoints))
            waypoints.append(list(item[:4]))
        elif isinstance(item, Manoeuvre):
            manoeuvres.append({"after": len(waypoints), **dump(item)})
        else:
            others.append([i, type(item).__name__.lower(), *item])
    optional = {"above": above, "others": others}
    return {"waypoints": waypoints, "manoeuvres": manoeuvres, **{k: v for k, v in optional.items() if v}}


def mission_from_plain(table: Mapping[str, Any]) -> Mission:
    """The mission that `mission_to_plain` made the table of; what it does not have there is none of.

    Raises:
        ParamError: a manoeuvre that cannot be flown.
    """
    manoeuvres = [dict(manoeuvre) for manoeuvre in table.get("manoeuvres", ())]
    places = [manoeuvre.pop("after") for manoeuvre in manoeuvres]
    waypoints = [Waypoint(*point) for point in table["waypoints"]]
    for place in table.get("above", ()):
        waypoints[place] = waypoints[place]._replace(above=True)
    items: list[MissionItem] = [*waypoints]
    for place, manoeuvre in reversed(list(zip(places, manoeuvres, strict=True))):
        items.insert(place, load(Manoeuvre, manoeuvre, "mission"))
    for place, kind, *numbers in table.get("others", ()):
        items.insert(place, _NAMED[kind](*numbers))
    return Mission(tuple(items))
