"""Parts of one's own: what all of them have in common, and what becomes of one that fails.

A law, an estimator or a guidance of one's own runs inside the cycle, between the built-in parts. What it says is looked
at before it is used; the first exception or wrong answer ends its use until the vehicle is disarmed, and the built-in
part goes on in its place. Supervisor and gate judge the outcome as they judge that of built-in parts.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

from firmware_py.error_text import failure_text, shortened
from firmware_py.foreign_text import visible
from firmware_py.params import ParamError
from firmware_py.records.event import Event, EventKind, event
from firmware_py.vehicle.vehicle import Vehicle

A = TypeVar("A")
P = TypeVar("P", bound="OwnPart")
_ADDRESS = re.compile(r"0x[0-9a-f]+")
"""Of an object in memory: another one in each run, so no event may tell it."""


@dataclass(frozen=True, slots=True)
class NoParams:
    """The parameters of a part that has none."""


class OwnPart:
    """A part of one's own. It depends on its memory and what it is given alone: no clock, file, network or chance.

    Attributes:
        Params: a frozen dataclass of `param(...)` fields; its table in TOML is checked like any other.
        vehicle: the autopilot's model of its vehicle.
        params: a `Params`.
    """

    Params: ClassVar[type[Any]] = NoParams

    def __init__(self, vehicle: Vehicle, params: Any) -> None:
        self.vehicle = vehicle
        self.params = params

    def reset(self) -> None:
        """Forget what was integrated; called before the first use, and after every break in it."""

    def freeze(self) -> Any:
        """Return the whole memory, as numbers, texts, numpy arrays, and tuples, lists and dictionaries of these.

        By default it is every attribute but `vehicle` and `params`, copied.
        """
        return copy.deepcopy({name: value for name, value in vars(self).items() if name not in ("vehicle", "params")})

    def thaw(self, memory: Any) -> None:
        """Restore the memory that `freeze` returned."""
        vars(self).update(copy.deepcopy(memory))


class OwnClass(NamedTuple, Generic[P]):
    """Which class a part of one's own is of, under which name, and its parameters."""

    name: str
    cls: type[P]
    params: Any

    def make(self, kind: str, vehicle: Vehicle) -> P:
        """Return the part; `kind` is what it is for people: "law".

        Raises:
            ParamError: it cannot be made, or cannot tell its memory even before its first use.
        """
        try:
            part = self.cls(vehicle, self.params)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ParamError(f"{kind} {self.name} cannot be made: {_reason(error)}") from error
        try:
            part.freeze()
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ParamError(no_data(f"{kind} {self.name}", _reason(error))) from error
        return part


class GuardMemory(NamedTuple):
    """What is remembered of a part of one's own: how it failed, "" if it did not; its last tick; its own memory."""

    failure: str
    last: int
    own: Any


class Guard(Generic[P]):
    """Asks a part of one's own until it fails.

    Attributes:
        part: it.
        failure: how it failed; "" while it is used.
    """

    def __init__(self, kind: str, of: OwnClass[P], vehicle: Vehicle) -> None:
        """Make the part; `kind` is what it is for people: "law"."""
        self.part = of.make(kind, vehicle)
        self.failure = ""
        self._kind, self._name = kind, of.name
        self._untold: tuple[Event, ...] = ()
        self._last = -1

    def ask(self, k: int, answer: Callable[[P], A]) -> A | None:
        """Return the answer of tick `k`; None from the first one on that is wrong, which is an exception too."""
        if self.failure:
            return None
        try:
            if k != self._last + 1 or not k:
                self.part.reset()
            self._last = k
            return answer(self.part)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # whatever somebody's code may raise
            self._fail(error)
            return None

    def told(self) -> tuple[Event, ...]:
        """Return what happened since the last call: that it failed, if it did."""
        told, self._untold = self._untold, ()
        return told

    def rest(self) -> None:
        """Note that the vehicle is disarmed: a part that failed may be used again."""
        self.failure = ""

    def freeze(self) -> GuardMemory:
        """Return the whole memory; a part that cannot tell its own fails."""
        own = None
        try:
            own = self.part.freeze()
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self._fail(error)
        return GuardMemory(self.failure, self._last, own)

    def thaw(self, memory: GuardMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.failure, self._last = memory.failure, memory.last
        try:
            self.part.thaw(memory.own)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self._fail(error)

    def _fail(self, error: BaseException) -> None:
        if not self.failure:
            self.failure = _reason(error)
            self._untold = (event(EventKind.OWN_PART_FAILED, names=(self._kind, self._name, self.failure)),)


def no_data(name: str, reason: str) -> str:
    """Return what is said of a part that remembers what no log can keep."""
    return (
        f"{name}: its memory cannot be kept ({reason}): freeze() must return numbers, texts, numpy arrays, and "
        "tuples, lists and dictionaries of these; by default it returns every attribute, so hold no lock, file or "
        "function in one, or define freeze and thaw without it"
    )


def _reason(error: BaseException) -> str:
    """Return an exception as one line that is the same in every run."""
    return shortened(visible(_ADDRESS.sub("0x", failure_text(error))))
