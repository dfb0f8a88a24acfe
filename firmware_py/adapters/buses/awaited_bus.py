"""A bus that need not be there yet: an adapter that is plugged in later, or an interface that is brought up later.

Until then it is silence, and it is silence again when the interface is gone. It is opened anew every second, so that
what was unplugged comes back.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Collection

from firmware_py.adapters.buses.bus_health import STATES
from firmware_py.adapters.buses.can_bus import BusAbsentError, BusError, CanBus, open_bus

RETRY_S = 1.0
"""How often a bus that is not there is opened again, and one that is there is looked for."""


class AwaitedBus(CanBus):
    """One node on a bus that is there at times.

    Args:
        spec: its name, as `open_bus` knows it.
        standard: whether frames with standard ids are received too.

    Attributes:
        missing: why it is not there; empty while it is.

    Raises:
        BusError: there can be no such bus.
    """

    def __init__(self, spec: str, *, standard: bool = False) -> None:
        self._spec, self._standard = spec, standard
        self._bus_now: CanBus | None = None
        self._before: dict[str, int] = {}
        self.missing = ""
        self._open()

    @property
    def name(self) -> str:
        """Return the name that `open_bus` knows."""
        return self._spec

    @property
    def sound(self) -> bool:
        """See `CanBus`; one that is not there is not."""
        return self._bus_now is not None and self._bus_now.sound

    def drain(self, limit: int, seconds: float = 0.0) -> list[tuple[int, bytes]]:
        """See `CanBus`."""
        if time.monotonic() - self._looked >= RETRY_S:
            self._look()
        if self._bus_now is not None:
            return self._bus_now.drain(limit, seconds)
        time.sleep(seconds)
        return []

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        """See `CanBus`; what is sent while there is no bus is not counted."""
        if self._bus_now is not None:
            self._bus_now.send(frames)

    def losses(self) -> dict[str, int]:
        """See `CanBus`; counted over all openings."""
        now = self._bus_now.losses() if self._bus_now is not None else {"down": 1}
        return {name: self._before.get(name, 0) + now.get(name, 0) for name in {**self._before, **now}}

    def close(self) -> None:
        """Leave the bus; may be called twice."""
        if self._bus_now is not None:
            self._before = {name: count for name, count in self.losses().items() if name not in STATES}
            self._bus_now.close()
            self._bus_now = None

    def _look(self) -> None:
        self._looked = time.monotonic()
        if self._bus_now is None:
            try:
                self._open()
            except BusError as error:  # what could be a bus at the start is none now
                self.missing = str(error)
        elif self._interface() != self._opened_as:
            self.missing = f"bus {self._spec}: its interface is gone"
            self.close()

    def _open(self) -> None:
        self._looked = time.monotonic()
        try:
            self._opened_as = self._interface()
            self._bus_now = open_bus(self._spec, standard=self._standard)
            self.missing = ""
        except BusAbsentError as error:
            self.missing = str(error)

    def _interface(self) -> int:
        """Return the kernel's number of the interface, another one after each plugging in; 0 if there is none."""
        kind, _, interface = self._spec.partition(":")
        try:
            return socket.if_nametoindex(interface) if kind == "socketcan" else 0
        except OSError:
            return 0
