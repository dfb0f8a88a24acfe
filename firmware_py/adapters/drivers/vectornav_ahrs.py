"""A VectorNav: attitude and rates at 100 Hz, which it is told to send as packets; its sentences are read too."""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.adapters.drivers.attitude import ahrs, scalar_last
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.adapters.drivers.talk import Talk
from firmware_py.wire.serial.vectornav import Attitude, messages
from firmware_py.wire.serial.vectornav_commands import set_binary_output, set_output

DIVISOR = 8
"""Of the device's own 800 Hz."""


def readings(message: Attitude, t: float) -> Iterable[Reading]:
    """Return attitude and rates that were valid at t, s; they are ok if the device calls its attitude good."""
    yield ahrs(message.angles, scalar_last(message.quaternion), message.rates, t, message.usable)


def _stamp(message: Attitude) -> float:
    return message.time


def _untold(message: Attitude) -> bool:
    """Return whether this is a sentence: they are told off, and only packets have a time."""
    return math.isnan(message.time)


TALK = Talk((set_output("off"), set_binary_output(DIVISOR, port=3)), forgotten=_untold)
VECTORNAV = Instrument(messages, readings, "ahrs", _stamp, talk=TALK)
