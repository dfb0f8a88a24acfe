"""A Nortek DVL: velocities in X, Y, Z, with X along the mark, Z away from its face, and the age that it tells.

Looking down with the mark forward its axes are the body's. Of single beams no velocity is made.
"""

from __future__ import annotations

from collections.abc import Iterable

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.wire.serial.nortek_dvl import Beam, Velocity, lines

LONGEST_DELAY = 10.0
"""A greater age than this is not accepted, s."""


def readings(message: Velocity | Beam, t: float) -> Iterable[Reading]:
    """Return velocity and distance of a sentence that came at t, s: they are as much older as it tells."""
    if isinstance(message, Velocity):
        timed = -LONGEST_DELAY <= message.since_output <= 0.0
        value = Dvl(message.vx, message.vy, message.vz, message.fom, message.bottom)
        yield Reading("dvl", 0, Heard(value, t + message.since_output if timed else t, True, message.usable and timed))


NORTEK = Instrument(lines, readings, "dvl")
