"""An item of a plan (mission, fence, rally points) as stations send it, and its position in the local frame."""

from __future__ import annotations

import json
import math
import struct
from typing import NamedTuple

from firmware_py.marine import Eta, local_to_geodetic
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import NO_FRAME, CommandRefused
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.records.fence import NO_FENCE, Fence
from firmware_py.records.turning import AS_ASKED, Turning

ACCEPTED: int = dialect.MAV_MISSION_ACCEPTED
ERROR: int = dialect.MAV_MISSION_ERROR
UNSUPPORTED: int = dialect.MAV_MISSION_UNSUPPORTED
UNSUPPORTED_FRAME: int = dialect.MAV_MISSION_UNSUPPORTED_FRAME
INVALID: int = dialect.MAV_MISSION_INVALID
INVALID_PARAMS: tuple[int, ...] = (
    dialect.MAV_MISSION_INVALID_PARAM1,
    dialect.MAV_MISSION_INVALID_PARAM2,
    dialect.MAV_MISSION_INVALID_PARAM3,
    dialect.MAV_MISSION_INVALID_PARAM4,
    dialect.MAV_MISSION_INVALID_PARAM5_X,
    dialect.MAV_MISSION_INVALID_PARAM6_Y,
    dialect.MAV_MISSION_INVALID_PARAM7,
)
RELATIVE: int = dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT
TERRAIN: int = dialect.MAV_FRAME_GLOBAL_TERRAIN_ALT
MISSION_FRAME: int = dialect.MAV_FRAME_MISSION
_LOCAL, _OFFSET = dialect.MAV_FRAME_LOCAL_NED, dialect.MAV_FRAME_LOCAL_OFFSET_NED
_TERRAIN = (TERRAIN, dialect.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT)
_GLOBAL = (0, 5, 3, 6, *_TERRAIN)
_E7, _E4 = 1e7, 1e4
_INT_MAX = 2**31 - 1
_PACKED = struct.Struct("<HBB4fiif")


class ItemRefused(Exception):
    """Why an item is refused: the MAV_MISSION_RESULT and a sentence."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class PlanItem(NamedTuple):
    """An item as MISSION_ITEM_INT has it, without its number; `x` and `y` in 1e-7 deg or 1e-4 m."""

    command: int
    frame: int
    autocontinue: int
    p1: float
    p2: float
    p3: float
    p4: float
    x: int
    y: int
    z: float

    @property
    def params(self) -> tuple[float, float, float, float]:
        """The first four parameters."""
        return self.p1, self.p2, self.p3, self.p4

    @property
    def text(self) -> str:
        """The item as JSON, NaN as null."""
        return json.dumps([None if value != value else value for value in self])

    @property
    def packed(self) -> bytes:
        """The item as bytes, for the plan's id: equal numbers give equal bytes."""
        return _PACKED.pack(*self)


class Limits(NamedTuple):
    """The limits of a mission: greatest depth and least altitude, m, the fence, and how tightly the vehicle turns."""

    depth_max: float
    altitude_min: float
    fence: Fence
    turning: Turning


UNLIMITED = Limits(math.inf, 0.0, NO_FENCE, AS_ASKED)
"""For a plan that was checked before."""


def item_from_message(message: Message) -> PlanItem:
    """Return the item of MISSION_ITEM_INT, or of MISSION_ITEM, whose x and y are in degrees or metres."""
    x, y = message.x, message.y
    if message.get_msgId() == dialect.MAVLINK_MSG_ID_MISSION_ITEM:
        scale = _E7 if message.frame in _GLOBAL else _E4 if message.frame in (_LOCAL, _OFFSET) else 1.0
        x, y = (_int32(value * scale) for value in (x, y))
    params = (message.param1, message.param2, message.param3, message.param4)
    return PlanItem(message.command, message.frame, message.autocontinue, *params, x, y, message.z)


def item_from_json(row: list[float | None]) -> PlanItem:
    """Return the item of a row that `PlanItem.text` wrote.

    Raises:
        TypeError: the row has another length, or a value that its field cannot hold.
    """
    item = PlanItem(*[math.nan if value is None else value for value in row])  # type: ignore[arg-type]
    try:
        _PACKED.pack(*item)
    except struct.error as error:
        raise TypeError(str(error)) from None
    return item


def xy_of(item: PlanItem) -> tuple[float, float]:
    """Return x and y as MISSION_ITEM has them."""
    scale = _E7 if item.frame in _GLOBAL else _E4 if item.frame == _LOCAL else 1.0
    return item.x / scale, item.y / scale


def has_position(item: PlanItem) -> bool:
    """Return whether the item has a position; latitude and longitude 0 count as none."""
    return _INT_MAX not in (item.x, item.y) and not (item.frame in _GLOBAL and item.x == item.y == 0)


def position(item: PlanItem, water_frame: WaterFrame) -> tuple[float, float]:
    """Return (x, y), m.

    Raises:
        ItemRefused: the frame is not supported, or it is not a position.
    """
    if item.frame not in (*_GLOBAL, _LOCAL):
        raise ItemRefused(UNSUPPORTED_FRAME, f"frame {item.frame} is not supported; use a global frame or LOCAL_NED")
    if item.frame == _LOCAL:
        return item.x / _E4, item.y / _E4  # int32 in 1e-4 m ends at 215 km
    try:
        return water_frame.position(item.x / _E7, item.y / _E7)
    except CommandRefused as refusal:
        geodetic_e7 = INVALID_PARAMS[5] if abs(item.y) > 180 * _E7 else INVALID_PARAMS[4]
        raise ItemRefused(geodetic_e7, str(refusal)) from None


def depth(item: PlanItem, water_frame: WaterFrame) -> tuple[float, bool]:
    """Return depth, m, and False; or altitude above the bottom, m, and True.

    Raises:
        ItemRefused: it is above the water, or not finite.
    """
    bad = INVALID_PARAMS[6]
    if not math.isfinite(item.z):
        raise ItemRefused(bad, f"{item.z:g} is not a height")
    if item.frame in _TERRAIN:
        return item.z, True
    try:
        return water_frame.depth(item.frame, item.z), False
    except CommandRefused as refusal:
        raise ItemRefused(UNSUPPORTED_FRAME if refusal.result == NO_FRAME else bad, str(refusal)) from None


def resolve_offset(item: PlanItem, here: Eta | None) -> PlanItem:
    """Return an offset from the vehicle as an item in LOCAL_NED; other items unchanged.

    `here` is where the vehicle is, None if that is unknown.

    Raises:
        ItemRefused: the vehicle's position is unknown, or the offset is too large.
    """
    if item.frame != _OFFSET:
        return item
    if here is None:
        unknown = "an offset from the vehicle, whose position is unknown; use a global frame or LOCAL_NED"
        raise ItemRefused(UNSUPPORTED_FRAME, unknown)
    x, y = _int32(item.x + here.x * _E4), _int32(item.y + here.y * _E4)
    if _INT_MAX in (item.x, item.y, x, y):
        raise ItemRefused(INVALID_PARAMS[4], "the offset is not a position")
    return item._replace(frame=_LOCAL, x=x, y=y, z=item.z + here.z)


def geodetic_e7(water_frame: WaterFrame, x: float, y: float) -> tuple[int, int]:
    """Return latitude and longitude of (x, y), m, in 1e-7 deg."""
    latitude, longitude = local_to_geodetic(water_frame.origin, x, y)
    return round(math.degrees(latitude) * _E7), round(math.degrees(longitude) * _E7)


def refuse_infinite(item: PlanItem) -> None:
    """Check the first four parameters; NaN leaves one open.

    Raises:
        ItemRefused: one of them is infinite.
    """
    for value, code in zip(item.params, INVALID_PARAMS, strict=False):
        if math.isinf(value):
            raise ItemRefused(code, "a parameter is infinite")


def _int32(value: float) -> int:
    return round(value) if math.isfinite(value) and abs(value) < _INT_MAX else _INT_MAX
