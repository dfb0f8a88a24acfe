"""A DVL that speaks PD6: Teledyne's, and Water Linked's in the same format with its own axes.

Teledyne's X points to beam 2, Y to beam 3, Z away from the bottom: with beam 3 forward, looking down, X is to
starboard, Y forward and Z up. Water Linked fills the same fields forward, to starboard, down. The format has no figure
of merit (it is unknown), and no checksum.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.wire.serial.pd6 import BottomTrack, ensembles

DAY = 86400.0


def _waterlink(message: BottomTrack, t: float) -> Iterable[Reading]:
    value = Dvl(message.vx, message.vy, message.vz, math.nan, message.distance)
    yield Reading("dvl", 0, Heard(value, t, True, message.usable))


def _teledyne(message: BottomTrack, t: float) -> Iterable[Reading]:
    value = Dvl(message.vy, message.vx, -message.vz, math.nan, message.distance)
    yield Reading("dvl", 0, Heard(value, t, True, message.usable))


def _stamp(message: BottomTrack) -> float:
    return message.time


PD6_TELEDYNE = Instrument(ensembles, _teledyne, "dvl", _stamp, DAY)
PD6_WATERLINK = Instrument(ensembles, _waterlink, "dvl", _stamp, DAY)
