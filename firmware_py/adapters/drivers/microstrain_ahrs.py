"""A MicroStrain sensor: attitude and rates of its estimation filter, which it is told to send at 100 Hz.

It is told in the form of the CV7 family, whose filter runs at 1 kHz, and then in that of the GX5 family, at 500 Hz:
what it does not know it refuses. What the sensors say without the filter vouches for nothing and is not read. Nor is a
CV7 or GQ7 believed while its filter is a vertical gyro: one that has no magnetometer, or whose GNSS is not heard yet.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.adapters.drivers.attitude import ahrs, scalar_last
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.adapters.drivers.talk import Talk
from firmware_py.wire.serial.microstrain import (
    FILTER,
    Attitude,
    enable_stream,
    idle,
    message_format,
    packets,
    resume,
)

WEEK = 604800.0
ANGLES, RATES, STATUS, GPS_TIME, REFERENCE_TIME = 0x05, 0x0E, 0x10, 0x11, 0xD5


def readings(message: Attitude, t: float) -> Iterable[Reading]:
    """Return attitude and rates that were valid at t, s; ok if the filter knows its heading and calls them valid."""
    attitude = math.isfinite(sum(message.angles)) or math.isfinite(sum(message.quaternion))
    if message.filtered and attitude:
        yield ahrs(message.angles, scalar_last(message.quaternion), message.rates, t, message.usable)


def _stamp(message: Attitude) -> float:
    return message.time if math.isfinite(message.time) else message.week_time


TALK = Talk(
    (
        idle(),
        message_format(FILTER, dict.fromkeys((REFERENCE_TIME, ANGLES, RATES, STATUS), 10)),
        enable_stream(FILTER),
        message_format(FILTER, dict.fromkeys((GPS_TIME, ANGLES, RATES, STATUS), 5), old=True),
        enable_stream(FILTER, old=True),
        resume(),
    )
)
MICROSTRAIN = Instrument(packets, readings, "ahrs", _stamp, WEEK, TALK)
