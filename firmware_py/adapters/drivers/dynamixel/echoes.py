"""Our own packets on a half-duplex line: some adapters return what they send."""

from __future__ import annotations

from collections import deque

from firmware_py.wire.serial import dynamixel
from firmware_py.wire.serial.dynamixel import Instruction

_BURSTS = 2
"""An adapter that is late once returns a burst when the next one is out already."""


class Echoes:
    """The packets of our last bursts that may come back still. They are looked at only where an instruction comes."""

    def __init__(self) -> None:
        self._bursts: deque[bytes | list[Instruction]] = deque(maxlen=_BURSTS)

    def sent(self, burst: bytes) -> None:
        """Take what was sent at once."""
        self._bursts.append(burst)

    def take(self, packet: Instruction) -> bool:
        """Return whether an instruction is one of ours; each comes back once."""
        for i, burst in enumerate(self._bursts):
            waiting = dynamixel.instructions().feed(burst) if isinstance(burst, bytes) else burst
            self._bursts[i] = waiting
            if packet in waiting:
                waiting.remove(packet)
                return True
        return False
