"""MAV_CMD_DO_GRIPPER: the drop weight as a station releases it, and what it hears of it."""

from __future__ import annotations

import dataclasses
import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.records.health import WeightState
from firmware_py.records.order import Arming, Mode
from tests.unit.firmware_py.mavlink.station import SOUND, LinkedVehicle, Station

GRIPPER, ARM = mavlink.MAV_CMD_DO_GRIPPER, mavlink.MAV_CMD_COMPONENT_ARM_DISARM
TERMINATE = mavlink.MAV_CMD_DO_FLIGHTTERMINATION
RELEASE, GRAB = mavlink.GRIPPER_ACTION_RELEASE, mavlink.GRIPPER_ACTION_GRAB
ACCEPTED, DENIED, FAILED, IN_PROGRESS = 0, 2, 4, 5


def weight(vehicle: LinkedVehicle, state: WeightState) -> None:
    vehicle.state["actuators"] = dataclasses.replace(SOUND, drop_weight=state)


def reporting(arm: bool = True, **options) -> tuple[LinkedVehicle, Station]:
    vehicle = LinkedVehicle(**options)
    weight(vehicle, WeightState.HELD)
    station = vehicle.stations[0]
    if arm:
        station.command(ARM, 1)
    vehicle.step(2)
    station.messages.clear()
    return vehicle, station


@pytest.mark.parametrize("arm", [True, False])
@pytest.mark.parametrize("gripper", [0, 1])
def test_the_release_is_in_progress_until_the_hardpoint_says_so_armed_or_not(arm: bool, gripper: int) -> None:
    vehicle, station = reporting(arm)
    mode = vehicle.mode
    station.command(GRIPPER, gripper, RELEASE)
    vehicle.step(2)
    [ack] = station.heard("COMMAND_ACK")
    assert (ack.command, ack.result, ack.progress) == (GRIPPER, IN_PROGRESS, 255)
    assert vehicle.mode is mode
    weight(vehicle, WeightState.COMMANDED)
    vehicle.step(100)
    assert station.acks() == []
    weight(vehicle, WeightState.RELEASED)
    vehicle.step(100)
    assert station.acks() == [(GRIPPER, ACCEPTED)]
    assert [order.release for order in vehicle.orders].count(True) == 1


@pytest.mark.parametrize(
    ("command", "params", "asked"), [(GRIPPER, (1, RELEASE), "release"), (TERMINATE, (1,), "terminate")]
)
def test_what_brings_the_vehicle_up_is_ordered_though_somebody_disarms_in_the_same_tick(
    command: int, params: tuple[float, ...], asked: str
) -> None:
    vehicle, station = reporting()
    vehicle.orders.clear()
    station.command(command, *params)
    station.command(ARM, 0)
    vehicle.step(3)
    orders = [(getattr(order, asked), order.arming) for order in vehicle.orders]
    assert orders == [(True, Arming.KEEP), (False, Arming.DISARM), (False, Arming.KEEP)]
    assert [number for number, _ in station.acks()] == [command, ARM]


@pytest.mark.parametrize("end", [WeightState.STUCK, WeightState.NOT_CONFIRMED])
def test_a_release_that_is_not_confirmed_has_failed(end: WeightState) -> None:
    vehicle, station = reporting()
    station.command(GRIPPER, 1, RELEASE)
    vehicle.step(2)
    weight(vehicle, end)
    vehicle.step(2)
    assert station.acks() == [(GRIPPER, IN_PROGRESS), (GRIPPER, FAILED)]


def test_a_relay_is_believed_at_once() -> None:
    vehicle, station = reporting()
    weight(vehicle, WeightState.UNREPORTED)
    station.command(GRIPPER, 1, RELEASE)
    vehicle.step(2)
    assert station.acks() == [(GRIPPER, ACCEPTED)]


def test_who_asks_again_while_it_is_in_progress_hears_so_and_orders_nothing_more() -> None:
    vehicle, station = reporting()
    for again in range(3):
        station.command(GRIPPER, 1, RELEASE, again=again)
        vehicle.step(20)
    assert station.acks() == [(GRIPPER, IN_PROGRESS)] * 3
    assert [order.release for order in vehicle.orders].count(True) == 1
    station.command(ARM, 0)
    vehicle.step(2)
    assert station.acks() == [(ARM, ACCEPTED)]
    assert vehicle.mode is Mode.DISARMED
    weight(vehicle, WeightState.RELEASED)
    vehicle.step(2)
    assert station.acks() == [(GRIPPER, ACCEPTED)]


@pytest.mark.parametrize(
    ("params", "there", "why"),
    [
        ((1, RELEASE), False, "no drop weight"),
        ((2, RELEASE), True, "no gripper 2"),
        ((math.nan, RELEASE), True, "no gripper nan"),
        ((1, GRAB), True, "can only be released"),
        ((1, math.nan), True, "can only be released"),
    ],
)
def test_what_cannot_be_done_is_denied_with_a_reason(params, there: bool, why: str) -> None:
    vehicle, station = reporting(drop_weight=there)
    station.command(GRIPPER, *params)
    vehicle.step(2)
    texts = "".join(message.text for message in station.messages if message.get_type() == "STATUSTEXT")
    assert station.acks() == [(GRIPPER, DENIED)]
    assert why in texts
    assert not any(order.release for order in vehicle.orders)


def test_stations_see_the_state_of_a_weight_that_is_reported_by_name() -> None:
    vehicle, station = reporting()
    weight(vehicle, WeightState.STUCK)
    vehicle.step(100)
    assert {(m.name, m.value) for m in station.heard("NAMED_VALUE_FLOAT")} == {("weight", float(WeightState.STUCK))}
