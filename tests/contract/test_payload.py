"""What unknown nodes send by KeyValue is in the frame of the tick in which it came, so much of it and no more."""

from __future__ import annotations

import math

import dronecan
import pytest

from firmware_py.adapters.drivers.dronecan.devices import PAYLOAD_PER_TICK
from firmware_py.tick import Tick

from .vehicle import DT_NS, Vehicle

FOREIGN = 77


@pytest.fixture
def vehicle():
    with Vehicle() as vehicle:
        yield vehicle


def say(vehicle: Vehicle, value: float, key: str | bytes) -> None:
    vehicle.node(FOREIGN).send(dronecan.uavcan.protocol.debug.KeyValue(value=value, key=key))


def heard(vehicle: Vehicle, k: int) -> list:
    return [(one.key, one.value, one.t_valid) for one in vehicle.read(k).payload]


def test_it_is_heard_in_its_tick_and_no_later(vehicle: Vehicle) -> None:
    assert heard(vehicle, 0) == []
    say(vehicle, 9.5, "ctd.temperature")
    say(vehicle, -2.0, "k" * 58)
    t = Tick(1, DT_NS).t
    assert heard(vehicle, 1) == [("ctd.temperature", 9.5, t), ("k" * 58, -2.0, t)]
    assert heard(vehicle, 2) == []


def test_what_the_sensor_does_not_know_is_nan(vehicle: Vehicle) -> None:
    say(vehicle, math.nan, "ctd.salinity")
    ((_, value, _),) = heard(vehicle, 0)
    assert math.isnan(value)


def test_a_node_that_floods_is_held_to_so_many_a_tick_and_the_rest_is_counted(vehicle: Vehicle) -> None:
    assert "payload_left_out" not in vehicle.hardware.losses()
    for k in range(PAYLOAD_PER_TICK + 5):
        say(vehicle, float(k), "flood")
    assert [value for _, value, _ in heard(vehicle, 0)] == [float(k) for k in range(PAYLOAD_PER_TICK)]
    assert vehicle.hardware.losses()["payload_left_out"] == 5


def test_a_key_that_is_no_text_reaches_nobodys_terminal_as_it_is(vehicle: Vehicle) -> None:
    say(vehicle, 1.0, b"\x1b[2Jctd\n\xff")
    assert [key for key, _, _ in heard(vehicle, 0)] == ["\\x1b[2Jctd\\n\\xff"]
