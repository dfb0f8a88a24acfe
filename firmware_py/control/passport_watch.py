"""What has changed of a vehicle that began with what an earlier flight learned: told before it is armed, and after.

Before it is armed: by how much the earlier flight differs from vehicle.toml. In flight: by how much fins are off the
earlier flight, if that is much and certain, for they may have been damaged since. Once it is disarmed: by how much
what is known now differs from the earlier flight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.records.estimate import Learned
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.passport import LearnedModel, Moved, moved

AGAINST_FILE, AGAINST_EARLIER = 0.0, 1.0
"""First of the event's numbers."""
_UNKNOWN = (math.nan, math.inf)
_FAR, _CERTAIN = 0.3, 5.0
"""A share and sigmas: fins that differ by more than both are told in flight,"""
_LASTS = 30
"""once it has lasted for so many times that it was heeded."""
_FINS = ("rudder", "stern planes")
"""The groups of their coefficients."""


class PassportMemory(NamedTuple):
    """What is remembered.

    Attributes:
        model: what the vehicle began with; None if with vehicle.toml.
        latest: value and 1 sigma of each coefficient that is learned, when a law could last rely on it.
        armed: whether the vehicle was.
        far: groups of fins that are far from what it began with, and how often in a row they have been.
    """

    model: LearnedModel | None = None
    latest: tuple[tuple[float, float], ...] = ()
    armed: bool = False
    far: tuple[tuple[str, int], ...] = ()


class PassportWatch:
    """Compares what is learned with what the vehicle began with."""

    def __init__(self, names: Sequence[str]) -> None:
        """Begin with vehicle.toml; `names` is what is learned."""
        self._names = names
        self._memory = PassportMemory(latest=(_UNKNOWN,) * len(names))

    def begin(self, model: LearnedModel) -> None:
        """Begin with what an earlier flight learned."""
        self._memory = self._memory._replace(model=model)

    def heed(self, learned: Learned) -> tuple[Event, ...]:
        """Take up what a law may rely on; return whose fins are far from the earlier flight, once."""
        m, found = self._memory, list[Moved]()
        model = m.model
        if model is None:
            return ()
        if True in learned.valid:
            rows = list(zip(learned.value, learned.std, learned.valid, strict=True))
            latest = tuple([(v, std) if valid else was for (v, std, valid), was in zip(rows, m.latest, strict=True)])
            m = m._replace(latest=latest)
            now = self._moved(model, [(v, std) if valid else _UNKNOWN for v, std, valid in rows])
            fins = [one for one in now if one.group in _FINS]
            found = [one for one in fins if abs(one.share) > _FAR and one.sigmas > _CERTAIN]
        before, told = dict(m.far), [group for group, times in m.far if times >= _LASTS]
        times = {**{one.group: before.get(one.group, 0) + m.armed for one in found}, **dict.fromkeys(told, _LASTS)}
        self._memory = m._replace(far=tuple(times.items()))
        due = [one for one in found if times[one.group] >= _LASTS and one.group not in told]
        return _events(AGAINST_EARLIER, due)

    def update(self, armed: bool, asked: bool) -> tuple[Event, ...]:
        """Return what is to be told; `asked` says that somebody wants to arm, or to know whether that is possible."""
        m = self._memory
        if m.model is None:
            return ()
        was = m.armed
        if armed != was:
            self._memory = m._replace(armed=armed)
        if asked and not (was or armed):
            return _events(AGAINST_FILE, moved(m.model, m.model.file, m.model.value, m.model.std))
        return _events(AGAINST_EARLIER, self._moved(m.model, m.latest)) if was and not armed else ()

    def freeze(self) -> PassportMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: PassportMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _moved(self, model: LearnedModel, known: Sequence[tuple[float, float]]) -> list[Moved]:
        """Return what this flight found otherwise, by value and 1 sigma of each coefficient."""
        now = dict(zip(self._names, known, strict=True))
        found = [now.get(name, _UNKNOWN) for name in model.names]
        std = [math.hypot(std, sigma) for (_, std), sigma in zip(found, model.std, strict=True)]
        return moved(model, model.value, [value for value, _ in found], std)


def _events(against: float, found: Sequence[Moved]) -> tuple[Event, ...]:
    kind = EventKind.MODEL_CHANGED
    return tuple([event(kind, numbers=(against, one.share, one.sigmas), names=(one.group, one.name)) for one in found])
