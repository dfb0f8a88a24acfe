from __future__ import annotations

import dataclasses

from firmware_py.tick import Tick
from tests.unit.firmware_py.mavlink.station import DT_NS, cycle, node, parse


def test_the_histogram_of_lateness_is_told_once_a_second_and_counts_every_cycle() -> None:
    vehicle = node()
    late_us = (0, 15, 16, 31, 32, 999, 10_000_000)
    arrays = []
    for k in range(300):
        seen = dataclasses.replace(cycle(k), tick=Tick(k, DT_NS, late_us[k % 7] * 1000))
        arrays += [m for m in parse(vehicle.report(seen)[0]) if m.get_type() == "DEBUG_FLOAT_ARRAY"]
    told = [m for m in arrays if m.name == "late_us"]
    assert len(told) == 3
    assert sum(m.name == "damage" for m in arrays) == 3
    assert sum(m.name == "fins" for m in arrays) == 24
    counts = told[-1].data[:16]
    assert sum(counts) == 206  # the cycles up to 2.05 s
    assert counts[0] == sum(late_us[k % 7] < 16 for k in range(206))  # below 16 us
    assert counts[1] == sum(16 <= late_us[k % 7] < 32 for k in range(206))
    assert counts[6] == sum(512 <= late_us[k % 7] < 1024 for k in range(206))
    assert counts[15] == sum(late_us[k % 7] > 262_144 for k in range(206))
