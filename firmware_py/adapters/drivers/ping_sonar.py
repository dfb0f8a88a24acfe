"""A Blue Robotics echosounder (Ping1D, Ping2) as an altimeter: it is told to measure by itself."""

from __future__ import annotations

from collections.abc import Iterable

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.adapters.drivers.talk import Talk
from firmware_py.records.sensing import Heard
from firmware_py.wire.serial import ping

INTERVAL = 0.1
"""Between pings, s."""
SOUND_SPEED = 1500.0
"""Nominal, m/s."""
LEAST_CONFIDENCE = 0.5
"""Ours: an echo of less is heard, and not ok."""


def readings(message: ping.Message, t: float) -> Iterable[Reading]:
    """Return the distance of an echo that came at t, s: it was reflected half of its way before."""
    if isinstance(message, ping.Distance):
        ok = message.usable and message.confidence >= LEAST_CONFIDENCE
        yield Reading("altitude", 0, Heard(message.distance, t - message.distance / SOUND_SPEED, True, ok))


TALK = Talk((ping.set_mode_auto(True), ping.set_ping_interval(INTERVAL), ping.continuous_start()))
PING = Instrument(ping.packets, readings, "altitude", talk=TALK)
