"""A bus for a vehicle's drivers on which a bench tool sees every frame that they take."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection

from firmware_py.adapters.buses.can_bus import CanBus


class WatchedBus:
    """A `FramePort` around a bus.

    Args:
        bus: the bus itself.
        see: is given each frame (id, data) and when it came, s of the monotonic clock.
    """

    def __init__(self, bus: CanBus, see: Callable[[int, bytes, float], None]) -> None:
        self._bus, self._see = bus, see
        self.name = bus.name

    @property
    def sound(self) -> bool:
        """Return whether the bus is, as it says."""
        return self._bus.sound

    def drain(self, limit: int, seconds: float = 0.0) -> list[tuple[int, bytes]]:
        """Return the frames that have arrived, as the bus does."""
        frames = self._bus.drain(limit, seconds)
        now = time.monotonic()
        for can_id, data in frames:
            self._see(can_id, data, now)
        return frames

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """Send frames."""
        self._bus.send(frames)

    def losses(self) -> dict[str, int]:
        """Return how much was lost on the bus, by cause."""
        return self._bus.losses()

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()
