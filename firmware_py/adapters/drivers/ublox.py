"""A u-blox receiver: the position of NAV-PVT, which it is told to send.

It is told in the packets of both generations, since it says itself what it does not know; each port of the newer one in
a packet of its own, since a receiver without that port refuses the whole.
"""

from __future__ import annotations

from collections.abc import Iterable

from firmware_py.adapters.drivers import fix_accuracy
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.adapters.drivers.talk import Talk
from firmware_py.records.sensing import Fix, Heard
from firmware_py.wire.serial import ubx, ubx_config
from firmware_py.wire.serial.ubx import NavPvt

RATE_HZ = 5.0
WEEK = 604800.0


def readings(message: NavPvt | ubx.Ack, t: float) -> Iterable[Reading]:
    """Return the position of a fix that was valid at t, s, with the receiver's estimate of its accuracy as 1 sigma."""
    if isinstance(message, NavPvt):
        std = fix_accuracy.at_least(message.horizontal_accuracy)
        value = Fix(message.latitude, message.longitude, std)
        yield Reading("fix", 0, Heard(value, t, True, message.usable and value.std > 0.0))


def _stamp(message: NavPvt | ubx.Ack) -> float:
    return message.time_of_week if isinstance(message, NavPvt) else float("nan")


TALK = Talk(
    (
        *[ubx_config.switch_on(RATE_HZ, port) for port in ("uart1", "usb")],
        ubx_config.sentences_off_older(),  # at this rate they leave NAV-PVT no room at 38,400 baud
        ubx_config.set_rate_older(RATE_HZ),
        ubx_config.message_rate_older(ubx.NAV_PVT, 1),
    )
)
UBLOX = Instrument(ubx.packets, readings, "fix", _stamp, WEEK, TALK)
