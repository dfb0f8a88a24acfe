"""The identity of the vehicle on a link: HEARTBEAT, AUTOPILOT_VERSION and PROTOCOL_VERSION.

Ground stations decide by the heartbeat's autopilot field what an operator may do. For an ArduPilot submarine they show
mode names and set modes; a generic autopilot they treat by the standard alone.
"""

from __future__ import annotations

from firmware_py import __version__
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.message_definitions import PROTOCOL_VERSION
from firmware_py.mavlink.base.modes import Identity, custom_mode, shown_mode
from firmware_py.records.command import ModeState
from firmware_py.records.order import Mode

__all__ = ["Identity", "autopilot", "autopilot_version", "base_mode", "heartbeat", "protocol_version"]

_AUTOPILOT = {
    Identity.ARDUSUB: dialect.MAV_AUTOPILOT_ARDUPILOTMEGA,
    Identity.GENERIC: dialect.MAV_AUTOPILOT_GENERIC,
}
_PARAM_ENCODING = {  # encoding of integer parameters; exactly one may be declared
    Identity.ARDUSUB: dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST,
    Identity.GENERIC: dialect.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE,
}
_CAPABILITIES = (
    dialect.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | dialect.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | dialect.MAV_PROTOCOL_CAPABILITY_FTP
    | dialect.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | dialect.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | dialect.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    | dialect.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | dialect.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
)
_MAVLINK_1, _MAVLINK_2 = 100, 200
"""PROTOCOL_VERSION counts in hundredths: MAVLink 1 is parsed, MAVLink 2 is sent."""
_NO_HASH = bytes(8)

_ARMED = dialect.MAV_MODE_FLAG_SAFETY_ARMED
_FLAGS = {
    Mode.MANUAL: dialect.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED,
    Mode.HOLD: dialect.MAV_MODE_FLAG_STABILIZE_ENABLED,
    Mode.MISSION: dialect.MAV_MODE_FLAG_AUTO_ENABLED,
    Mode.SURFACE: dialect.MAV_MODE_FLAG_AUTO_ENABLED,
    Mode.LOITER: dialect.MAV_MODE_FLAG_GUIDED_ENABLED,
    Mode.GUIDED: dialect.MAV_MODE_FLAG_GUIDED_ENABLED,
    Mode.RETURN: dialect.MAV_MODE_FLAG_AUTO_ENABLED,
}


def _sw_version(version: str) -> int:
    """Return a version, such as 0.3.0 or 0.3.0.dev0, as AUTOPILOT_VERSION has it: a byte each, and the type."""
    major, minor, patch, *more = version.split(".")
    kind = dialect.FIRMWARE_VERSION_TYPE_DEV if more else dialect.FIRMWARE_VERSION_TYPE_OFFICIAL
    return int(major) << 24 | int(minor) << 16 | int(patch) << 8 | int(kind)


def heartbeat(identity: Identity, decided: ModeState, state: int) -> Message:
    """Return HEARTBEAT of a submarine; `state` is the MAV_STATE."""
    number = custom_mode(identity, shown_mode(decided))
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_SUBMARINE, autopilot(identity), base_mode(decided), number, state, 3
    )


def autopilot(identity: Identity) -> int:
    """Return the MAV_AUTOPILOT of an identity."""
    return int(_AUTOPILOT[identity])


def base_mode(decided: ModeState) -> int:
    """Return the MAV_MODE_FLAGs of the mode that is shown, and whether the vehicle is armed."""
    armed = 0 if decided.mode is Mode.DISARMED else _ARMED
    return int(_FLAGS[shown_mode(decided)] | armed | dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)


def autopilot_version(identity: Identity) -> Message:
    """Return AUTOPILOT_VERSION: the parts of the protocol that the vehicle implements."""
    unknown = bytes(8)
    capabilities = _CAPABILITIES | _PARAM_ENCODING[identity]
    return dialect.MAVLink_autopilot_version_message(
        capabilities, _sw_version(__version__), 0, 0, 0, unknown, unknown, unknown, 0, 0, 0, bytes(18)
    )


def protocol_version() -> Message:
    """Return PROTOCOL_VERSION, without hashes: there is no repository of message definitions behind this vehicle."""
    return PROTOCOL_VERSION.message(_MAVLINK_2, _MAVLINK_1, _MAVLINK_2, _NO_HASH, _NO_HASH)
