"""The devices' end of the bus, with faults: down, losing frames, or full of others'."""

from __future__ import annotations

from collections.abc import Callable, Collection

from firmware_py.adapters.buses.can_bus import FramePort

_BABBLE_ID = 0x1F << 24 | 0x4E20 << 8 | 0x7E
"""Lowest priority, a data type that nobody knows (20000), from node 126."""


class FaultyBus:
    """A `FramePort` around another one; all faults are off at first.

    Attributes:
        down: whether it carries nothing.
        lost: decides for each frame, either way, whether it is lost; None: none is.
        babble: frames of no use, sent at each `tick`, Hz.
        babbled: how many of these were sent.
    """

    def __init__(self, bus: FramePort) -> None:
        self.down = False
        self.lost: Callable[[], bool] | None = None
        self.babble = 0.0
        self.babbled = 0
        self._bus = bus
        self._due = 0.0

    @property
    def sound(self) -> bool:
        """Return whether the bus itself is."""
        return self._bus.sound

    def tick(self, dt: float) -> None:
        """Send what a babbling node sends within dt, s."""
        if not self.babble:
            return
        self._due += self.babble * dt
        count = int(self._due)
        self._due -= count
        self.babbled += count
        self._bus.send([(_BABBLE_ID, bytes(8))] * count)

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the frames that have arrived and were not lost."""
        frames = self._bus.drain(limit)
        if self.down:
            return []
        return frames if self.lost is None else self._kept(frames, self.lost)

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """Send the frames that are not lost."""
        if not self.down:
            self._bus.send(frames if self.lost is None else self._kept(frames, self.lost))

    def losses(self) -> dict[str, int]:
        """Return what the bus itself lost; what a fault lost is not counted."""
        return dict(self._bus.losses())

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    @staticmethod
    def _kept(frames: Collection[tuple[int, bytes]], lost: Callable[[], bool]) -> list[tuple[int, bytes]]:
        return [frame for frame in frames if not lost()]
