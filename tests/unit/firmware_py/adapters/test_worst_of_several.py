"""Sensors of one node that are told apart by an id: which of them is heard."""

from __future__ import annotations

import math

from firmware_py.adapters.drivers.dronecan.worst_of_several import SLOW_S, altimeters, batteries, hygrometers
from firmware_py.wire.dronecan.equipment_messages import BatteryInfo, Hygrometer, RangeMeasurement


def wet(percent: float, which: int) -> Hygrometer:
    return Hygrometer(20.0, percent, which)


def pack(charge: int, which: int, voltage: float = 48.0) -> BatteryInfo:
    return BatteryInfo(300.0, voltage, 3.0, 0.0, 0.0, 0.0, 0.0, 0, 100, charge, 0, which, 0, b"")


def distance(metres: float, which: int, reading: int = 1) -> RangeMeasurement:
    return RangeMeasurement(0, which, None, 0.1, 1, reading, metres)  # type: ignore[arg-type]


def test_one_sensor_is_heard_always() -> None:
    several, values = hygrometers(), (35.0, 90.0, 20.0, math.nan, 50.0, 35.0)
    heard = [several.hear(wet(value, 7), 5.0 * i, True) for i, value in enumerate(values)]
    assert [one is not None and one.ok for one in heard] == [True, True, True, False, True, True]


def test_sensors_that_dry_together_are_heard_at_the_rate_of_one() -> None:
    several = hygrometers()
    heard = [several.hear(wet(90.0 - 0.1 * i, i % 2), 0.5 * i, True) for i in range(200)]
    assert sum(one is not None for one in heard) == 100


def test_one_that_became_better_gives_way_to_the_next_worse_report() -> None:
    several = hygrometers()
    sent = [(100.0, 1), (35.0, 0), (30.0, 1), (35.0, 0), (30.0, 1)]
    heard = [several.hear(wet(*one), 0.5 * i, True) for i, one in enumerate(sent)]
    assert [one and one.value for one in heard] == [1.0, None, 0.3, 0.35, None]


def test_what_knows_nothing_hides_no_other_and_is_heard_where_it_is_alone() -> None:
    several = batteries()
    sent = [pack(127, 0), pack(80, 1), pack(127, 0), pack(2, 2, voltage=math.nan), pack(70, 1)]
    heard = [several.hear(one, 0.5 * i, True) for i, one in enumerate(sent)]
    assert [one and one.value.remaining for one in heard[1:]] == [0.8, None, None, 0.7]
    assert heard[0] is not None
    assert heard[0].ok
    unknown = several.hear(pack(127, 0), 2.0 + SLOW_S + 0.01, True)
    assert unknown is not None
    assert math.isnan(unknown.value.remaining)


def test_what_is_not_believed_is_told_on_and_hides_no_other() -> None:
    several = hygrometers()
    assert several.hear(wet(90.0, 1), 0.0, True) is not None
    assert several.hear(wet(100.0, 0), 0.1, False) is not None
    assert several.hear(wet(50.0, 1), 0.2, True) is not None


def test_an_altimeter_that_is_too_near_to_the_bottom_is_not_replaced_by_one_that_is_far_from_it() -> None:
    several, too_close = altimeters(), 2
    sent = [distance(0.5, 0), distance(20.0, 1), distance(0.2, 0, too_close), distance(20.0, 1), distance(0.6, 0)]
    heard = [several.hear(one, 0.1 * i, True) for i, one in enumerate(sent)]
    told = [one and (one.value, one.ok) for one in heard]
    assert told == [(0.5, True), None, (0.2, False), None, (0.6, True)]
