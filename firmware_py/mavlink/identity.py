"""Whom the vehicle says it is, per link, and what its modes are called there.

Ground stations decide by the heartbeat's autopilot field what they let an operator do: as ArduPilot's submarine they
show mode names and set modes; a generic autopilot they treat by the book. The custom modes have ArduSub's numbers in
both, so that a log of one link reads like a log of the other.
"""

from __future__ import annotations

import enum
import math

from firmware_py.mavlink.codec import Message, dialect
from firmware_py.records.order import Mode


class Identity(enum.Enum):
    """What a link takes the vehicle for."""

    ARDUSUB = enum.auto()
    GENERIC = enum.auto()


_AUTOPILOT = {
    Identity.ARDUSUB: dialect.MAV_AUTOPILOT_ARDUPILOTMEGA,
    Identity.GENERIC: dialect.MAV_AUTOPILOT_GENERIC,
}
_PARAM_ENCODING = {  # of integers; exactly one may be claimed
    Identity.ARDUSUB: dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST,
    Identity.GENERIC: dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE,
}
_CAPABILITIES = dialect.MAV_PROTOCOL_CAPABILITY_MAVLINK2 | dialect.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
_VERSION = 0 << 24 | 1 << 16 | 0 << 8 | dialect.FIRMWARE_VERSION_TYPE_DEV

_MANUAL, _DEPTH_HOLD, _AUTO, _SURFACE = 19, 2, 3, 9
_CUSTOM = {
    Mode.DISARMED: _MANUAL,
    Mode.MANUAL: _MANUAL,
    Mode.HOLD: _DEPTH_HOLD,
    Mode.MISSION: _AUTO,
    Mode.SURFACE: _SURFACE,
}
_ORDERED: dict[float, Mode] = {
    _MANUAL: Mode.MANUAL,
    _DEPTH_HOLD: Mode.HOLD,
    _AUTO: Mode.MISSION,
    _SURFACE: Mode.SURFACE,
}
_PX4: dict[tuple[float, float], Mode] = {(4, 3): Mode.HOLD, (4, 4): Mode.MISSION, (4, 6): Mode.SURFACE}
"""PX4's (main, sub) mode, which MAVSDK sends to whatever is not ArduPilot: loiter, mission, land."""

KNOWN = f"Manual {_MANUAL}, Depth hold {_DEPTH_HOLD}, Auto {_AUTO}, Surface {_SURFACE}"
"""The modes that may be ordered, for people."""

_FLAGS = {
    Mode.DISARMED: dialect.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED,
    Mode.MANUAL: dialect.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED | dialect.MAV_MODE_FLAG_SAFETY_ARMED,
    Mode.HOLD: dialect.MAV_MODE_FLAG_STABILIZE_ENABLED | dialect.MAV_MODE_FLAG_SAFETY_ARMED,
    Mode.MISSION: dialect.MAV_MODE_FLAG_AUTO_ENABLED | dialect.MAV_MODE_FLAG_SAFETY_ARMED,
    Mode.SURFACE: dialect.MAV_MODE_FLAG_AUTO_ENABLED | dialect.MAV_MODE_FLAG_SAFETY_ARMED,
}


def heartbeat(identity: Identity, mode: Mode, failsafe: bool) -> Message:
    """HEARTBEAT of a submarine; CRITICAL while a failsafe brings it up."""
    status = dialect.MAV_STATE_STANDBY if mode is Mode.DISARMED else dialect.MAV_STATE_ACTIVE
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_SUBMARINE,
        _AUTOPILOT[identity],
        _FLAGS[mode] | dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        _CUSTOM[mode],
        dialect.MAV_STATE_CRITICAL if failsafe else status,
        3,
    )


def autopilot_version(identity: Identity) -> Message:
    """AUTOPILOT_VERSION: what of the protocol is spoken here."""
    nothing = bytes(8)
    capabilities = _CAPABILITIES | _PARAM_ENCODING[identity]
    return dialect.MAVLink_autopilot_version_message(
        capabilities, _VERSION, 0, 0, 0, nothing, nothing, nothing, 0, 0, 0, bytes(18)
    )


def mode_of(custom: float, sub: float = 0.0) -> Mode | None:
    """The mode that DO_SET_MODE's param2 and param3 ask for, None if there is none.

    With `sub` it is PX4's main and sub mode, without it is a custom mode of ours; NaN is 0.
    """
    custom, sub = (0.0 if math.isnan(value) else value for value in (custom, sub))
    return _PX4.get((custom, sub)) if sub else _ORDERED.get(custom)
