"""The DVL in the protocol of a Water Linked A50: one `wrz` sentence per ping, over a serial line."""

from __future__ import annotations

from firmware_py.records.sensing import Dvl
from firmware_py.wire.serial import waterlink_dvl
from sim_bridge.devices.instruments import MeasuredPlant
from sim_bridge.devices.sensors import Sensor
from sim_bridge.devices.serial_line import SerialLine

CLOCK_OFFSET_US = 1_742_000_000
"""Time of the device's own clock, which is not set, at t = 0."""
UNLOCKED = Dvl(0.0, 0.0, 0.0, 0.0, -1.0)
"""The values that are sent without bottom lock."""


class SerialDvl:
    """The device: sends the readings of its sensor over its line."""

    def __init__(self, sensor: Sensor[MeasuredPlant, Dvl | None], line: SerialLine) -> None:
        self.powered = True
        self._sensor = sensor
        self._line = line
        self._last_us = 0

    def update(self, k: int, t: float, plant: MeasuredPlant) -> None:
        """Send what is ready at tick `k`, at time `t`, s; return when the autopilot can read it."""
        reading = self._sensor.update(k, plant)
        if reading is not None and self.powered:
            self._line.receive()  # and ignore what the autopilot wrote, so that its writes never block
            self._line.send(self._sentence(reading.value, _clock(reading.t_valid), _clock(t)))

    def _sentence(self, dvl: Dvl | None, valid_us: int, sent_us: int) -> bytes:
        u, v, w, fom, altitude = dvl or UNLOCKED
        covariance = (fom**2, 0.0, 0.0, 0.0, fom**2, 0.0, 0.0, 0.0, fom**2)
        since_last_ms = (valid_us - self._last_us) / 1000.0 if self._last_us else 0.0
        self._last_us = valid_us
        return waterlink_dvl.encode(
            waterlink_dvl.Velocity(
                u, v, w, dvl is not None, altitude, fom, covariance, valid_us, sent_us, since_last_ms, status=0
            )
        )


def _clock(t: float) -> int:
    """Return the device's time at `t`, us."""
    return CLOCK_OFFSET_US + round(t * 1e6)
