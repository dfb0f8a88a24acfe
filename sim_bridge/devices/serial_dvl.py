"""The Doppler log as a Water Linked A50 speaks: one `wrz` sentence per ping, over a serial line."""

from __future__ import annotations

from firmware_py.records.sensing import Dvl
from firmware_py.wire.serial import waterlink
from sim_bridge.devices.instruments import Boat
from sim_bridge.devices.sensors import Sensor
from sim_bridge.devices.serial_line import SerialLine

CLOCK_OFFSET_US = 1_742_000_000
"""What the device's own clock, which nobody set, shows at t = 0."""
UNLOCKED = Dvl(0.0, 0.0, 0.0, 0.0, -1.0)
"""What the numbers show while there is no bottom lock."""


class SerialDvl:
    """The device between its sensor and its line."""

    def __init__(self, sensor: Sensor[Boat, Dvl | None], line: SerialLine) -> None:
        self.powered = True
        self._sensor = sensor
        self._line = line
        self._last_us = 0

    def update(self, k: int, t: float, boat: Boat) -> None:
        """Sends what is ready at tick `k`, at time `t`, s; returns when the vehicle can read it."""
        reading = self._sensor.update(k, boat)
        if reading is not None and self.powered:
            self._line.send(self._sentence(reading.value, _clock(reading.t_valid), _clock(t)))

    def hear(self) -> None:
        """Takes what the vehicle wrote, so that its writes never stall; the device obeys nothing of it."""
        self._line.receive()

    def _sentence(self, dvl: Dvl | None, valid_us: int, sent_us: int) -> bytes:
        u, v, w, fom, altitude = dvl or UNLOCKED
        covariance = (fom**2, 0.0, 0.0, 0.0, fom**2, 0.0, 0.0, 0.0, fom**2)
        since_last_ms = (valid_us - self._last_us) / 1000.0 if self._last_us else 0.0
        self._last_us = valid_us
        return waterlink.encode(
            waterlink.Velocity(
                u, v, w, dvl is not None, altitude, fom, covariance, valid_us, sent_us, since_last_ms, status=0
            )
        )


def _clock(t: float) -> int:
    """The device's time at `t`, us."""
    return CLOCK_OFFSET_US + round(t * 1e6)
