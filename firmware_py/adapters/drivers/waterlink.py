"""A Water Linked DVL: what its velocity reports say, over its serial line or as JSON over TCP."""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.stream_driver import Instrument
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.wire.serial import waterlink_json
from firmware_py.wire.serial.waterlink_dvl import Velocity, lines

LONGEST_DELAY_US = 10_000_000
"""A greater delay than this between validity and transmission is not accepted, us."""


def readings(report: Velocity, t: float) -> Iterable[Reading]:
    """Return the velocity and distance of a report that came at t, s.

    The device has its own clock, so the time of validity is that of arrival less the delay between validity and
    transmission that it reports.
    """
    delay_us = report.time_of_transmission_us - report.time_of_validity_us
    timed = 0 <= delay_us <= LONGEST_DELAY_US
    value = Dvl(report.vx, report.vy, report.vz, report.fom, report.bottom)
    ok = report.usable and timed and math.isfinite(report.fom)
    yield Reading("dvl", 0, Heard(value, t - delay_us * 1e-6 if timed else t, True, ok))


WATERLINK = Instrument(lines, readings, "dvl")
WATERLINK_JSON = Instrument(waterlink_json.lines, readings, "dvl")
