"""Whether a bus carries frames at all, as a health of the vehicle: down, off the bus, error-passive."""

from __future__ import annotations

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.drivers.driver import SOUND, Driver, Reading
from firmware_py.records.sensing import NodeBits, bus_bit


class BusWatch(Driver):
    """Watches one bus, whose drivers read it; which, `name` of `sensing.BUSES` says."""

    def __init__(self, name: str, bus: FramePort) -> None:
        self._bus, self._wrong = bus, NodeBits(unhealthy=bus_bit(name))

    def poll(self, _t: float) -> tuple[Reading, ...]:
        """Return nothing: a bus measures nothing."""
        return ()

    def nodes(self, _t: float) -> NodeBits:
        """Return the bit of the bus if it is not sound; what is silent on it tells the rest."""
        return SOUND if self._bus.sound else self._wrong
