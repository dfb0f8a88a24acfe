"""An Xsens MTi: orientation and rate of turn, which it is told to send at 100 Hz.

Its axes are those on its housing: x forward, y to port, z up; they stay so whatever the axes of the earth are set to
(MTi User Manual MT0605P, "NWU and NED reference coordinate frames"). For this driver one that was told axes with z down
(RotSensor) is mounted upside down.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.adapters.drivers.attitude import Quaternion, ahrs, from_angles, product, scalar_last
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.adapters.drivers.talk import Talk
from firmware_py.wire.serial import xsens
from firmware_py.wire.serial.xsens import Attitude

RATE_HZ = 100
NED = 4
"""The bits of an identifier that ask for north, east, down."""
WRAP = 2.0**32 * 1e-4
_ABOUT_X: Quaternion = (1.0, 0.0, 0.0, 0.0)
"""Half a turn about x: from forward, port, up to forward, starboard, down."""
_TO_NED: dict[str, Quaternion] = {
    "NED": (0.0, 0.0, 0.0, 1.0),
    "NWU": _ABOUT_X,
    "ENU": (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0),
}


def readings(message: Attitude, t: float) -> Iterable[Reading]:
    """Return attitude and rates that were valid at t, s; they are ok if the filter's input is valid."""
    if not message.frame:
        return
    told = scalar_last(message.quaternion)
    if not math.isfinite(sum(told)):
        told = from_angles(message.angles)
    p, q, r = message.rates
    turned = product(product(_TO_NED[message.frame], told), _ABOUT_X)
    yield ahrs(message.angles, turned, (p, -q, -r), t, message.usable)


def _stamp(message: Attitude) -> float:
    return message.time


_OUTPUT = (
    (xsens.SAMPLE_TIME_FINE, 0xFFFF),
    (xsens.QUATERNION | NED, RATE_HZ),
    (xsens.RATE_OF_TURN, RATE_HZ),
    (xsens.STATUS_WORD, 0xFFFF),
)
TALK = Talk((xsens.go_to_config(), xsens.set_output_configuration(_OUTPUT), xsens.go_to_measurement()))
XSENS = Instrument(xsens.messages, readings, "ahrs", _stamp, WRAP, TALK)
