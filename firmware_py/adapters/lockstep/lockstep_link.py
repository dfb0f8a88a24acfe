"""The lockstep protocol on a bus: plant and vehicle in two processes step together, and no loss goes unnoticed.

The plant sends `Tick(k)` after its frames and the vehicle `TickDone(k)` after its own; each says how many frames were
sent before it. Before tick 0 the plant sends `Tick(HELLO)`, with its step, until the vehicle acknowledges by
`TickDone(HELLO)`; the side that ends first sends `BYE`. The messages of the lockstep itself are not counted.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable
from typing import TypeVar

from firmware_py.adapters.buses.can_bus import CanBus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.wire.dronecan.dsdl_types import DecodeError
from firmware_py.wire.dronecan.message_table import TICK, TICK_DONE, MessageType
from firmware_py.wire.dronecan.transfer import Reassembler, TransferSender

R = TypeVar("R")

VERSION = 1
"""Of the lockstep protocol; both sides must have the same."""
HELLO = 0xFFFFFFFF
BYE = 0xFFFFFFFE
"""Values of k that are no ticks."""
TIMEOUT = 4.0
"""How long the other side may be silent, s of wall time: everything has ended within 5 s."""
_POLL = 0.1
"""How long one wait on the bus takes at most, s, before `stop` is asked."""
_FRAMES = 4096


class LockstepError(Exception):
    """The other side is gone, is not the expected one, or lost a frame; the text says which."""


class LockstepLink:
    """One side of the lockstep; to devices and drivers it is a `FramePort` that holds the frames of one step.

    Args:
        bus: the bus that carries them.
        node_id: of the sender of our lockstep messages.
        other_nodes: the node ids of the other side; frames of other nodes are passed on, but not counted.
    """

    def __init__(self, bus: CanBus, node_id: int, other_nodes: Iterable[int]) -> None:
        self._bus = bus
        self._other_nodes = frozenset(other_nodes)
        self._sender = TransferSender(node_id)
        self._reassembler = Reassembler([TICK, TICK_DONE])
        self._step_frames: list[tuple[int, bytes]] = []
        self._unread: list[tuple[int, bytes]] = []
        self.frames_received = 0
        """Frames of the other side since its last lockstep message."""
        self.frames_sent = 0
        """Our own frames since our last lockstep message."""

    @property
    def sound(self) -> bool:
        """Return whether the bus is."""
        return self._bus.sound

    def drain(self, limit: int) -> list[tuple[int, bytes]]:
        """Return the frames of this step, at most `limit`; the rest stay for the next."""
        frames, self._step_frames = self._step_frames[:limit], self._step_frames[limit:]
        return frames

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """Send frames, and count them."""
        self.frames_sent += len(frames)
        self._bus.send(frames)

    def send_message(self, kind: MessageType[R], message: R) -> None:
        """Send a lockstep message, which ends our part of the step."""
        self.frames_sent = 0
        self._bus.send(self._sender.send(kind, message))

    def receive_message(
        self, kind: MessageType[R], seconds: float, stop: Callable[[], bool] = lambda: False
    ) -> R | None:
        """Wait for the other side's next lockstep message, and keep the frames before it for `drain`.

        Returns:
            The message; None if it did not come within `seconds` of wall time, or if `stop` returned True.
        """
        deadline = time.monotonic() + seconds
        while True:
            while self._unread:
                message = self._take(kind, *self._unread.pop(0))
                if message is not None:
                    return message
            left = deadline - time.monotonic()
            if left <= 0.0 or stop():
                return None
            self._unread = self._bus.drain(_FRAMES, min(left, _POLL))

    def discard(self) -> None:
        """Drop the frames received so far: they belong to no step of this run."""
        self._step_frames, self.frames_received = [], 0

    def losses(self) -> dict[str, int]:
        """Return how much was lost on the bus, by cause."""
        return self._bus.losses()

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _take(self, kind: MessageType[R], can_id: int, data: bytes) -> R | None:
        """Return the lockstep message that a frame completes; keep every other frame."""
        data_type_id = can_id >> 8 & 0xFFFF
        if can_id & 0x80 or data_type_id not in (TICK.data_type_id, TICK_DONE.data_type_id):
            self._step_frames.append((can_id, data))
            # A standard id does not name its sender: there is nobody else on a bus in lockstep.
            self.frames_received += can_id >= STANDARD or can_id & 0x7F in self._other_nodes
            return None
        transfer = self._reassembler.accept(can_id, data, 0.0)
        if transfer is None or transfer.kind is not kind:
            return None
        try:
            return kind.decode(transfer.payload)
        except DecodeError:
            return None
