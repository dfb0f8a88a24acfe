"""An echo sounder that speaks NMEA 0183: distances from its transducer to the bottom (DPT, DBT)."""

from __future__ import annotations

from collections.abc import Iterable

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Heard
from firmware_py.wire.serial import nmea0183
from firmware_py.wire.serial.nmea_messages import BelowTransducer, Message


def readings(message: Message, t: float) -> Iterable[Reading]:
    """Return the distance of a sentence that came at t, s; it is ok if a bottom was found.

    The offset to waterline or keel is left out: where the transducer sits is the vehicle's.
    """
    if isinstance(message, BelowTransducer):
        yield Reading("altitude", 0, Heard(message.distance, t, True, message.usable))


NMEA_SOUNDER = Instrument(nmea0183.lines, readings, "altitude")
