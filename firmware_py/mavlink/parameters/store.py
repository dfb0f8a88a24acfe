"""The parameter store: the values of all parameters, in an order that does not change, shared by all links.

Every value has one name, one index and one type while the vehicle runs. What may be changed, within which bounds and
when, is declared beside the code that uses it (`params.param`); whether the values fit together is decided by the
`Checker`. An accepted value is announced on every link, goes into the next order, and is saved for the next start.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from firmware_py.mavlink.base.codec import dialect
from firmware_py.parameter_tree import Parameter
from firmware_py.params import ParamError, TakesEffect
from firmware_py.records.order import Change, ParameterChange

FILE = "parameters.toml"
"""The file of changed values in the state folder."""
DOES_NOT_EXIST: int = dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
_OUT_OF_RANGE: int = dialect.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
_PERMISSION_DENIED: int = dialect.MAV_PARAM_ERROR_PERMISSION_DENIED
TYPE_MISMATCH = 6
"""MAV_PARAM_ERROR_TYPE_MISMATCH, which pymavlink's dialect does not name."""
NEVER = -(2**31)
_HEADER = "# Changed by ground stations; laid over autopilot.toml at the next start.\n"


class Checker(Protocol):
    """All parameter values, and whether a vehicle can be made of them."""

    def with_changes(self, values: Mapping[str, Any]) -> Checker:
        """Return the same with other values of dotted keys.

        Raises:
            ParamError: no vehicle can be made of them; the error says why.
        """

    @property
    def node_settings(self) -> Any:
        """The `settings.NodeSettings` of these values."""


class ParameterRefused(Exception):
    """Why a value is refused: the MAV_PARAM_ERROR and a sentence."""

    def __init__(self, error: int, text: str) -> None:
        super().__init__(text)
        self.error = error


class ParameterStore:
    """The current values, in an order that does not change."""

    def __init__(self, settings: Sequence[Parameter], checker: Checker) -> None:
        self.settings = list(settings)
        self.index = {setting.name: i for i, setting in enumerate(self.settings)}
        self._checker = checker
        self._value_subscribers: list[Callable[[int], None]] = []
        self._waiting_subscribers: list[Callable[[], bool]] = []
        self._change_subscribers: list[Callable[[Any], None]] = []
        self._changes: list[Change] = []
        self._unsaved = False
        self._last_set_k = NEVER

    def subscribe(self, on_set: Callable[[int], None], has_waiting: Callable[[], bool]) -> None:
        """Call `on_set` with the index of every value that is set; `has_waiting` tells whether values wait."""
        self._value_subscribers.append(on_set)
        self._waiting_subscribers.append(has_waiting)

    def subscribe_changes(self, on_change: Callable[[Any], None]) -> None:
        """Call `on_change` after every change that takes effect at once."""
        self._change_subscribers.append(on_change)

    def may_set(self, k: int, last: int) -> bool:
        """Return whether a link that last set a value in tick `last` may set one in tick `k`.

        One link may in a tick, each in turn: to check and adopt a value takes milliseconds, as parts of the autopilot
        are made again.
        """
        waiting = sum(has_waiting() for has_waiting in self._waiting_subscribers)
        if k == self._last_set_k or k - last < waiting:
            return False
        self._last_set_k = k
        return True

    def set(self, name: str, value: float, armed: bool) -> None:
        """Set a value as a station has sent it.

        Raises:
            ParameterRefused: the value stays as it was.
        """
        if name not in self.index:
            raise ParameterRefused(DOES_NOT_EXIST, f"there is no parameter {name!r}")
        i = self.index[name]
        setting = self.settings[i]
        now = setting.value
        if not setting.is_integer:
            value, now = shortest(value), shortest(now)
        if value != now:
            self._refuse(setting, value, armed)
            new = [*self.settings]
            new[i] = dataclasses.replace(setting, value=value)
            content = toml_value([s for s in new if s.key == setting.key])
            try:
                self._checker = self._checker.with_changes({setting.key: content})
            except ParamError as error:
                raise ParameterRefused(_OUT_OF_RANGE, f"{name} stays {value_text(setting)}: {error}") from None
            self.settings = new
            self._unsaved = True
            if setting.when is not TakesEffect.RESTART:
                self._changes.append(ParameterChange(((setting.key, content),)))
                for on_change in self._change_subscribers:
                    on_change(self._checker.node_settings)
        for on_set in self._value_subscribers:
            on_set(i)

    def changes(self) -> tuple[Change, ...]:
        """See `service.PersistentState`."""
        changes, self._changes = tuple(self._changes), []
        return changes

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """See `service.PersistentState`; the file has every value that differs from the configuration files."""
        if not self._unsaved:
            return []
        self._unsaved = False
        entries: dict[str, list[Parameter]] = {}
        for setting in self.settings:
            entries.setdefault(setting.key, []).append(setting)
        lines = (
            f"{key} = {json.dumps(toml_value(found))}\n"
            for key, found in entries.items()
            if any(s.value != s.base for s in found)
        )
        return [(FILE, (_HEADER + "".join(lines)).encode())]

    @staticmethod
    def _refuse(setting: Parameter, value: float, armed: bool) -> None:
        name, stays = setting.name, f"{setting.name} stays {value_text(setting)}"
        if not math.isfinite(value) or (setting.is_integer and value != int(value)):
            wanted = "a whole number" if setting.is_integer else "a number"
            raise ParameterRefused(_OUT_OF_RANGE, f"{stays}: {value:g} is not {wanted}")
        if not setting.low <= value <= setting.high:
            unit = f" {setting.unit}" if setting.unit else ""
            choices = f" ({', '.join(f'{i} {c}' for i, c in setting.allowed)})" if setting.choices else ""
            bounds = f"[{setting.low:g}, {setting.high:g}]{unit}{choices}"
            raise ParameterRefused(_OUT_OF_RANGE, f"{stays}: {value:g} is not in {bounds}")
        if armed and setting.when is TakesEffect.DISARMED:
            raise ParameterRefused(
                _PERMISSION_DENIED, f"{name} stays {value_text(setting)} while armed: disarm to change it"
            )


def shortest(value: float) -> float:
    """Return the shortest decimal number equal to `value` in single precision: 0.1 for the float32 nearest to 0.1."""
    return float(str(np.float32(value))) if math.isfinite(value) else value


def value_text(setting: Parameter) -> str:
    """Return the value as sentences show it."""
    return setting.choices[int(setting.value)] if setting.choices else f"{setting.value:g}"


def toml_value(entries: Sequence[Parameter]) -> Any:
    """Return the TOML value of a key that has these entries."""
    values = [_plain(setting) for setting in entries]
    return values[0] if entries[0].index < 0 else values


def _plain(setting: Parameter) -> Any:
    if setting.choices == ("false", "true"):
        return bool(setting.value)
    if setting.choices:
        return setting.choices[int(setting.value)]
    return int(setting.value) if setting.is_integer else setting.value
