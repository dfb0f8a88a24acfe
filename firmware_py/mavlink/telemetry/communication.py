"""What was lost on bus, serial lines and links, as SYS_STATUS has it."""

from __future__ import annotations

from collections.abc import Mapping

_MOST = 65535
_BUS, _SERIAL, _STATIONS = ("bus_", "transfers_", "hil_"), ("dvl_", "lines_"), ("gcs_",)


class Communication:
    """Sums of the counts of what was lost; each is 65535 at most.

    Attributes:
        bus: frames and transfers lost on the CAN bus, or bytes that were no message of a simulator.
        serial: lines of the DVL.
        stations: messages from and to ground stations, on all links.
        drop_rate: share of the last second's transfers on the bus that was lost, 0.01 %.
    """

    def __init__(self) -> None:
        self.bus = self.serial = self.stations = self.drop_rate = 0
        self._received = self._lost = 0

    def update(self, lost: Mapping[str, int], received: int) -> None:
        """Take all counts since the start, by source and cause, and how many transfers have arrived; once a second."""
        bus, serial, stations = (_sum(lost, prefixes) for prefixes in (_BUS, _SERIAL, _STATIONS))
        self.bus, self.serial, self.stations = (min(count, _MOST) for count in (bus, serial, stations))
        arrived, gone = received - self._received, bus - self._lost
        self._received, self._lost = received, bus
        self.drop_rate = round(10_000 * gone / (gone + arrived)) if gone > 0 else 0


def _sum(lost: Mapping[str, int], prefixes: tuple[str, ...]) -> int:
    return sum(count for name, count in lost.items() if name.startswith(prefixes))
