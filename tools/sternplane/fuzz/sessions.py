"""Messages of ground stations, as pymavlink packs them: one conversation after the other, message by message.

They are what is played, mutated and forged; and whatever message id, command and parameter occurs in them is one that
the vehicle knows, so that extreme values are sent under these far more often than under the hundreds of others.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

from pymavlink.dialects.v20 import all as mav  # type: ignore[import-untyped]

Message = Any
"""One of the dialect's MAVLink_*_message."""

SYSTEM, COMPONENT = 255, 190
"""The station."""
_VEHICLE = (1, 1)
_HERE = (465000000, 66000000)
"""Latitude and longitude, 1e-7 deg, of no place in particular; the recordings are laid around the vehicle's own."""
_MISSIONS = (mav.MAV_MISSION_TYPE_MISSION, mav.MAV_MISSION_TYPE_FENCE, mav.MAV_MISSION_TYPE_RALLY)
_FTP = struct.Struct("<HBBBBBxI")
MODES = (19, 2, 16, 4, 3, 9)


def sessions(names: Sequence[str], here: tuple[int, int] = _HERE) -> list[list[Message]]:
    """Return every conversation; `names` are the vehicle's parameters, `here` its place, 1e-7 deg."""
    flown = [_fly(), _steer(here)] * 3  # what comes of the rest shows in a vehicle that is armed
    return [_connect(here), *flown, _parameters(names), _files(), _logs(), *_uploads(here), _upkeep(here)]


def long(command: int, *params: float, again: int = 0) -> Message:
    """Return COMMAND_LONG with some of its seven parameters."""
    return mav.MAVLink_command_long_message(*_VEHICLE, command, again, *(*params, *(0.0,) * (7 - len(params))))


def command_int(command: int, frame: int, *params: float) -> Message:
    """Return COMMAND_INT with all of its seven parameters."""
    p1, p2, p3, p4, x, y, z = params
    return mav.MAVLink_command_int_message(*_VEHICLE, frame, command, 0, 0, p1, p2, p3, p4, int(x), int(y), z)


def _connect(here: tuple[int, int]) -> list[Message]:
    asked = (mav.MAVLINK_MSG_ID_AUTOPILOT_VERSION, mav.MAVLINK_MSG_ID_AVAILABLE_MODES, mav.MAVLINK_MSG_ID_HOME_POSITION)
    return [
        mav.MAVLink_heartbeat_message(mav.MAV_TYPE_GCS, mav.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3),
        *(long(mav.MAV_CMD_REQUEST_MESSAGE, name) for name in asked),
        long(mav.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1),
        long(mav.MAV_CMD_SET_MESSAGE_INTERVAL, mav.MAVLINK_MSG_ID_ATTITUDE, 20000),
        long(mav.MAV_CMD_GET_MESSAGE_INTERVAL, mav.MAVLINK_MSG_ID_ATTITUDE),
        long(mav.MAV_CMD_SET_MESSAGE_INTERVAL, mav.MAVLINK_MSG_ID_ATTITUDE, 0),
        long(mav.MAV_CMD_CONTROL_HIGH_LATENCY, 0),
        mav.MAVLink_request_data_stream_message(*_VEHICLE, mav.MAV_DATA_STREAM_ALL, 4, 1),
        mav.MAVLink_timesync_message(0, 4711),
        mav.MAVLink_ping_message(4711, 1, 0, 0),
        mav.MAVLink_system_time_message(1_800_000_000_000_000, 0),
        mav.MAVLink_set_gps_global_origin_message(1, *here, 0),
        mav.MAVLink_set_home_position_message(1, *here, 0, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0),
    ]


def _fly() -> list[Message]:
    custom = mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    return [
        long(mav.MAV_CMD_RUN_PREARM_CHECKS),
        long(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1),
        long(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1, again=1),
        *(long(mav.MAV_CMD_DO_SET_MODE, custom, mode) for mode in MODES[:-1]),
        long(mav.MAV_CMD_DO_SET_MODE, custom, 4, 3),
        mav.MAVLink_set_mode_message(1, custom, MODES[1]),
        long(mav.MAV_CMD_DO_SET_STANDARD_MODE, mav.MAV_STANDARD_MODE_MISSION),
        long(mav.MAV_CMD_MISSION_START, 1, 2),
        long(mav.MAV_CMD_DO_PAUSE_CONTINUE, 0),
        long(mav.MAV_CMD_DO_PAUSE_CONTINUE, 1),
        long(mav.MAV_CMD_DO_SET_MISSION_CURRENT, 1),
        mav.MAVLink_mission_set_current_message(*_VEHICLE, 1),
        long(mav.MAV_CMD_NAV_LOITER_UNLIM),
        mav.MAVLink_manual_control_message(1, 300, -200, 500, 100, 0),
    ]


def _steer(here: tuple[int, int]) -> list[Message]:
    relative, nan, north = mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, math.nan, here[0] + 5000
    place, depth, heading = 0b110111111000, 0b110111111011, 0b100111111111
    guided = long(mav.MAV_CMD_DO_SET_MODE, mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, MODES[3])
    return [
        long(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1),
        guided,
        command_int(mav.MAV_CMD_DO_REPOSITION, relative, 1.5, 1, 0, nan, north, here[1], -6),
        long(mav.MAV_CMD_DO_CHANGE_SPEED, 1, 1.2),
        long(mav.MAV_CMD_GUIDED_CHANGE_SPEED, 1, 1.4),
        long(mav.MAV_CMD_DO_CHANGE_ALTITUDE, -8, mav.MAV_FRAME_GLOBAL_RELATIVE_ALT),
        command_int(mav.MAV_CMD_GUIDED_CHANGE_ALTITUDE, relative, 0, 0, 0, 0, 0, 0, -7),
        long(mav.MAV_CMD_CONDITION_YAW, 45, 0, 1, 1),
        long(mav.MAV_CMD_GUIDED_CHANGE_HEADING, 1, 120, 1),
        mav.MAVLink_set_position_target_local_ned_message(0, *_VEHICLE, 1, depth, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0),
        mav.MAVLink_set_position_target_local_ned_message(0, *_VEHICLE, 1, heading, 0, 0, 0, 1, 1, 0, 0, 0, 0, 2, 0),
        mav.MAVLink_set_position_target_global_int_message(
            *(0, *_VEHICLE, relative, place, north, here[1], -5, 0, 0, 0, 0, 0, 0, 0, 0)
        ),
        mav.MAVLink_set_attitude_target_message(0, *_VEHICLE, 7, [1, 0, 0, 0], 0, 0, 0, 0.5),
    ]


def _parameters(names: Sequence[str]) -> list[Message]:
    known = [name.encode() for name in names]
    return [
        mav.MAVLink_param_request_list_message(*_VEHICLE),
        *(mav.MAVLink_param_request_read_message(*_VEHICLE, name, -1) for name in known[:3]),
        mav.MAVLink_param_request_read_message(*_VEHICLE, b"", 2),
        mav.MAVLink_param_request_read_message(*_VEHICLE, b"NO_SUCH", -1),
        *(
            mav.MAVLink_param_set_message(*_VEHICLE, name, value, kind)
            for i, name in enumerate(known)
            for value, kind in (((0.5, 1.0, 2.0, 10.0)[i % 4], 9), (i % 3 * 1e-45, 6))
        ),
    ]


def ftp(number: int, op: int, data: bytes = b"", session: int = 0, offset: int = 0, size: int | None = None) -> Message:
    """Return a request of MAVLink FTP."""
    head = _FTP.pack(number, session, op, len(data) if size is None else size, 0, 0, offset)
    return mav.MAVLink_file_transfer_protocol_message(0, *_VEHICLE, (head + data).ljust(251, b"\0"))


def _files() -> list[Message]:
    listed = [ftp(i, 3, path) for i, path in enumerate((b"/", b"@PARAM", b"logs", b"nowhere"))]
    fetched = [
        message
        for i, path in enumerate((b"@PARAM/param.pck", b"general.json", b"logs/one.mcap"))
        for message in (
            ftp(8 * i + 4, 4, path),
            ftp(8 * i + 5, 5, size=239),
            ftp(8 * i + 6, 5, offset=239, size=80),
            ftp(8 * i + 7, 15, size=239),
            ftp(8 * i + 8, 14, path),
            ftp(8 * i + 9, 1),
        )
    ]
    written = [ftp(40 + op, op, b"logs/one.mcap") for op in range(6, 14)]
    return [ftp(0, 2), *listed, *fetched, *written, ftp(60, 2)]


def _logs() -> list[Message]:
    return [
        mav.MAVLink_log_request_list_message(*_VEHICLE, 0, 0xFFFF),
        mav.MAVLink_log_request_data_message(*_VEHICLE, 1, 0, 4000),
        mav.MAVLink_log_request_data_message(*_VEHICLE, 2, 900, 0xFFFFFFFF),
        mav.MAVLink_log_request_end_message(*_VEHICLE),
        mav.MAVLink_log_erase_message(*_VEHICLE),
    ]


def item(kind: int, seq: int, frame: int, command: int, *params: float) -> Message:
    """Return MISSION_ITEM_INT with all of its seven parameters."""
    p1, p2, p3, p4, x, y, z = params
    return mav.MAVLink_mission_item_int_message(
        *_VEHICLE, seq, frame, command, 0, 1, p1, p2, p3, p4, int(x), int(y), z, kind
    )


def plan_items(here: tuple[int, int]) -> dict[int, list[Message]]:
    """Return a mission, a fence and rally points, by their type: items as stations upload them."""
    relative, (lat, lon), nan = mav.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, here, math.nan
    mission, fence, rally = _MISSIONS
    legs: list[tuple[int, int, tuple[float, ...]]] = [
        (mav.MAV_FRAME_GLOBAL, mav.MAV_CMD_NAV_WAYPOINT, (0, 0, 0, 0, lat, lon, 0)),
        (relative, mav.MAV_CMD_NAV_WAYPOINT, (0, 0, 0, nan, lat + 5000, lon, -5)),
        (mav.MAV_FRAME_MISSION, mav.MAV_CMD_DO_CHANGE_SPEED, (1, 1.5, -1, 0, 0, 0, 0)),
        (mav.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT, mav.MAV_CMD_NAV_WAYPOINT, (0, 0, 0, nan, lat + 9000, lon, 8)),
        (relative, mav.MAV_CMD_NAV_LOITER_TURNS, (2, 0, 20, 0, lat + 9000, lon + 4000, -7)),
        (relative, mav.MAV_CMD_NAV_LOITER_TIME, (10, 0, 20, 0, lat + 9000, lon + 4000, -7)),
        (mav.MAV_FRAME_MISSION, mav.MAV_CMD_USER_1, (3, 20, 10, 10, 0, 0, 0)),
        (mav.MAV_FRAME_MISSION, mav.MAV_CMD_DO_JUMP, (1, 2, 0, 0, 0, 0, 0)),
        (mav.MAV_FRAME_LOCAL_NED, mav.MAV_CMD_NAV_WAYPOINT, (0, 0, 0, nan, 100 * 1e4, 20 * 1e4, 6)),
        (relative, mav.MAV_CMD_NAV_LOITER_UNLIM, (0, 0, 20, 0, lat + 9000, lon, -7)),
        (relative, mav.MAV_CMD_NAV_LAND, (0, 0, 0, 0, lat, lon, 0)),
        (mav.MAV_FRAME_MISSION, mav.MAV_CMD_NAV_RETURN_TO_LAUNCH, (0, 0, 0, 0, 0, 0, 0)),
    ]
    inside, vertex = mav.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
    outside, far = mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION, 40000
    marks = [(vertex, 4, lat + x * far, lon + y * far) for x, y in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    marks += [(inside, 900, lat, lon), (outside, 30, lat + far // 2, lon)]
    places: list[tuple[int, list[tuple[int, int, tuple[float, ...]]]]] = [
        (mission, legs),
        (fence, [(mav.MAV_FRAME_GLOBAL_INT, command, (size, 0, 0, 0, x, y, 0)) for command, size, x, y in marks]),
        (rally, [(relative, mav.MAV_CMD_NAV_RALLY_POINT, (0, 0, 0, 0, lat + 3000 * i, lon, 0)) for i in range(2)]),
    ]
    return {
        kind: [item(kind, i, frame, command, *params) for i, (frame, command, params) in enumerate(of_kind)]
        for kind, of_kind in places
    }


def _uploads(here: tuple[int, int]) -> list[list[Message]]:
    """Return conversations that upload each type and fetch it again, then clear all of it."""
    conversations = []
    for kind, items in plan_items(here).items():
        whole_list = [mav.MAVLink_mission_request_list_message(*_VEHICLE, kind)]
        fetched = [mav.MAVLink_mission_request_int_message(*_VEHICLE, seq, kind) for seq in range(len(items))]
        older = [
            mav.MAVLink_mission_request_message(*_VEHICLE, 0, kind),
            mav.MAVLink_mission_ack_message(*_VEHICLE, 0, kind),
        ]
        conversations.append(
            [mav.MAVLink_mission_count_message(*_VEHICLE, len(items), kind), *items, *whole_list, *fetched, *older]
        )
    float_item = mav.MAVLink_mission_item_message(
        *_VEHICLE, 0, 3, mav.MAV_CMD_NAV_WAYPOINT, 0, 1, 0, 0, 0, 0, 46.5, 6.6, -5
    )
    partial = (
        mav.MAVLink_mission_write_partial_list_message(*_VEHICLE, 0, 1),
        mav.MAVLink_mission_request_partial_list_message(*_VEHICLE, 0, 1),
    )
    cleared = [mav.MAVLink_mission_clear_all_message(*_VEHICLE, kind) for kind in (*_MISSIONS, 255)]
    conversations.append([mav.MAVLink_mission_count_message(*_VEHICLE, 1), float_item, *partial, *cleared])
    return conversations


def _upkeep(here: tuple[int, int]) -> list[Message]:
    return [
        command_int(mav.MAV_CMD_DO_SET_HOME, mav.MAV_FRAME_GLOBAL, 0, 0, 0, 0, *here, 0),
        long(mav.MAV_CMD_DO_SET_HOME, 1),
        long(mav.MAV_CMD_PREFLIGHT_CALIBRATION, 1),
        long(mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1),
        long(mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 2),
        long(mav.MAV_CMD_DO_PARACHUTE, 2),
        long(mav.MAV_CMD_NAV_RETURN_TO_LAUNCH),
        long(mav.MAV_CMD_NAV_LAND),
        long(mav.MAV_CMD_COMPONENT_ARM_DISARM, 0),
    ]
