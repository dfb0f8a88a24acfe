"""A link to a ground station that cannot be opened yet: a radio is plugged in later, a network comes up later."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable

from firmware_py.adapters.ground.station_link import GroundError, LinkAbsentError, LinkSpec, StationLink

RETRY_S = 1.0
"""How often it is tried again."""


class AwaitedLink:
    """A `StationLink` that is opened every second until that works; then it is as the other.

    To look up a name may take seconds, which no cycle has: a host that is given by a name is not tried again.
    """

    def __init__(self, spec: LinkSpec, open_now: Callable[[LinkSpec], StationLink], why: LinkAbsentError) -> None:
        self.configuration, self.name = spec.configuration, spec.text
        self._spec, self._open = spec, open_now
        self._link: StationLink | None = None
        self._tried = time.monotonic()
        self._again = spec.kind == "serial" or _is_number(spec.address[0])
        self.missing = why.why if self._again else f"{why.why}; given up: write the host's address in numbers"
        """Why it is not open; empty once it is."""

    @property
    def lost(self) -> int:
        """See `StationLink`."""
        return 0 if self._link is None else self._link.lost

    @property
    def overrun(self) -> int:
        """See `StationLink`."""
        return 0 if self._link is None else self._link.overrun

    def fileno(self) -> int:
        """See `StationLink`."""
        return -1 if self._link is None else self._link.fileno()

    def receive(self) -> list[bytes]:
        """See `StationLink`; try to open it."""
        if self._link is None and self._again and time.monotonic() - self._tried >= RETRY_S:
            self._tried = time.monotonic()
            try:
                self._link, self.missing = self._open(self._spec), ""
            except GroundError as error:  # it may be another reason by now: who waits is told what to do
                self.missing = error.why if isinstance(error, LinkAbsentError) else str(error)
        return [] if self._link is None else self._link.receive()

    def send(self, datagram: bytes) -> None:
        """See `StationLink`."""
        if self._link is not None:
            self._link.send(datagram)

    def close(self) -> None:
        """Close it; may be called twice."""
        self._again = False
        if self._link is not None:
            self._link.close()


def _is_number(host: str) -> bool:
    try:
        socket.inet_pton(socket.AF_INET, host)
    except OSError:
        return False
    return True
