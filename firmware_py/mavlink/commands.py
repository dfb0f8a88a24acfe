"""COMMAND_LONG, COMMAND_INT and SET_MODE: every command gets one answer, if only that it is not supported."""

from __future__ import annotations

import math
from collections.abc import Callable, Container
from typing import NamedTuple, Protocol

from firmware_py.mavlink.codec import Message, dialect
from firmware_py.mavlink.identity import KNOWN, mode_of
from firmware_py.mavlink.orders import Orders, Wish
from firmware_py.mavlink.streams import Streams
from firmware_py.records.order import Arming, Mode
from firmware_py.schedule import Tick

_ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
_DENIED: int = dialect.MAV_RESULT_DENIED
_UNSUPPORTED: int = dialect.MAV_RESULT_UNSUPPORTED
_VERSION, _HEARTBEAT = dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION, dialect.MAVLINK_MSG_ID_HEARTBEAT


class Voice(Protocol):
    """The link that a command came by."""

    def say(self, message: Message) -> None:
        """Sends a message."""

    def tell(self, text: str, matters: int) -> None:
        """Sends a sentence."""

    def show(self, name: int) -> None:
        """Sends a message that is made of the next cycle."""


class _Command(NamedTuple):
    """What both kinds of command have in common; x and y of COMMAND_INT are the fifth and sixth of `params`."""

    system: int
    component: int
    number: int
    again: bool
    params: tuple[float, ...]


class Commands:
    """The commands of one link. `messages` are the ids that may be asked for."""

    def __init__(self, link: int, voice: Voice, orders: Orders, streams: Streams, messages: Container[int]) -> None:
        self._link = link
        self._voice = voice
        self._orders = orders
        self._streams = streams
        self._messages = messages
        # Each returns its result, or None if the answer comes with the cycle that obeys.
        self._do: dict[int, Callable[[Tick, _Command], int | None]] = {
            dialect.MAV_CMD_COMPONENT_ARM_DISARM: self._arm,
            dialect.MAV_CMD_DO_SET_MODE: self._set_mode,
            dialect.MAV_CMD_REQUEST_MESSAGE: self._request_message,
            dialect.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: self._capabilities,
        }

    def hears(self) -> dict[int, Callable[[Tick, Message], None]]:
        """The message ids that come here."""
        return {
            dialect.MAVLINK_MSG_ID_COMMAND_LONG: self._long,
            dialect.MAVLINK_MSG_ID_COMMAND_INT: self._int,
            dialect.MAVLINK_MSG_ID_SET_MODE: self._old_set_mode,
        }

    def answer(self, wish: Wish, result: int) -> None:
        """COMMAND_ACK for a wish."""
        self._acknowledge(wish.command, result, wish.system, wish.component)

    def _long(self, tick: Tick, m: Message) -> None:
        params = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
        self._obey(tick, _Command(m.get_srcSystem(), m.get_srcComponent(), m.command, m.confirmation > 0, params))

    def _int(self, tick: Tick, m: Message) -> None:
        params = (m.param1, m.param2, m.param3, m.param4, float(m.x), float(m.y), m.z)
        self._obey(tick, _Command(m.get_srcSystem(), m.get_srcComponent(), m.command, False, params))

    def _obey(self, tick: Tick, command: _Command) -> None:
        do = self._do.get(command.number)
        result = _UNSUPPORTED if do is None else do(tick, command)
        if result is not None:
            self._acknowledge(command.number, result, command.system, command.component)

    def _acknowledge(self, number: int, result: int, system: int, component: int) -> None:
        self._voice.say(dialect.MAVLink_command_ack_message(number, result, 0, 0, system, component))

    def _arm(self, tick: Tick, command: _Command) -> int | None:
        """Nobody arms by force: what param2 says to that is not heard, the supervisor's checks hold."""
        arming = {1.0: Arming.ARM, 0.0: Arming.DISARM}.get(command.params[0])
        if arming is None:
            return _DENIED
        self._wish(tick, command, arming, None)
        return None

    def _set_mode(self, tick: Tick, command: _Command) -> int | None:
        base, custom, sub = command.params[:3]
        if not math.isfinite(base) or not int(base) & dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            self._voice.tell("only custom modes can be set", dialect.MAV_SEVERITY_WARNING)
            return _DENIED
        mode = mode_of(custom, sub)
        if mode is None:
            self._voice.tell(f"mode {custom:g}/{sub:g} is unknown; {KNOWN}", dialect.MAV_SEVERITY_WARNING)
            return _DENIED
        self._wish(tick, command, Arming.KEEP, mode)
        return None

    def _old_set_mode(self, tick: Tick, m: Message) -> None:
        """The standard has no answer to SET_MODE; as from ArduPilot, the message's id stands for the command's."""
        params = (float(m.base_mode), float(m.custom_mode), 0.0)
        command = _Command(m.get_srcSystem(), m.get_srcComponent(), m.get_msgId(), False, params)
        result = self._set_mode(tick, command)
        if result is not None:
            self._acknowledge(command.number, result, command.system, command.component)

    def _wish(self, tick: Tick, command: _Command, arming: Arming, mode: Mode | None) -> None:
        wish = Wish(self._link, command.system, command.component, command.number, arming, mode)
        self._orders.ask(wish, command.again, tick.t_ns)

    def _request_message(self, _: Tick, command: _Command) -> int:
        name = _id(command.params[0])
        if name not in self._messages:
            return _UNSUPPORTED
        self._voice.show(name)
        return _ACCEPTED

    def _set_interval(self, tick: Tick, command: _Command) -> int:
        name = _id(command.params[0])
        if name not in self._messages:
            return _UNSUPPORTED
        if name == _HEARTBEAT:  # a vehicle without one is not there
            return _DENIED
        return _ACCEPTED if self._streams.pace(name, command.params[1], tick.t_ns) else _DENIED

    def _capabilities(self, _: Tick, command: _Command) -> int:
        if command.params[0] != 1.0:
            return _DENIED
        self._voice.show(_VERSION)
        return _ACCEPTED


def _id(value: float) -> int:
    return int(value) if math.isfinite(value) else -1
