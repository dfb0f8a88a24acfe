"""What has changed of a vehicle that began with what an earlier flight learned: told before it is armed, and after.

Before it is armed: by how much the earlier flight differs from vehicle.toml. Once it is disarmed: by how much what is
known now differs from the earlier flight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.records.estimate import Learned
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.passport import LearnedModel, moved

AGAINST_FILE, AGAINST_EARLIER = 0.0, 1.0
"""First of the event's numbers."""
_UNKNOWN = (math.nan, math.inf)


class PassportMemory(NamedTuple):
    """What is remembered.

    Attributes:
        model: what the vehicle began with; None if with vehicle.toml.
        latest: value and 1 sigma of each coefficient that is learned, when a law could last rely on it.
        armed: whether the vehicle was.
    """

    model: LearnedModel | None = None
    latest: tuple[tuple[float, float], ...] = ()
    armed: bool = False


class PassportWatch:
    """Compares what is learned with what the vehicle began with."""

    def __init__(self, names: Sequence[str]) -> None:
        """Begin with vehicle.toml; `names` is what is learned."""
        self._names = names
        self._memory = PassportMemory(latest=(_UNKNOWN,) * len(names))

    def begin(self, model: LearnedModel) -> None:
        """Begin with what an earlier flight learned."""
        self._memory = self._memory._replace(model=model)

    def heed(self, learned: Learned) -> None:
        """Take up what a law may rely on."""
        if self._memory.model is not None and True in learned.valid:
            rows = zip(learned.value, learned.std, learned.valid, self._memory.latest, strict=True)
            latest = tuple([(value, std) if valid else before for value, std, valid, before in rows])
            self._memory = self._memory._replace(latest=latest)

    def update(self, armed: bool, asked: bool) -> tuple[Event, ...]:
        """Return what is to be told; `asked` says that somebody wants to arm, or to know whether that is possible."""
        m = self._memory
        if m.model is None:
            return ()
        was = m.armed
        if armed != was:
            self._memory = m._replace(armed=armed)
        if asked and not (was or armed):
            return _told(AGAINST_FILE, m.model, m.model.file, m.model.value, m.model.std)
        return self._after(m.model, m.latest) if was and not armed else ()

    def freeze(self) -> PassportMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: PassportMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _after(self, model: LearnedModel, latest: tuple[tuple[float, float], ...]) -> tuple[Event, ...]:
        """Return what this flight found otherwise."""
        now = dict(zip(self._names, latest, strict=True))
        known = [now.get(name, _UNKNOWN) for name in model.names]
        value = [value for value, _ in known]
        std = [math.hypot(std, sigma) for (_, std), sigma in zip(known, model.std, strict=True)]
        return _told(AGAINST_EARLIER, model, model.value, value, std)


def _told(
    against: float, model: LearnedModel, before: Sequence[float], now: Sequence[float], std: Sequence[float]
) -> tuple[Event, ...]:
    kind, found = EventKind.MODEL_CHANGED, moved(model, before, now, std)
    return tuple([event(kind, numbers=(against, one.share, one.sigmas), names=(one.group, one.name)) for one in found])
