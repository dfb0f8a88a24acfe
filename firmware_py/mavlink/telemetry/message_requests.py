"""Requests of messages: once, at intervals, or as data streams (the older groups of messages)."""

from __future__ import annotations

from collections.abc import Callable, Container

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import (
    ACCEPTED,
    UNSUPPORTED,
    Command,
    CommandHandler,
    CommandRefused,
    LinkOutput,
    message_id_of,
)
from firmware_py.mavlink.base.message_definitions import PROTOCOL_VERSION
from firmware_py.mavlink.base.modes import Identity, available_modes
from firmware_py.mavlink.telemetry.streams import Streams
from firmware_py.tick import Tick

_HEARTBEAT, _VERSION = dialect.MAVLINK_MSG_ID_HEARTBEAT, dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION
_MODES, _INTERVAL = dialect.MAVLINK_MSG_ID_AVAILABLE_MODES, dialect.MAVLINK_MSG_ID_MESSAGE_INTERVAL
_HIGH_LATENCY = dialect.MAVLINK_MSG_ID_HIGH_LATENCY2
_ALL = dialect.MAV_DATA_STREAM_ALL
_GROUPS: dict[int, tuple[int, ...]] = {
    dialect.MAV_DATA_STREAM_RAW_SENSORS: (
        dialect.MAVLINK_MSG_ID_SCALED_IMU,
        dialect.MAVLINK_MSG_ID_SCALED_PRESSURE2,
    ),
    dialect.MAV_DATA_STREAM_EXTENDED_STATUS: (
        dialect.MAVLINK_MSG_ID_SYS_STATUS,
        dialect.MAVLINK_MSG_ID_GPS_RAW_INT,
        dialect.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT,
        dialect.MAVLINK_MSG_ID_MISSION_CURRENT,
    ),
    dialect.MAV_DATA_STREAM_RC_CHANNELS: (dialect.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW,),
    dialect.MAV_DATA_STREAM_POSITION: (
        dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    ),
    dialect.MAV_DATA_STREAM_EXTRA1: (dialect.MAVLINK_MSG_ID_ATTITUDE,),
    dialect.MAV_DATA_STREAM_EXTRA2: (dialect.MAVLINK_MSG_ID_VFR_HUD, dialect.MAVLINK_MSG_ID_ALTITUDE),
    dialect.MAV_DATA_STREAM_EXTRA3: (
        dialect.MAVLINK_MSG_ID_BATTERY_STATUS,
        dialect.MAVLINK_MSG_ID_SYSTEM_TIME,
        dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR,
        dialect.MAVLINK_MSG_ID_RPM,
    ),
}
"""ArduPilot's groups, as far as the vehicle has these messages."""


class MessageRequests:
    """Of one link. `messages` are the ids that may be asked for."""

    def __init__(self, output: LinkOutput, identity: Identity, streams: Streams, encoders: Container[int]) -> None:
        self._output, self._identity, self._streams, self._encoders = output, identity, streams, encoders

    def command_handlers(self) -> dict[int, CommandHandler]:
        """Return the handler of each command."""
        return {
            dialect.MAV_CMD_REQUEST_MESSAGE: self._request,
            dialect.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            dialect.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
            dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: self._capabilities,
            dialect.MAV_CMD_REQUEST_PROTOCOL_VERSION: self._protocol,
            dialect.MAV_CMD_CONTROL_HIGH_LATENCY: self._high_latency,
        }

    def message_handlers(self) -> dict[int, Callable[[Tick, Message], None]]:
        """See `service.Service`."""
        return {dialect.MAVLINK_MSG_ID_REQUEST_DATA_STREAM: self._data_stream}

    def _request(self, _: Tick, command: Command) -> int | None:
        message_id, which = map(message_id_of, command.params[:2])
        if message_id == _MODES:
            modes = available_modes(self._identity, which)
            if not modes:
                raise CommandRefused(f"there is no mode {which}; 0 asks for all of them")
            for mode in modes:
                self._output.send(mode)
            return ACCEPTED
        if message_id == _INTERVAL:
            return self._send_interval(which)
        if message_id not in self._encoders:
            return UNSUPPORTED
        self._output.send_from_cycle(message_id)
        return ACCEPTED

    def _set_interval(self, tick: Tick, command: Command) -> int:
        message_id = message_id_of(command.params[0])
        if message_id not in self._encoders:
            return UNSUPPORTED
        if message_id == _HEARTBEAT:  # without it, stations lose the vehicle
            raise CommandRefused("the heartbeat keeps its rate")
        if not self._streams.set_interval(message_id, command.params[1], tick.t_ns):
            raise CommandRefused(f"{command.params[1]:g} us is not an interval; -1 is never, 0 the default")
        return ACCEPTED

    def _get_interval(self, _: Tick, command: Command) -> int:
        return self._send_interval(message_id_of(command.params[0]))

    def _send_interval(self, message_id: int) -> int:
        """Answer with MESSAGE_INTERVAL: 0 for a message that is not supported, -1 for one that is not sent."""
        known = message_id in self._encoders
        if 0 <= message_id < 2**16:
            interval = self._streams.interval_us(message_id) if known else 0
            self._output.send(dialect.MAVLink_message_interval_message(message_id, interval))
        if not known:
            raise CommandRefused(f"message {message_id} is not supported")
        return ACCEPTED

    def _capabilities(self, _: Tick, command: Command) -> int:
        if command.params[0] != 1.0:
            raise CommandRefused(f"{command.params[0]:g} asks for nothing; 1 asks for AUTOPILOT_VERSION")
        self._output.send_from_cycle(_VERSION)
        return ACCEPTED

    def _protocol(self, _: Tick, command: Command) -> int:
        if command.params[0] != 1.0:
            raise CommandRefused(f"{command.params[0]:g} asks for nothing; 1 asks for PROTOCOL_VERSION")
        self._output.send_from_cycle(PROTOCOL_VERSION.id)
        return ACCEPTED

    def _high_latency(self, tick: Tick, command: Command) -> int:
        if command.params[0] not in (0.0, 1.0):
            raise CommandRefused(f"{command.params[0]:g} is neither on (1) nor off (0)")
        self._streams.set_interval(_HIGH_LATENCY, 5e6 if command.params[0] else -1.0, tick.t_ns)
        return ACCEPTED

    def _data_stream(self, tick: Tick, m: Message) -> None:
        """Set the rate of a group, or of all; stopped or at 0 Hz they are not sent."""
        on = m.start_stop == 1 and m.req_message_rate > 0
        interval = 1e6 / m.req_message_rate if on else -1.0
        groups = _GROUPS.values() if m.req_stream_id == _ALL else [_GROUPS.get(m.req_stream_id, ())]
        for group in groups:
            for message_id in group:
                if message_id in self._encoders:
                    self._streams.set_interval(message_id, interval, tick.t_ns)
