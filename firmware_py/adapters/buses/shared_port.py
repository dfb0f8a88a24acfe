"""One bus for two drivers: frames with ids of 29 bits for one (DroneCAN), with standard ids for the other (CANopen)."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.buses.frame_id import STANDARD

_MOST_WAITING = 4096
"""What one of the two does not fetch is kept up to so many frames; then its oldest are lost, and counted."""


class SharedPort:
    """The end of one of the two; `split` makes both. What is lost on the bus is counted by the first."""

    def __init__(self, bus: FramePort, waiting: tuple[deque[tuple[int, bytes]], ...], which: int) -> None:
        self._bus, self._waiting, self._which = bus, waiting, which
        self._crowded_out = 0

    @property
    def sound(self) -> bool:
        """Return whether the bus is."""
        return self._bus.sound

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return one's own frames that have arrived, at most `limit`; examine at most so many on the bus."""
        extended, standard = self._waiting
        for frame in self._bus.drain(limit):
            (extended if frame[0] < STANDARD else standard).append(frame)
        for waiting in self._waiting:
            while len(waiting) > _MOST_WAITING:
                waiting.popleft()
                self._crowded_out += 1
        mine = self._waiting[self._which]
        return [mine.popleft() for _ in range(min(limit, len(mine)))]

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """Send frames in order."""
        self._bus.send(frames)

    def losses(self) -> dict[str, int]:
        """Return how much was lost; of the bus itself for the first end alone."""
        own = {"crowded_out": self._crowded_out} if self._crowded_out else {}
        return own if self._which else {**self._bus.losses(), **own}

    def close(self) -> None:
        """Leave the bus, for both."""
        self._bus.close()


def split(bus: FramePort) -> tuple[SharedPort, SharedPort]:
    """Return the two ends of a bus: for frames with ids of 29 bits, and with standard ids."""
    waiting: tuple[deque[tuple[int, bytes]], ...] = (deque(), deque())
    return SharedPort(bus, waiting, 0), SharedPort(bus, waiting, 1)
