"""The parameter protocol: what stations may see and change, one book for all links and a conversation on each.

Every value has one name, one place and one type, for as long as the vehicle runs. What may be changed, within which
bounds and when, is declared beside the code that uses it (`params.param`); whether values fit together is asked of
`Checker`. An accepted value is told to every link, ordered of the core, and kept for the next start.
"""

from __future__ import annotations

import dataclasses
import json
import math
import struct
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.link_output import LinkOutput
from firmware_py.mavlink.base.modes import Identity
from firmware_py.mavlink.base.service import MessageHandler
from firmware_py.parameter_tree import Parameter
from firmware_py.params import ParamError, TakesEffect
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.order import Change, ParameterChange
from firmware_py.schedule import Tick

FILE = "parameters.toml"
"""Where what was changed is kept."""
_REAL, _INT = dialect.MAV_PARAM_TYPE_REAL32, dialect.MAV_PARAM_TYPE_INT32
_DOES_NOT_EXIST, _OUT_OF_RANGE = dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST, dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
_PERMISSION_DENIED, _TYPE_MISMATCH = dialect.MAV_PARAM_ERROR_PERMISSION_DENIED, 6
"""The dialect has no name for the sixth, MAV_PARAM_ERROR_TYPE_MISMATCH."""
_WARNING, _NOTICE = dialect.MAV_SEVERITY_WARNING, dialect.MAV_SEVERITY_NOTICE
_MAX_SETS = 16
_NEVER = -(2**31)
_HEADER = "# What ground stations have changed; it is laid over autopilot.toml at the next start.\n"


class Checker(Protocol):
    """Knows all values, and whether a vehicle can be made of them."""

    def changed(self, values: Mapping[str, Any]) -> Checker:
        """The same with other values of dotted keys.

        Raises:
            ParamError: no vehicle can be made of them; the error says why.
        """

    @property
    def limits(self) -> OperatingLimits:
        """What the vehicle keeps to under these values."""

    @property
    def manual_control(self) -> Any:
        """What sticks ask for under these values, `ManualControlParams`: handed on unread."""


class ParameterRefused(Exception):
    """Why a value was not taken, as MAV_PARAM_ERROR and as a sentence."""

    def __init__(self, error: int, because: str) -> None:
        super().__init__(because)
        self.error = error


class ParameterStore:
    """The values as they stand, in an order that does not change."""

    def __init__(self, settings: Sequence[Parameter], checker: Checker) -> None:
        self.settings = list(settings)
        self.index = {setting.name: i for i, setting in enumerate(self.settings)}
        self._checker = checker
        self._value_subscribers: list[Callable[[int], None]] = []
        self._waiting_subscribers: list[Callable[[], bool]] = []
        self._change_subscribers: list[Callable[[Checker], None]] = []
        self._changes: list[Change] = []
        self._unsaved = False
        self._tried_k = _NEVER

    def subscribe(self, send_text: Callable[[int], None], has_waiting: Callable[[], bool]) -> None:
        """`tell` is told the place of every value that was set; `wants` says whether values wait to be tried."""
        self._value_subscribers.append(send_text)
        self._waiting_subscribers.append(has_waiting)

    def subscribe_changes(self, on_change: Callable[[Checker], None]) -> None:
        """`changed` is told of every change that takes effect at once: of all values as they are then."""
        self._change_subscribers.append(on_change)

    def may_try(self, k: int, last: int) -> bool:
        """Whether a link that tried a value in tick `last` may try one in tick `k`: one may in a tick, each in turn.

        To try and to adopt a value takes milliseconds, for whole parts of the vehicle are made anew.
        """
        waiting = sum(has_waiting() for has_waiting in self._waiting_subscribers)
        if k == self._tried_k or k - last < waiting:
            return False
        self._tried_k = k
        return True

    def set(self, name: str, value: float, armed: bool) -> None:
        """Sets a value, as a station has sent it.

        Raises:
            Refusal: it stays as it was.
        """
        if name not in self.index:
            raise ParameterRefused(_DOES_NOT_EXIST, f"there is no parameter {name!r}")
        i = self.index[name]
        setting = self.settings[i]
        now = setting.value
        if not setting.is_integer:
            value, now = shortest(value), shortest(now)
        if value != now:
            self._refuse(setting, value, armed)
            new = [*self.settings]
            new[i] = dataclasses.replace(setting, value=value)
            content = _toml_value([s for s in new if s.key == setting.key])
            try:
                self._checker = self._checker.changed({setting.key: content})
            except ParamError as error:
                raise ParameterRefused(_OUT_OF_RANGE, f"{name} stays {_displayed(setting)}: {error}") from None
            self.settings = new
            self._unsaved = True
            if setting.when is not TakesEffect.RESTART:
                self._changes.append(ParameterChange(((setting.key, content),)))
                for on_change in self._change_subscribers:
                    on_change(self._checker)
        for send_text in self._value_subscribers:
            send_text(i)

    def changes(self) -> tuple[Change, ...]:
        """Return what changes for the order of this tick."""
        changes, self._changes = tuple(self._changes), []
        return changes

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """What is to be kept since this was asked last, by the name of its file: all that differs from the files'."""
        if not self._unsaved:
            return []
        self._unsaved = False
        entries: dict[str, list[Parameter]] = {}
        for setting in self.settings:
            entries.setdefault(setting.key, []).append(setting)
        lines = (
            f"{key} = {json.dumps(_toml_value(found))}\n"
            for key, found in entries.items()
            if any(s.value != s.base for s in found)
        )
        return [(FILE, (_HEADER + "".join(lines)).encode())]

    @staticmethod
    def _refuse(setting: Parameter, value: float, armed: bool) -> None:
        name, stays = setting.name, f"{setting.name} stays {_displayed(setting)}"
        if not math.isfinite(value) or (setting.is_integer and value != int(value)):
            wanted = "a whole number" if setting.is_integer else "a number"
            raise ParameterRefused(_OUT_OF_RANGE, f"{stays}: {value:g} is not {wanted}")
        if not setting.low <= value <= setting.high:
            unit = f" {setting.unit}" if setting.unit else ""
            choices = f" ({', '.join(f'{i} {c}' for i, c in enumerate(setting.choices))})" if setting.choices else ""
            bounds = f"[{setting.low:g}, {setting.high:g}]{unit}{choices}"
            raise ParameterRefused(_OUT_OF_RANGE, f"{stays}: {value:g} is not in {bounds}")
        if armed and setting.when is TakesEffect.DISARMED:
            raise ParameterRefused(
                _PERMISSION_DENIED, f"{name} stays {_displayed(setting)} while armed: disarm to change it"
            )


class _Set(NamedTuple):
    system: int
    component: int
    name: str
    value: float
    kind: int


class ParameterTransfer:
    """The conversation on one link. Values are written as its stations expect of whom they take the vehicle for."""

    def __init__(
        self, store: ParameterStore, output: LinkOutput, identity: Identity, armed: Callable[[], bool]
    ) -> None:
        """`armed` says whether the vehicle is."""
        self._store, self._output, self._armed = store, output, armed
        self._bytewise = identity is not Identity.ARDUSUB
        self._listed = len(store.settings)
        """Up to where the list is told; all of it while nobody asks."""
        self._to_send: dict[int, None] = {}
        self._sets: deque[_Set] = deque()
        self._tried_k = _NEVER
        store.subscribe(self._queue_value, lambda: bool(self._sets))

    def message_handlers(self) -> dict[int, MessageHandler]:
        """See `service.Service`."""
        return {
            dialect.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: self._list,
            dialect.MAVLINK_MSG_ID_PARAM_REQUEST_READ: self._read,
            dialect.MAVLINK_MSG_ID_PARAM_SET: self._set,
        }

    def due(self, tick: Tick) -> list[Message]:
        """Values that were set or asked for, then the list; one new value is tried in a tick."""
        if self._sets and self._store.may_try(tick.k, self._tried_k):
            self._tried_k = tick.k
            if not self._try(self._sets.popleft()):
                return []  # the error is said first: a station that hears its old value before that asks again
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
            asked = message.param_id if message.param_index == -1 else f"at place {message.param_index}"
            system, component = message.get_srcSystem(), message.get_srcComponent()
            self._error(system, component, message.param_id, message.param_index, _DOES_NOT_EXIST)
            self._output.send_text(f"there is no parameter {asked}", _NOTICE)

    def _set(self, _: Tick, message: Message) -> None:
        """A station that hears no answer sends it again, so what is too much is dropped."""
        if len(self._sets) == _MAX_SETS:
            self._output.count_dropped()
            return
        system, component = message.get_srcSystem(), message.get_srcComponent()
        self._sets.append(_Set(system, component, message.param_id, message.param_value, message.param_type))

    def _try(self, asked: _Set) -> bool:
        """Whether the value was taken; if not, the station is told why."""
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
        """The number that was sent: as it is, or of four bytes that are an integer's."""
        if i < 0 or not self._bytewise:
            return asked.value
        setting = self._store.settings[i]
        if asked.kind != _kind(setting):
            raise ParameterRefused(
                _TYPE_MISMATCH, f"{asked.name} stays {_displayed(setting)}: it is {_type_name(setting)}"
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


def shortest(value: float) -> float:
    """The number of fewest digits that is `value` in single precision: what a person meant who wrote 0.1."""
    return float(str(np.float32(value))) if math.isfinite(value) else value


def _kind(setting: Parameter) -> int:
    return int(_INT if setting.is_integer else _REAL)


def _type_name(setting: Parameter) -> str:
    return "an INT32" if setting.is_integer else "a REAL32"


def _displayed(setting: Parameter) -> str:
    return setting.choices[int(setting.value)] if setting.choices else f"{setting.value:g}"


def _toml_value(entries: Sequence[Parameter]) -> Any:
    """What TOML says of a key, whose entries these are."""
    values = [_plain(setting) for setting in entries]
    return values[0] if entries[0].index < 0 else values


def _plain(setting: Parameter) -> Any:
    if setting.choices == ("false", "true"):
        return bool(setting.value)
    if setting.choices:
        return setting.choices[int(setting.value)]
    return int(setting.value) if setting.is_integer else setting.value
