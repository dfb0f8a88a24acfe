"""A device's end of a serial line: a real pseudo-terminal, so that the vehicle's real driver is what reads it.

A pseudo-terminal delivers through a kernel work queue, mostly at once and sometimes milliseconds later. A tick must
not be released before what was measured for it can be read, so `send` waits on the reading end until it has arrived.
"""

from __future__ import annotations

import array
import fcntl
import os
import termios
import time
import tty
from types import TracebackType

CAPACITY = 4095
"""Bytes the reading end of a Linux pseudo-terminal holds; what lies beyond them cannot be counted."""


class SerialLine:
    """The device's end of a serial line; `path` names the end that the vehicle opens.

    The reading end is held open here too: a reader that leaves and comes back breaks nothing. Nothing ever blocks:
    what a reader does not collect is lost, as on a UART, and counted in `lost`; what did not arrive within
    `patience` (s) is counted in `late`. With patience 0 nobody waits: where both sides keep their own time, a reader
    may have taken the line before it was seen to arrive.
    """

    def __init__(self, patience: float = 1.0) -> None:
        self._device, self._reader = os.openpty()
        tty.setraw(self._reader)
        os.set_blocking(self._device, False)
        self.path = os.ttyname(self._reader)
        self.lost = 0
        self.late = 0
        self._patience = patience
        self._count = array.array("i", [0])

    def waiting(self) -> int:
        """Bytes that arrived at the reading end and were not read."""
        fcntl.ioctl(self._reader, termios.FIONREAD, self._count, True)
        return self._count[0]

    def send(self, line: bytes) -> None:
        """Writes one line whole and waits until it can be read, or loses it whole."""
        wanted = self.waiting() + len(line)
        if wanted > CAPACITY:
            self.lost += 1
            return
        try:
            written = os.write(self._device, line)
        except BlockingIOError:
            written = 0
        if written < len(line):
            self.lost += 1
            return
        if self._patience and self.waiting() < wanted:
            self._await(wanted)

    def receive(self) -> bytes:
        """What the vehicle wrote to the device, at most 1 kB; empty if nothing."""
        try:
            return os.read(self._device, 1024)
        except BlockingIOError:
            return b""

    def close(self) -> None:
        """Hangs up; a second time does nothing."""
        if self._device >= 0:
            os.close(self._device)
            os.close(self._reader)
            self._device = self._reader = -1

    def __enter__(self) -> SerialLine:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _await(self, wanted: int) -> None:
        deadline = time.monotonic() + self._patience
        while self.waiting() < wanted:
            if time.monotonic() > deadline:
                self.late += 1
                return
            os.sched_yield()
