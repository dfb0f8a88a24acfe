"""Depth sensors on a serial line: Impact Subsea ISD4000, Valeport miniIPS. The role is absolute pressure.

A depth in metres was computed with a density of water that nobody here knows: it is heard, and not ok. A Valeport must
be told to send pressures. Its zero is that of its tare, which is taken at the surface: standard air is added, and the
vehicle takes its own zero there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Heard
from firmware_py.wire.serial.depth_sentences import Depth, lines

AIR = 101_325.0
"""Standard pressure at the surface, Pa."""


def _absolute(message: Depth, t: float) -> Iterable[Reading]:
    pressure = message.pressure if message.sentence == "ISDPT" else math.nan
    yield Reading("pressure", 0, Heard(pressure, t, True, math.isfinite(pressure)))


def _above_tare(message: Depth, t: float) -> Iterable[Reading]:
    pressure = message.pressure + AIR
    yield Reading("pressure", 0, Heard(pressure, t, True, math.isfinite(pressure)))


ISD4000 = Instrument(lines, _absolute, "pressure")
VALEPORT = Instrument(lines, _above_tare, "pressure")
