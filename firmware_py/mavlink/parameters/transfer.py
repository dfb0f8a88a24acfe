"""The parameter protocol: PARAM_REQUEST_LIST, PARAM_REQUEST_READ and PARAM_SET on one link."""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from firmware_py.foreign_text import visible
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import LinkOutput
from firmware_py.mavlink.base.modes import Identity
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.mavlink.parameters.store import (
    DOES_NOT_EXIST,
    NEVER,
    TYPE_MISMATCH,
    ParameterRefused,
    ParameterStore,
    value_text,
)
from firmware_py.parameter_tree import Parameter
from firmware_py.params import TakesEffect
from firmware_py.tick import Tick

_REAL, _INT = dialect.MAV_PARAM_TYPE_REAL32, dialect.MAV_PARAM_TYPE_INT32
_WARNING, _NOTICE = dialect.MAV_SEVERITY_WARNING, dialect.MAV_SEVERITY_NOTICE
_MAX_SETS = 16


class _Set(NamedTuple):
    system: int
    component: int
    name: str
    value: float
    kind: int


class ParameterTransfer:
    """The parameter protocol on one link. Integers are encoded as stations expect of the link's identity."""

    def __init__(
        self, store: ParameterStore, output: LinkOutput, identity: Identity, armed: Callable[[], bool]
    ) -> None:
        """`armed` returns whether the vehicle is armed."""
        self._store, self._output, self._armed = store, output, armed
        self._bytewise = identity is not Identity.ARDUSUB
        self._listed = len(store.settings)
        """Index of the next value of the list to send; the number of values when no list is asked for."""
        self._to_send: dict[int, None] = {}
        self._sets: deque[_Set] = deque()
        self._last_set_k = NEVER
        store.subscribe(self._queue_value, lambda: bool(self._sets))

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: self._list,
            dialect.MAVLINK_MSG_ID_PARAM_REQUEST_READ: self._read,
            dialect.MAVLINK_MSG_ID_PARAM_SET: self._set,
        }

    def due(self, tick: Tick) -> list[Message]:
        """Return a value that was set or asked for, else the next of the list; set one new value in a tick."""
        if self._sets and self._store.may_set(tick.k, self._last_set_k):
            self._last_set_k = tick.k
            if not self._set_value(self._sets.popleft()):
                return []  # the error goes first: a station that sees its old value before it asks again
        if self._to_send:
            i = next(iter(self._to_send))
            del self._to_send[i]
        elif self._listed < len(self._store.settings):
            i = self._listed
            self._listed += 1
        else:
            return []
        return [self._value(i)]

    def _list(self, _: Tick, message: Message) -> None:  # noqa: ARG002
        self._listed = 0

    def _read(self, _: Tick, message: Message) -> None:
        if message.param_index == -1:
            i = self._store.index.get(message.param_id, -1)
        else:
            i = message.param_index if 0 <= message.param_index < len(self._store.settings) else -1
        if i >= 0:
            self._queue_value(i)
        else:
            asked = visible(message.param_id) if message.param_index == -1 else f"at index {message.param_index}"
            system, component = message.get_srcSystem(), message.get_srcComponent()
            self._error(system, component, message.param_id, message.param_index, DOES_NOT_EXIST)
            self._output.send_text(f"there is no parameter {asked}", _NOTICE)

    def _set(self, _: Tick, message: Message) -> None:
        """Queue a value. What is too much is dropped: a station without an answer sends it again."""
        if len(self._sets) == _MAX_SETS:
            self._output.count_dropped()
            return
        system, component = message.get_srcSystem(), message.get_srcComponent()
        self._sets.append(_Set(system, component, message.param_id, message.param_value, message.param_type))

    def _set_value(self, asked: _Set) -> bool:
        """Set a value and return whether it was accepted; if not, the station is told why."""
        i = self._store.index.get(asked.name, -1)
        try:
            self._store.set(asked.name, self._number(asked, i), self._armed())
        except ParameterRefused as refusal:
            if i >= 0:
                self._queue_value(i)
            self._error(asked.system, asked.component, asked.name, i, refusal.error)
            self._output.send_text(str(refusal), _WARNING)
            return False
        if self._store.settings[i].when is TakesEffect.RESTART:
            self._output.send_text(f"{asked.name} takes effect at the next start", _NOTICE)
        return True

    def _number(self, asked: _Set, i: int) -> float:
        """Return the number that was sent: the float itself, or the integer in its four bytes."""
        if i < 0 or not self._bytewise:
            return asked.value
        setting = self._store.settings[i]
        if asked.kind != _kind(setting):
            raise ParameterRefused(
                TYPE_MISMATCH, f"{asked.name} stays {value_text(setting)}: it is {_type_name(setting)}"
            )
        return float(struct.unpack("<i", struct.pack("<f", asked.value))[0]) if setting.is_integer else asked.value

    def _value(self, i: int) -> Message:
        setting = self._store.settings[i]
        value = setting.value
        if setting.is_integer and self._bytewise:
            (value,) = struct.unpack("<f", struct.pack("<i", int(value)))
        return dialect.MAVLink_param_value_message(
            setting.name.encode(), value, _kind(setting), len(self._store.settings), i
        )

    def _queue_value(self, i: int) -> None:
        self._to_send[i] = None

    def _error(self, system: int, component: int, name: str, i: int, error: int) -> None:
        self._output.send(dialect.MAVLink_param_error_message(system, component, name.encode()[:16], i, error))


def _kind(setting: Parameter) -> int:
    return int(_INT if setting.is_integer else _REAL)


def _type_name(setting: Parameter) -> str:
    return "an INT32" if setting.is_integer else "a REAL32"
