"""What was lost on buses, serial lines and links, as SYS_STATUS has it."""

from __future__ import annotations

from collections.abc import Mapping

_MOST = 65535
_BUS, _STATIONS = ("bus_", "second_bus_", "transfers_", "hil_"), ("gcs_",)
_NO_LOSS = {
    "transfers_duplicate",
    *(f"{bus}_{state}" for bus in ("bus", "second_bus") for state in ("down", "off", "passive")),
}
"""Of these: what came twice, and what is 1 while a bus is so."""
_LINE = "_broken"
"""A line says whether it is broken, which no node of a bus does: so it is known by whatever name its device has."""
_OF_LINE = ("bad_checksum", "malformed", "too_long", "line_errors", "not_sent", "unanswered")


class Communication:
    """Sums of the counts of what was lost; each is 65535 at most.

    Attributes:
        bus: frames and transfers lost on the CAN buses, or bytes that were no message of a simulator.
        serial: messages lost on the lines of instruments and servos.
        stations: messages from and to ground stations, on all links.
        drop_rate: share of the last second's transfers on the buses that was lost, 0.01 %.
    """

    def __init__(self) -> None:
        self.bus = self.serial = self.stations = self.drop_rate = 0
        self._received = self._lost = 0

    def update(self, lost: Mapping[str, int], received: int) -> None:
        """Take all counts since the start, by source and cause, and how many transfers have arrived; once a second."""
        lines = [name.removesuffix(_LINE) for name in lost if name.endswith(_LINE)]
        bus, stations = _sum(lost, _BUS), _sum(lost, _STATIONS)
        serial = sum(lost.get(f"{line}_{cause}", 0) for line in lines for cause in _OF_LINE)
        self.bus, self.serial, self.stations = (min(count, _MOST) for count in (bus, serial, stations))
        arrived, gone = received - self._received, bus - self._lost
        self._received, self._lost = received, bus
        self.drop_rate = round(10_000 * gone / (gone + arrived)) if gone > 0 else 0


def _sum(lost: Mapping[str, int], prefixes: tuple[str, ...]) -> int:
    return sum(count for name, count in lost.items() if name.startswith(prefixes) and name not in _NO_LOSS)
