"""What systemd is told of a service of Type=notify: that it flies, what it waits for, and that its cycles go on.

sd_notify(3) is a datagram to the socket that the environment names; without one nothing is told.
"""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Mapping

from firmware_py.records.cycle import Cycle

_NS_PER_US = 1000
_TIMES = 3
"""The watchdog is fed so many times within its time-out."""


class ServiceManager:
    """Tells it.

    Args:
        environment: of the process: NOTIFY_SOCKET, WATCHDOG_USEC, WATCHDOG_PID.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        self._socket: socket.socket | None = None
        self._next_ns = 0
        self._ready = False
        address, timeout = environment.get("NOTIFY_SOCKET", ""), environment.get("WATCHDOG_USEC", "")
        ours = environment.get("WATCHDOG_PID", str(os.getpid())) == str(os.getpid())
        self._interval_ns = int(timeout) * _NS_PER_US // _TIMES if timeout.isdigit() and ours else 0
        if address[:1] in ("/", "@"):
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            self._socket.setblocking(False)
            try:
                self._socket.connect(address.replace("@", "\0", 1) if address[0] == "@" else address)
            except OSError:
                self.close()

    def cycled(self, cycle: Cycle) -> None:
        """Tell after the first cycle that the vehicle is up, and then in time that it goes on."""
        if not self._ready:
            self._ready = True
            self._tell("READY=1")
        if self._interval_ns and cycle.tick.t_ns >= self._next_ns:
            self._next_ns = cycle.tick.t_ns + self._interval_ns
            self._tell("WATCHDOG=1")

    def status(self, sentence: str) -> None:
        """Tell what `systemctl status` shows."""
        self._tell(f"STATUS={sentence}")

    def stopping(self) -> None:
        """Tell that the flight is over, and files are being written."""
        self._tell("STOPPING=1")

    def close(self) -> None:
        """Tell nothing any more."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _tell(self, words: str) -> None:
        if self._socket is not None:
            with contextlib.suppress(OSError):  # it does not listen now: no reason to end a flight
                self._socket.send(words.encode())
