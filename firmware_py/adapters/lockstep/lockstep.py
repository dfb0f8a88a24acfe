"""Taking turns over a bus: plant and vehicle in two processes, in lockstep, with nothing lost unnoticed.

The plant sends `Tick(k)` after its frames and the vehicle `TickDone(k)` after its own; each says how many frames went
before it. Before tick 0 the plant says `Tick(HELLO)`, with its step, until the vehicle answers `TickDone(HELLO)`; who
ends first says `BYE`. The words of the lockstep itself are not counted.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TypeVar

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.messages import TICK, TICK_DONE, MessageType
from firmware_py.wire.dronecan.transfer import Reassembler, Sender

R = TypeVar("R")

VERSION = 1
"""Of the lockstep protocol; both sides must speak the same."""
HELLO = 0xFFFFFFFF
BYE = 0xFFFFFFFE
"""Values of k that are no ticks."""
PATIENCE = 4.0
"""How long the other side may be silent, s of wall time: everything has ended within 5 s."""
_GLANCE = 0.1
"""How long one wait on the bus takes at most, s, before it is seen whether someone asked to stop."""
_FRAMES = 4096


class LockstepError(Exception):
    """The other side is gone, another one, or lost a frame; the text says which."""


class LockstepLink:
    """One side's door to the bus; to devices and drivers it is a `CanBus` that holds the frames of one turn.

    Args:
        bus: the door behind it.
        node_id: under which the lockstep's own words are sent.
        theirs: the node ids of the other side; frames of anybody else are heard, but not counted.
    """

    def __init__(self, bus: CanBus, node_id: int, theirs: Iterable[int]) -> None:
        self._bus = bus
        self._theirs = frozenset(theirs)
        self._sender = Sender(node_id)
        self._reassembler = Reassembler([TICK, TICK_DONE])
        self._turn: list[tuple[int, bytes]] = []
        self._ahead: list[tuple[int, bytes]] = []
        self.heard = 0
        """Frames of the other side since its last word."""
        self.said = 0
        """Our own frames since our last word."""

    @property
    def dropped(self) -> int:
        """Frames that the bus would not take."""
        return self._bus.dropped

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """The frames of this turn, at most `limit`; the rest stay for the next."""
        frames, self._turn = self._turn[:limit], self._turn[limit:]
        return frames

    def send(self, frames: Iterable[tuple[int, bytes]]) -> None:
        """Sends frames, and counts them."""
        frames = list(frames)
        self.said += len(frames)
        self._bus.send(frames)

    def say(self, kind: MessageType[R], word: R) -> None:
        """Ends our turn."""
        self.said = 0
        self._bus.send(self._sender.send(kind, word))

    def listen(self, kind: MessageType[R], seconds: float, stop: Callable[[], bool] = lambda: False) -> R | None:
        """Waits for the other side's next word, and keeps the frames before it for `drain`.

        Returns:
            The word; None if it did not come within `seconds` of wall time, or if `stop` says so.
        """
        deadline = time.monotonic() + seconds
        while True:
            while self._ahead:
                word = self._hear(kind, *self._ahead.pop(0))
                if word is not None:
                    return word
            left = deadline - time.monotonic()
            if left <= 0.0 or stop():
                return None
            self._ahead = self._bus.drain(_FRAMES, min(left, _GLANCE))

    def forget(self) -> None:
        """Drops what was heard so far: it was said to somebody else."""
        self._turn, self.heard = [], 0

    def close(self) -> None:
        """Leaves the bus."""
        self._bus.close()

    def _hear(self, kind: MessageType[R], can_id: int, data: bytes) -> R | None:
        port = can_id >> 8 & 0xFFFF
        if can_id & 0x80 or port not in (TICK.data_type_id, TICK_DONE.data_type_id):
            self._turn.append((can_id, data))
            self.heard += can_id & 0x7F in self._theirs
            return None
        transfer = self._reassembler.accept(can_id, data, 0.0)
        if transfer is None or transfer.kind is not kind:
            return None
        try:
            return kind.decode(transfer.payload)
        except DecodeError:
            return None
