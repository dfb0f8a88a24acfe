"""MANUAL_CONTROL: where the sticks turn fins and propeller to."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.commands.manual_control import ManualControlParams, sticks
from firmware_py.records.order import NO_ORDER, Arming
from tests.unit.firmware_py.mavlink.station import LinkedVehicle

PARAMS = ManualControlParams(delta_s_full=0.2, delta_r_full=0.3, n_full=8.0)
NONE = 32767
axis = st.integers(-32768, 32767)


def control(x: int = 0, y: int = 0, z: int = 500, r: int = 0, system: int = 1):
    return mavlink.MAVLink_manual_control_message(system, x, y, z, r, 0)


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (control(), (0.0, 0.0, 0.0)),
        (control(x=1000), (0.0, 0.0, 8.0)),
        (control(x=-500), (0.0, 0.0, -4.0)),
        (control(r=1000), (0.0, -0.3, 0.0)),  # starboard: a positive rudder angle turns to port
        (control(y=1000), (0.0, 0.0, 0.0)),
        (control(y=500, r=NONE), (0.0, -0.15, 0.0)),
        (control(z=1000), (-0.2, 0.0, 0.0)),  # up: a positive stern plane dives
        (control(z=0), (0.2, 0.0, 0.0)),
        (control(NONE, NONE, NONE, NONE), (0.0, 0.0, 0.0)),
        (control(5000, 0, 9000, -9000), (-0.2, 0.3, 8.0)),
    ],
)
def test_each_axis_moves_its_own(message, expected) -> None:
    assert sticks(PARAMS, message) == pytest.approx(expected)


def test_a_throttle_that_goes_from_minus_1000_rests_at_zero() -> None:
    params = ManualControlParams(delta_s_full=0.2, z_centre=0.0)
    assert sticks(params, control(z=0)).delta_s == 0.0
    assert sticks(params, control(z=-1000)).delta_s == pytest.approx(0.2)


@given(axis, axis, axis, axis)
def test_no_stick_asks_for_more_than_full(x: int, y: int, z: int, r: int) -> None:
    delta_s, delta_r, n = sticks(PARAMS, control(x, y, z, r))
    assert abs(delta_s) <= 0.2
    assert abs(delta_r) <= 0.3
    assert abs(n) <= 8.0


def test_sticks_keep_the_time_at_which_they_were_heard() -> None:
    vehicle = LinkedVehicle()
    vehicle.step(3)
    vehicle.stations[0].send(control(x=1000))
    vehicle.step(100)
    assert vehicle.orders[2] is NO_ORDER
    assert {order.t_sticks for order in vehicle.orders[3:]} == {0.03}
    assert vehicle.orders[-1].sticks.n == pytest.approx(ManualControlParams().n_full)


def test_sticks_are_not_let_go_of_while_a_command_is_obeyed() -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].send(control(x=1000))
    vehicle.stations[0].command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
    vehicle.step()
    (order,) = vehicle.orders
    assert order.arming is Arming.ARM
    assert order.sticks.n > 0.0


def test_of_several_links_the_last_word_steers() -> None:
    vehicle = LinkedVehicle(links=2)
    vehicle.stations[1].send(control(x=1000))
    vehicle.step()
    vehicle.stations[0].send(control(x=-1000))
    vehicle.step()
    assert [math.copysign(1.0, order.sticks.n) for order in vehicle.orders] == [1.0, -1.0]


def test_another_vehicles_sticks_are_not_ours() -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].send(control(x=1000, system=2))
    vehicle.step()
    assert vehicle.orders == [NO_ORDER]
