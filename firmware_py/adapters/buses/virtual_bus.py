"""python-can's virtual bus, the one of this process: a lockstep flight spends a tenth of its time on a bus."""

from __future__ import annotations

import errno
import queue
from typing import Any, TypeAlias

import can
from can.interfaces.virtual import VirtualBus, channels_lock

Taken: TypeAlias = "tuple[int, bytes] | can.Message"


class Virtual(VirtualBus):
    """A door that python-can's own doors hear and are heard by; to others like it, it hands bare frames.

    python-can makes a `can.Message` of each frame, copies it deeply for every receiver, and puts it into a queue that
    waits on locks for threads. We have no threads, nobody changes a frame, and a plain queue is enough.
    """

    def __init__(self, channel: str) -> None:
        super().__init__(channel=channel, preserve_timestamps=True)
        self.channel_info = f"virtual:{channel}"
        plain: queue.SimpleQueue[Taken] = queue.SimpleQueue()
        doors: list[Any] = self.channel
        with channels_lock:
            doors[doors.index(self.queue)] = plain
        self._doors, self._arrived = doors, plain
        self.queue: Any = plain

    def put(self, can_id: int, data: bytes) -> None:
        """Gives a frame with an extended id to everybody else; OSError after leaving."""
        if not self._open:
            raise OSError(errno.ENETDOWN, "the bus is closed")
        for door in self._doors:
            if type(door) is not queue.SimpleQueue:
                door.put(can.Message(arbitration_id=can_id, data=data, is_extended_id=True))
            elif door is not self._arrived:
                door.put((can_id, data))

    def take(self, frames: list[tuple[int, bytes]], limit: int, seconds: float = 0.0) -> None:
        """Appends the frames with extended ids that have arrived; looks at no more than `limit`.

        If there is none it waits for the first, for at most `seconds`. OSError after leaving.
        """
        if not self._open:
            raise OSError(errno.ENETDOWN, "the bus is closed")
        get = self._arrived.get
        try:
            for _ in range(limit):
                taken = get(seconds > 0.0, seconds)
                seconds = 0.0
                if type(taken) is tuple:
                    frames.append(taken)
                elif isinstance(taken, can.Message) and _is_data(taken):
                    frames.append((taken.arbitration_id, bytes(taken.data)))
        except queue.Empty:
            pass


def _is_data(message: can.Message) -> bool:
    return message.is_extended_id and not (message.is_error_frame or message.is_remote_frame or message.is_fd)
