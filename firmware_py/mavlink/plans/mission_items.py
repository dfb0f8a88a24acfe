"""Conversion of missions: MAVLink items to the steps of `records.mission.Mission`, and back.

Each item that is flown becomes one step. A change of speed becomes no step; it holds for the items behind it.
Learning manoeuvres are MAV_CMD_USER_1 in MAV_FRAME_MISSION: param1 0 zigzag, 1 doublets, 2 PRBS; param2 seconds;
param3 and param4 stern plane and rudder, deg; x and y of doublets and PRBS clock in ms and shift register, of a zigzag
pitch and heading in 1e-3 deg. 0 and NaN stand for `Manoeuvre`'s default; an angle of -1 keeps the fin still.

A fin-controlled vehicle cannot stay at a position: a waypoint with a hold time becomes a circle about it.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.items import (
    INVALID_PARAMS,
    MISSION_FRAME,
    RELATIVE,
    TERRAIN,
    UNSUPPORTED,
    ItemRefused,
    Limits,
    PlanItem,
    depth,
    geodetic_e7,
    has_position,
    position,
    refuse_infinite,
)
from firmware_py.mavlink.plans.path_check import PathCheck
from firmware_py.params import ParamError, dump, load
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Mission, MissionItem, Surface, Waypoint
from firmware_py.records.order import MissionChange

_LEARN: int = dialect.MAV_CMD_USER_1
_SPEED: int = dialect.MAV_CMD_DO_CHANGE_SPEED
_KEEP_SPEED, _OWN_SPEED = -1.0, -2.0
_SPEED_TYPES = (dialect.SPEED_TYPE_AIRSPEED, dialect.SPEED_TYPE_GROUNDSPEED)
_MAX_SPEED, _MAX_RADIUS, _MAX_TURNS, _MAX_DURATION, _MAX_TIMES = 100.0, 1000.0, 1e4, 1e6, 1e4
_SHORT_HOLD = 1.0
"""Stations write a hold time this short, s, for waypoints without one."""
_KINDS = (ManoeuvreKind.ZIGZAG, ManoeuvreKind.DOUBLETS, ManoeuvreKind.PRBS)


class MissionBuilder:
    """Builds a mission item by item; each is checked as it arrives, so that no tick has to check them all."""

    def __init__(self, water_frame: WaterFrame, limits: Limits) -> None:
        self._water_frame, self._path_check = water_frame, PathCheck(limits)
        self._steps: list[MissionItem] = []
        """A jump in it names an item."""
        self.item_numbers: list[int] = []
        """The item number of each step."""
        self._count = 0
        self._speed = 0.0
        self._handlers: dict[int, Callable[[PlanItem], list[MissionItem]]] = {
            dialect.MAV_CMD_NAV_WAYPOINT: self._waypoint,
            dialect.MAV_CMD_NAV_LOITER_UNLIM: self._loiter,
            dialect.MAV_CMD_NAV_LOITER_TURNS: self._loiter,
            dialect.MAV_CMD_NAV_LOITER_TIME: self._loiter,
            dialect.MAV_CMD_NAV_LAND: self._land,
            dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda _: [Surface(rally=True)],
            dialect.MAV_CMD_DO_JUMP: self._jump,
            _SPEED: self._change_speed,
            _LEARN: self._learn,
        }

    def add(self, item: PlanItem) -> None:
        """Add the next item.

        Raises:
            ItemRefused: it cannot be flown.
        """
        handler = self._handlers.get(item.command)
        if handler is None:
            raise ItemRefused(UNSUPPORTED, f"command {item.command} is not supported in missions")
        refuse_infinite(item)
        for step in handler(item):
            self._path_check.check(self._count, step)
            self._steps.append(step)
            self.item_numbers.append(self._count)
        self._count += 1

    def finish(self) -> MissionChange:
        """Return the change for `Order.changes`, the same in every call; its jumps name steps.

        Raises:
            ItemRefused: a jump to an item that does not exist.
        """
        return MissionChange(Mission(tuple(map(self._with_step_number, self._steps))))

    def _with_step_number(self, step: MissionItem) -> MissionItem:
        """Return a step; a jump leads to the first step that was made of its item or of one behind it."""
        if not isinstance(step, Jump):
            return step
        if step.to >= self._count:
            raise ItemRefused(INVALID_PARAMS[0], f"jumps to item {step.to}, of {self._count}")
        return Jump(bisect_left(self.item_numbers, step.to), step.times)

    def _waypoint(self, item: PlanItem) -> list[MissionItem]:
        position_and_speed = (*position(item, self._water_frame), *self._depth_and_speed(item))
        if item.p1 > _SHORT_HOLD:
            return [Loiter(*position_and_speed, 0.0, 0.0, _between(item.p1, 0.0, _MAX_DURATION, 0, "seconds"))]
        return [Waypoint(*position_and_speed)]

    def _loiter(self, item: PlanItem) -> list[MissionItem]:
        turns = duration = 0.0
        if item.command == dialect.MAV_CMD_NAV_LOITER_TURNS:
            turns = _between(item.p1, 0.01, _MAX_TURNS, 0, "turns")
        elif item.command == dialect.MAV_CMD_NAV_LOITER_TIME:
            duration = _between(item.p1, 0.01, _MAX_DURATION, 0, "seconds")
        radius = 0.0 if math.isnan(item.p3) else _between(item.p3, -_MAX_RADIUS, _MAX_RADIUS, 2, "metres of radius")
        if has_position(item):
            x, y = position(item, self._water_frame)
        else:
            x, y = self._previous_position()
        return [Loiter(x, y, *self._depth_and_speed(item), radius, turns, duration)]

    def _land(self, item: PlanItem) -> list[MissionItem]:
        """Surface at a position, or where the vehicle is by then."""
        if not has_position(item):
            return [Surface()]
        return [*self._waypoint(item._replace(p1=0.0)), Surface()]

    def _jump(self, item: PlanItem) -> list[MissionItem]:
        """Jump to an item; `finish` replaces its number by that of the step."""
        to, times = _between(item.p1, 0.0, 65535.0, 0, "an item"), _between(item.p2, -1.0, _MAX_TIMES, 1, "times")
        return [Jump(int(to), int(times))]

    def _change_speed(self, item: PlanItem) -> list[MissionItem]:
        if item.p1 not in _SPEED_TYPES:
            raise ItemRefused(INVALID_PARAMS[0], f"speed type {item.p1:g}: only speed ahead (0 or 1) can be changed")
        if item.p2 == _OWN_SPEED:
            self._speed = 0.0
        elif item.p2 != _KEEP_SPEED:
            self._speed = _between(item.p2, 0.01, _MAX_SPEED, 1, "m/s ahead")
        return []

    def _learn(self, item: PlanItem) -> list[MissionItem]:
        if item.p1 not in range(len(_KINDS)):
            raise ItemRefused(INVALID_PARAMS[0], f"manoeuvre {item.p1:g}: 0 zigzag, 1 doublets, 2 PRBS")
        kind = _KINDS[int(item.p1)]
        keys = {"duration_s": item.p2, "delta_s_deg": item.p3, "delta_r_deg": item.p4}
        if kind is ManoeuvreKind.ZIGZAG:
            keys |= {"pitch_deg": item.x * 1e-3, "heading_deg": item.y * 1e-3}
        else:
            keys |= {"clock_s": item.x * 1e-3, "register": item.y}
        given = {key: 0.0 if value == -1.0 else value for key, value in keys.items() if value == value and value}
        table = {"kind": kind.name.lower(), **given, "speed_m_s": self._speed}
        try:
            return [load(Manoeuvre, table, "manoeuvre")]
        except ParamError as error:
            numbers = {
                "duration_s": 1,
                "delta_s_deg": 2,
                "delta_r_deg": 3,
                "clock_s": 4,
                "pitch_deg": 4,
                "speed_m_s": 1,
            }
            number = next((n for key, n in numbers.items() if key in str(error)), 5)
            raise ItemRefused(INVALID_PARAMS[number], str(error)) from None

    def _depth_and_speed(self, item: PlanItem) -> tuple[float, float, bool]:
        z, above = depth(item, self._water_frame)
        return z, self._speed, above

    def _previous_position(self) -> tuple[float, float]:
        for step in reversed(self._steps):
            if isinstance(step, Waypoint | Loiter):
                return step.x, step.y
        raise ItemRefused(INVALID_PARAMS[4], "no position is given, and no item before it has one")


def items_of(mission: Mission, water_frame: WaterFrame) -> list[PlanItem]:
    """Return the items of which `MissionBuilder` makes this mission."""
    items: list[PlanItem] = []
    number: list[int] = []
    speed = 0.0
    for step in mission.items:
        number.append(len(items))
        wanted = _speed_of(step)
        if wanted is not None and wanted != speed:
            items.append(_item(_SPEED, MISSION_FRAME, 1.0, wanted or _OWN_SPEED))
            speed = wanted
        items.append(_item_of(step, water_frame))
    return [
        item._replace(p1=float(number[int(item.p1)])) if item.command == dialect.MAV_CMD_DO_JUMP else item
        for item in items
    ]


def _item_of(step: MissionItem, water_frame: WaterFrame) -> PlanItem:
    if isinstance(step, Waypoint):
        return _item(dialect.MAV_CMD_NAV_WAYPOINT, *_frame_to_z(step, water_frame))
    if isinstance(step, Loiter):
        command = dialect.MAV_CMD_NAV_LOITER_TIME if step.duration else dialect.MAV_CMD_NAV_LOITER_UNLIM
        command = dialect.MAV_CMD_NAV_LOITER_TURNS if step.turns else command
        frame, *_, x, y, z = _frame_to_z(step, water_frame)
        return _item(command, frame, step.turns or step.duration, 0.0, step.radius, math.nan, x, y, z)
    if isinstance(step, Jump):
        return _item(dialect.MAV_CMD_DO_JUMP, MISSION_FRAME, float(step.to), float(step.times))
    if isinstance(step, Surface):
        rally = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
        return _item(rally if step.rally else dialect.MAV_CMD_NAV_LAND, RELATIVE)
    table = dump(step)
    keys = ("pitch_deg", "heading_deg") if step.kind is ManoeuvreKind.ZIGZAG else ("clock_s", "register")
    x, y = (round(table[key] * (1 if key == "register" else 1000)) for key in keys)
    delta_s, delta_r = (table[key] or -1.0 for key in ("delta_s_deg", "delta_r_deg"))
    return _item(_LEARN, MISSION_FRAME, float(_KINDS.index(step.kind)), step.duration, delta_s, delta_r, x, y)


def _frame_to_z(
    step: Waypoint | Loiter, water_frame: WaterFrame
) -> tuple[int, float, float, float, float, int, int, float]:
    """Return the fields of an item from frame to z."""
    frame = TERRAIN if step.above else RELATIVE
    return frame, 0.0, 0.0, 0.0, math.nan, *geodetic_e7(water_frame, step.x, step.y), step.z if step.above else -step.z


def _speed_of(step: MissionItem) -> float | None:
    if isinstance(step, Manoeuvre):
        return step.speed
    return step.u if isinstance(step, Waypoint | Loiter) else None


def _item(
    command: int, frame: int, p1: float = 0.0, p2: float = 0.0, p3: float = 0.0, p4: float = 0.0,
    x: int = 0, y: int = 0, z: float = 0.0,
) -> PlanItem:  # fmt: skip
    return PlanItem(command, frame, 1, p1, p2, p3, p4, x, y, z)


def _between(value: float, low: float, high: float, param: int, what: str) -> float:
    if not low <= value <= high:
        raise ItemRefused(INVALID_PARAMS[param], f"{value:g} {what}: must be in [{low:g}, {high:g}]")
    return value
