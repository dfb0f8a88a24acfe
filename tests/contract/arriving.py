"""Both ends of a bus in one process, ticked by hand: what one has sent is there when the other looks."""

from __future__ import annotations

import time
from typing import Any

from firmware_py.adapters.buses.can_bus import CanBus

PATIENCE = 10.0
Frames = list[tuple[int, bytes]]


class Arriving:
    """One end of a bus: a drain waits until what was sent to it is there."""

    def __init__(self, bus: CanBus) -> None:
        self._bus, self._closed, self.due = bus, False, 0
        self.heard_by: Arriving | None = None
        """The other end, if that waits too."""

    def drain(self, limit: int) -> Frames:
        found: Frames = []
        deadline = time.monotonic() + PATIENCE
        while len(found) < min(limit, self.due) and not self._closed:
            found += self._bus.drain(min(limit, self.due) - len(found), 0.1)
            assert time.monotonic() < deadline
        self.due -= len(found)
        return found or self._bus.drain(limit)

    def send(self, frames: Frames) -> None:
        self._bus.send(frames)
        if self.heard_by is not None and not self._closed:
            self.heard_by.due += len(frames)

    def close(self) -> None:
        self._closed = True
        self._bus.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)


def joined(one: CanBus, other: CanBus) -> tuple[Arriving, Arriving]:
    """Return both ends, each of which waits for what the other has sent."""
    ends = Arriving(one), Arriving(other)
    ends[0].heard_by, ends[1].heard_by = ends[1], ends[0]
    return ends
