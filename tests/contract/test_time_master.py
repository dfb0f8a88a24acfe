"""GlobalTimeSync as pydronecan reads it: who follows it as the specification says has the vehicle's time."""

from __future__ import annotations

import random
from itertools import pairwise

import dronecan
import pytest

from firmware_py.tick import Tick

from .vehicle import DISARMED, DT_NS, OWN, Vehicle

SYNC = 4
SECOND = 100
"""Ticks."""


def said(vehicle: Vehicle, k: int, late_ns: int = 0) -> list[int]:
    """What GlobalTimeSync says in a tick, us."""
    tick = Tick(k, DT_NS, late_ns)
    vehicle.hardware.read(tick)
    heard = [one for one in vehicle.said() if not one.service_not_message and one.data_type_id == SYNC]
    vehicle.hardware.write(tick, DISARMED)
    return [one.payload.previous_transmission_timestamp_usec for one in heard]


def test_a_slave_whose_clock_is_off_has_the_vehicles_time_whatever_the_lateness_of_ticks() -> None:
    random.seed(1)
    offset_us, before, errors = -123_456_789, None, []
    with Vehicle() as vehicle:
        for k in range(10 * SECOND):
            late_ns = random.randrange(0, 9_000_000, 1000)
            for stamp in said(vehicle, k, late_ns):
                if before is not None:
                    errors.append(stamp - before)
                before = (k * DT_NS + late_ns) // 1000 + offset_us
    assert errors == [-offset_us] * 9


def test_it_is_sent_once_a_second_and_first_says_that_nothing_was_sent_before() -> None:
    with Vehicle() as vehicle:
        heard = {k: found for k in range(3 * SECOND + 1) if (found := said(vehicle, k))}
    assert heard == {0: [0], 100: [1], 200: [1_000_000], 300: [2_000_000]}  # 0 is "unknown": 1 us is said for it


def test_messages_keep_their_distance_while_late_ticks_are_caught_up_on() -> None:
    """For 3 s nothing runs; then the ticks of these 3 s run within 30 ms."""
    sent = []
    with Vehicle() as vehicle:
        for k in range(8 * SECOND):
            stalled = 2 * SECOND < k < 5 * SECOND
            now_ns = 5 * SECOND * DT_NS + (k - 2 * SECOND) * 100_000 if stalled else k * DT_NS
            sent += [now_ns * 1e-9 for _ in said(vehicle, k, now_ns - k * DT_NS)]
    gaps = [b - a for a, b in pairwise(sent)]
    assert min(gaps) >= 0.04
    assert sent[-1] == 7.0


@pytest.mark.parametrize(("other", "gives_way"), [(OWN - 1, True), (OWN + 1, False)])
def test_of_two_masters_the_one_of_the_lower_id_goes_on(other: int, gives_way: bool) -> None:
    message = dronecan.uavcan.protocol.GlobalTimeSync(previous_transmission_timestamp_usec=7)
    with Vehicle() as vehicle:
        heard = {}
        for k in range(10 * SECOND):
            if 250 <= k <= 550 and k % 100 == 50:
                vehicle.node(other).send(message)
            if found := said(vehicle, k):
                heard[k] = found[0]
    if gives_way:
        assert list(heard) == [0, 100, 200, 770, 870, 970]  # 2.2 s after the last that was heard
        assert [heard[k] for k in (770, 870)] == [0, 7_700_000]
    else:
        assert list(heard) == [100 * i for i in range(10)]


def test_it_is_silent_when_it_is_not_to_be_the_master() -> None:
    with Vehicle(network={"time_master": False}) as vehicle:
        assert not any(said(vehicle, k) for k in range(2 * SECOND))
