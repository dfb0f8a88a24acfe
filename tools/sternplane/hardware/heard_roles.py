"""What became of each role of a vehicle while a bench tool listened: how often it was heard, and its state."""

from __future__ import annotations

import enum
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import fields
from typing import Any, NamedTuple

from firmware_py.records.sensing import (
    MEASURES,
    ROLES,
    Heard,
    SensorFrame,
    candidate_bit,
    candidate_name,
    fin_bit,
    node_bit,
)

_RECENT_S = 2.5
"""What comes once a second is fresh if it has come within this."""
_PERIODS = 4.0
"""What comes less often, within so many of its periods."""
_MOSTLY = 0.5
"""A share of sound values under this is not sound."""


class State(enum.Enum):
    """What is the matter with a role."""

    FRESH = "fresh"
    SILENT = "silent"
    LOST = "no longer heard"
    NOT_OK = "heard, not ok"
    TWO_SENDERS = "two senders"
    REPLACED = "another device"
    UNHEALTHY = "says that it does not work"


class HeardRole:
    """One role.

    Attributes:
        count: how many ticks brought a value.
        ok: how many of these values were sound.
        last: the last one.
    """

    def __init__(self, bit: int) -> None:
        self.bit = bit
        self.count = self.ok = 0
        self.last: Heard[Any] | None = None
        self._first = self._t = math.nan

    def update(self, heard: Heard[Any], t: float) -> None:
        """Take what a tick at t, s, brought."""
        if heard.fresh:
            self.count += 1
            self.ok += heard.ok
            self.last = heard
            if self.count == 1:
                self._first = t
            self._t = t

    @property
    def rate(self) -> float:
        """Return values a second; of fewer than two 0. No more than one counts for a tick."""
        return (self.count - 1) / (self._t - self._first) if self._t > self._first else 0.0

    def age(self, t: float) -> float:
        """Return how long ago the last value was true, s; NaN if there was none."""
        return math.nan if self.last is None else self.last.age(t)

    def state(self, t: float, wrong: Wrong) -> State:
        """Return its state at t, s, with what is wrong with nodes."""
        if self.last is None:
            return State.SILENT
        for bits, state in (
            (wrong.two_senders, State.TWO_SENDERS),
            (wrong.replaced, State.REPLACED),
            (wrong.unhealthy, State.UNHEALTHY),
        ):
            if bits & self.bit:
                return state
        period = 1.0 / self.rate if self.rate else 0.0
        if t - self._t > max(_RECENT_S, _PERIODS * period):
            return State.LOST
        return State.FRESH if self.last.ok and self.ok >= _MOSTLY * self.count else State.NOT_OK


class Wrong(NamedTuple):
    """Bits of nodes, as `SensorFrame` has them: what was ever the matter."""

    two_senders: int = 0
    unhealthy: int = 0
    replaced: int = 0


class HeardRoles:
    """All roles of a vehicle.

    Attributes:
        t: of the last tick, s.
        wrong: what was ever the matter with nodes.
    """

    def __init__(self, fins: Sequence[str], known: Collection[str] | None = None) -> None:
        """Take the names of the fins, and the roles that a device measures; None is all."""
        self.t = 0.0
        self.wrong = Wrong()
        self._fins, self._known = fins, known
        self._roles: dict[str, HeardRole] = {}

    def update(self, frame: SensorFrame, t: float) -> None:
        """Take the frame of a tick at t, s."""
        self.t = t
        before = self.wrong
        self.wrong = Wrong(before.two_senders | frame.two_senders, frame.unhealthy, before.replaced | frame.replaced)
        for name, bit, heard in self._measurements(frame):
            if self._known is not None and name not in self._known:
                continue
            self._roles.setdefault(name, HeardRole(bit)).update(heard, t)

    def roles(self) -> dict[str, HeardRole]:
        """Return all of them, by their names: fields of `SensorFrame`, "ROLE.2" of a second device, "fin NAME"."""
        return self._roles

    def state(self, role: str) -> State:
        """Return the state of a role now."""
        return self._roles[role].state(self.t, self.wrong)

    def _measurements(self, frame: SensorFrame) -> Iterator[tuple[str, int, Heard[Any]]]:
        for i, (name, heard) in enumerate(zip(self._fins, frame.fins, strict=True)):
            yield f"fin {name}", fin_bit(i) | node_bit("servo_hub"), heard
        for field in fields(frame):
            value = getattr(frame, field.name)
            if isinstance(value, Heard):
                yield field.name, candidate_bit(field.name, 0) if field.name in ROLES else _bit(field.name), value
        for role in ROLES:
            for i, heard in enumerate(getattr(frame, f"spare_{role}"), 1):
                yield candidate_name(role, i), candidate_bit(role, i), heard


def _bit(role: str) -> int:
    return sum(node_bit(node) for node, measured in MEASURES.items() if role in measured)
