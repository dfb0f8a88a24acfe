"""A device's end of a serial line: a pseudo-terminal, which the driver of the autopilot opens like a real port.

A pseudo-terminal delivers through a kernel work queue, mostly at once and sometimes milliseconds later. A tick must
not be released before what was measured for it can be read, so `send` waits until the line has arrived.
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
"""Bytes that the reading end of a Linux pseudo-terminal holds; more than that cannot be counted."""


class SerialLine:
    """The device's end of a serial line; `path` names the end that the autopilot opens.

    The reading end is held open here too: a reader that leaves and comes back breaks nothing. Nothing ever blocks:
    what a reader does not collect is lost, as on a UART, and counted in `lost`; what did not arrive within
    `timeout` (s) is counted in `late`. With timeout 0 `send` does not wait: where both sides keep their own time, a
    reader may have taken the line before its arrival was noticed.
    """

    def __init__(self, timeout: float = 1.0) -> None:
        self._device, self._reader = os.openpty()
        tty.setraw(self._reader)
        os.set_blocking(self._device, False)
        self.path = os.ttyname(self._reader)
        self.lost = 0
        self.late = 0
        self._timeout = timeout
        self._count = array.array("i", [0])

    def waiting(self) -> int:
        """Return the number of bytes that arrived at the reading end and were not read."""
        fcntl.ioctl(self._reader, termios.FIONREAD, self._count, True)
        return self._count[0]

    def send(self, line: bytes) -> None:
        """Write one line whole and wait until it can be read, or lose it whole."""
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
        if self._timeout and self.waiting() < wanted:
            self._await(wanted)

    def receive(self) -> bytes:
        """Return what the autopilot wrote to the device, at most 1 kB; empty if nothing."""
        try:
            return os.read(self._device, 1024)
        except BlockingIOError:
            return b""

    def close(self) -> None:
        """Close the line; a second call does nothing."""
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
        deadline = time.monotonic() + self._timeout
        while self.waiting() < wanted:
            if time.monotonic() > deadline:
                self.late += 1
                return
            os.sched_yield()
