"""Setpoints: what each way of saying depth, heading, speed and place comes to, and in which modes it may be said."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.marine import local_to_geodetic
from firmware_py.records.order import NOBODY, Arming, Asker, Mode, Setpoint
from tests.unit.firmware_py.mavlink.station import FREE, ORIGIN, STATE, LinkedVehicle, Station, put_together

ACCEPTED, REJECTED, DENIED, UNSUPPORTED, NO_FRAME = 0, 1, 2, 3, 9
NAN = math.nan
AMSL, LOCAL, RELATIVE, TERRAIN = 5, 1, 6, 11
REPOSITION, CHANGE_MODE = mavlink.MAV_CMD_DO_REPOSITION, 1
LATITUDE, LONGITUDE = (round(math.degrees(angle) * 1e7) for angle in local_to_geodetic(ORIGIN, 120.0, -80.0))
LAKE = 300.0


def sailing(mode: Mode = Mode.GUIDED, **options) -> tuple[LinkedVehicle, Station]:
    vehicle = LinkedVehicle(surface=LAKE, **options)
    vehicle.mode = mode
    vehicle.step()
    return vehicle, vehicle.stations[0]


def said(vehicle: LinkedVehicle) -> Setpoint:
    (order,) = [order for order in vehicle.orders if any(map(math.isfinite, order.setpoint))]
    return order.setpoint


def same(setpoint: Setpoint, *expected: float) -> bool:
    return setpoint == pytest.approx(expected, abs=0.02, nan_ok=True)


def send_int(station: Station, command: int, frame: int, *params: float) -> None:
    p1, p2, p3, p4, x, y, z = params
    station.send(mavlink.MAVLink_command_int_message(1, 1, frame, command, 0, 0, p1, p2, p3, p4, x, y, z))


@pytest.mark.parametrize(
    ("frame", "height", "depth"),
    [(AMSL, LAKE - 12.0, 12.0), (0, LAKE - 12.0, 12.0), (RELATIVE, -12.0, 12.0), (3, -12.0, 12.0), (AMSL, NAN, NAN)],
)
def test_reposition_sets_guided_and_goes_to_a_place_at_a_depth(frame: int, height: float, depth: float) -> None:
    vehicle, station = sailing(Mode.HOLD)
    send_int(station, REPOSITION, frame, 1.5, CHANGE_MODE, 0, NAN, LATITUDE, LONGITUDE, height)
    vehicle.step()
    assert station.acks() == [(REPOSITION, ACCEPTED)]
    assert vehicle.mode is Mode.GUIDED
    assert same(said(vehicle), depth, NAN, 1.5, 120.0, -80.0)


def test_a_place_in_the_local_frame_is_metres() -> None:
    vehicle, station = sailing()
    send_int(station, REPOSITION, LOCAL, -1, 0, 0, NAN, 1_200_000, -800_000, 4.0)
    vehicle.step()
    assert same(said(vehicle), 4.0, NAN, NAN, 120.0, -80.0)


def test_reposition_as_command_long_has_degrees_and_amsl() -> None:
    vehicle, station = sailing()
    station.command(REPOSITION, -1, 0, 0, NAN, 46.501, 6.601, LAKE - 7.0)
    vehicle.step()
    setpoint = said(vehicle)
    assert setpoint.z_d == pytest.approx(7.0, abs=1e-3)
    assert (setpoint.x, setpoint.y) == pytest.approx((111.2, 76.8), abs=0.5)


def test_reposition_without_leave_to_change_the_mode_is_refused_in_another() -> None:
    vehicle, station = sailing(Mode.HOLD)
    send_int(station, REPOSITION, RELATIVE, -1, 0, 0, NAN, LATITUDE, LONGITUDE, -5.0)
    vehicle.step()
    text = "".join(m.text for m in station.messages if m.get_type() == "STATUSTEXT")
    assert text == "DO_REPOSITION refused: ALT_HOLD takes no position; set GUIDED"
    assert station.acks() == [(REPOSITION, REJECTED)]
    assert vehicle.asked() == []


@pytest.mark.parametrize(
    ("frame", "params", "result"),
    [
        (RELATIVE, (-1, 1, 0, NAN, LATITUDE, LONGITUDE, 3.0), DENIED),  # in the air
        (AMSL, (-1, 1, 0, NAN, LATITUDE, LONGITUDE, LAKE + 1.0), DENIED),
        (AMSL, (-1, 1, 0, NAN, LATITUDE, LONGITUDE, -math.inf), DENIED),
        (AMSL, (-1, 1, 0, NAN, 910_000_000, LONGITUDE, LAKE - 1), DENIED),
        (AMSL, (-1, 1, 0, NAN, 0, 0, LAKE - 1), DENIED),  # thousands of km away
        (TERRAIN, (-1, 1, 0, NAN, LATITUDE, LONGITUDE, 3.0), NO_FRAME),
        (AMSL, (math.inf, 1, 0, NAN, LATITUDE, LONGITUDE, LAKE - 1), DENIED),
    ],
)
def test_what_is_no_place_or_no_depth_is_denied_and_orders_nothing(frame, params, result) -> None:
    vehicle, station = sailing(Mode.HOLD)
    send_int(station, REPOSITION, frame, *params)
    vehicle.step()
    assert "STATUSTEXT" in {m.get_type() for m in station.messages}
    assert station.acks() == [(REPOSITION, result)]
    assert vehicle.asked() == []


@pytest.mark.parametrize(
    ("command", "params", "expected"),
    [
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, (1, 1.25, -1), (NAN, NAN, 1.25)),
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, (0, 0.0, -1), (NAN, NAN, 0.0)),
        (mavlink.MAV_CMD_GUIDED_CHANGE_SPEED, (0, 1.5, 0), (NAN, NAN, 1.5)),
        (mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, (-8.0, 3), (8.0, NAN, NAN)),
        (mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, (LAKE - 8.0, 0), (8.0, NAN, NAN)),
        (mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, (8.0, 1), (8.0, NAN, NAN)),
        (mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE, (0, 0, 0, 0, 0, 0, LAKE - 3.0), (3.0, NAN, NAN)),
        (mavlink.MAV_CMD_CONDITION_YAW, (90, 0, 0, 0), (NAN, math.pi / 2, NAN)),
        (mavlink.MAV_CMD_CONDITION_YAW, (-90, 0, 0, 0), (NAN, 1.5 * math.pi, NAN)),
        (mavlink.MAV_CMD_CONDITION_YAW, (30, 0, -1, 1), (NAN, math.radians(330.0), NAN)),
        (mavlink.MAV_CMD_CONDITION_YAW, (30, 0, 1, 1), (NAN, math.radians(30.0), NAN)),
        (mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, (1, 180, 0), (NAN, math.pi, NAN)),
    ],
)
@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.GUIDED])
def test_depth_heading_and_speed_are_changed_by_command(mode, command, params, expected) -> None:
    vehicle, station = sailing(mode)
    station.command(command, *params)
    vehicle.step()
    assert station.acks() == [(command, ACCEPTED)]
    assert same(said(vehicle), *expected, NAN, NAN)
    assert vehicle.orders[-1].asker == Asker(0, 255, 190, command)


@pytest.mark.parametrize("mode", [Mode.DISARMED, Mode.MANUAL, Mode.MISSION, Mode.SURFACE])
def test_a_mode_that_takes_no_setpoint_says_so(mode: Mode) -> None:
    vehicle, station = sailing(mode)
    station.command(mavlink.MAV_CMD_CONDITION_YAW, 90)
    vehicle.step()
    text = "".join(m.text for m in station.messages if m.get_type() == "STATUSTEXT")
    shown = {Mode.DISARMED: "arm first", Mode.MISSION: "AUTO"}
    assert shown.get(mode, mode.name) in text
    assert station.acks() == [(mavlink.MAV_CMD_CONDITION_YAW, REJECTED)]


@pytest.mark.parametrize(
    ("command", "params", "result"),
    [
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, (1, -1.0), DENIED),
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, (1, NAN), DENIED),
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, (2, 1.0), UNSUPPORTED),  # climb
        (mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, (5.0, 3), DENIED),
        (mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, (NAN, 3), DENIED),
        (mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, (-5.0, NAN), NO_FRAME),
        (mavlink.MAV_CMD_CONDITION_YAW, (math.inf, 0, 0, 0), DENIED),
        (mavlink.MAV_CMD_CONDITION_YAW, (10, 0, 0, 0.5), DENIED),
    ],
)
def test_values_that_cannot_be_flown_are_denied(command, params, result) -> None:
    vehicle, station = sailing()
    station.command(command, *params)
    vehicle.step()
    assert station.acks() == [(command, result)]
    assert not any(math.isfinite(value) for order in vehicle.orders for value in order.setpoint)


def test_what_is_deeper_than_the_supervisor_lets_it_is_denied() -> None:
    vehicle, station = sailing(limits=FREE._replace(depth_max=30.0))
    for depth, result in ((40.0, DENIED), (20.0, ACCEPTED)):
        station.command(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, -depth, 3)
        vehicle.step()
        assert station.acks() == [(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, result)]


def test_a_command_sent_again_because_its_answer_was_lost_is_answered_again_and_not_done_again() -> None:
    vehicle, station = sailing()
    for again in range(4):
        station.command(REPOSITION, NAN, CHANGE_MODE, 0, NAN, 46.501, 6.601, LAKE - 7.0, again=again)
        vehicle.step()
    assert station.acks() == [(REPOSITION, ACCEPTED)] * 4
    assert sum(math.isfinite(order.setpoint.z_d) for order in vehicle.orders) == 1


def test_a_relative_heading_sent_again_turns_no_further() -> None:
    yaw, vehicle, station = mavlink.MAV_CMD_CONDITION_YAW, *sailing()
    vehicle.orders.clear()
    for again, psi in enumerate((0.0, 60.0)):
        vehicle.state["eta"] = STATE.eta._replace(psi=math.radians(psi))
        vehicle.step()
        station.command(yaw, 90.0, 0.0, 1.0, 1.0, again=again)
        vehicle.step(2)
    assert station.acks() == [(yaw, ACCEPTED)] * 2
    assert math.degrees(said(vehicle).psi_d) == pytest.approx(90.0)
    station.command(yaw, 90.0, 0.0, 1.0, 1.0)  # another one
    vehicle.step(2)
    assert math.degrees(vehicle.orders[-2].setpoint.psi_d) == pytest.approx(150.0)


def test_the_same_numbers_in_another_frame_are_another_command() -> None:
    vehicle, station = sailing()
    for frame in (RELATIVE, AMSL):
        send_int(station, REPOSITION, frame, NAN, CHANGE_MODE, 0, NAN, LATITUDE, LONGITUDE, -5.0)
    vehicle.step(3)
    depths = [order.setpoint.z_d for order in vehicle.orders if order.asker != NOBODY]
    assert depths == [pytest.approx(5.0), pytest.approx(LAKE + 5.0)]


def test_two_stations_are_obeyed_in_the_order_in_which_they_spoke_and_the_log_tells_who() -> None:
    vehicle, first = sailing(links=2)
    second = vehicle.stations[1]
    first.command(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, -5.0, 3)
    second.command(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, -9.0, 3)
    vehicle.step(3)
    said_by = [(order.setpoint.z_d, order.asker.link) for order in vehicle.orders if order.asker != NOBODY]
    assert said_by == [(5.0, 0), (9.0, 1)]
    assert first.acks() == second.acks() == [(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, ACCEPTED)]


def local_target(mask: int, x=0.0, y=0.0, z=0.0, vx=0.0, vy=0.0, yaw=0.0, frame=LOCAL):
    return mavlink.MAVLink_set_position_target_local_ned_message(
        0, 1, 1, frame, mask, x, y, z, vx, vy, 0.0, 0.0, 0.0, 0.0, yaw, 0.0
    )


REST = 64 | 128 | 256 | 2048
VELOCITY, YAW, PLACE, DEPTH = 8 | 16 | 32, 1024, 1 | 2, 4


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (local_target(REST | VELOCITY | YAW, 10.0, 20.0, 5.0), (5.0, NAN, NAN, 10.0, 20.0)),
        (local_target(REST | VELOCITY | YAW | PLACE, z=5.0), (5.0, NAN, NAN, NAN, NAN)),
        (local_target(REST | VELOCITY | PLACE | DEPTH, yaw=1.0), (NAN, 1.0, NAN, NAN, NAN)),
        (local_target(REST | YAW | PLACE | DEPTH, vx=0.0, vy=-1.5), (NAN, -math.pi / 2, 1.5, NAN, NAN)),
        (
            mavlink.MAVLink_set_position_target_global_int_message(
                0, 1, 1, RELATIVE, REST | VELOCITY | YAW, LATITUDE, LONGITUDE, -6.0, 0, 0, 0, 0, 0, 0, 0, 0
            ),
            (6.0, NAN, NAN, 120.0, -80.0),
        ),
    ],
)
def test_targets_are_followed_without_an_answer(message, expected) -> None:
    vehicle, station = sailing()
    station.send(message)
    vehicle.step(5)
    assert same(said(vehicle), *expected)
    assert {m.get_type() for m in station.messages} & {"COMMAND_ACK", "STATUSTEXT"} == set()


OFFSET = mavlink.MAV_FRAME_LOCAL_OFFSET_NED


def test_an_offset_counts_from_where_the_vehicle_is_and_none_leaves_the_place() -> None:
    """A station changes the depth with frame 7, mask 0xFFF8 and no way north or east."""
    vehicle, station = sailing()
    station.send(local_target(0xFFF8, 0.0, 0.0, 2.5, frame=OFFSET))
    vehicle.step(2)
    assert same(said(vehicle), STATE.eta.z + 2.5, NAN, NAN, NAN, NAN)
    vehicle.orders.clear()
    station.send(local_target(0xFFF8, 10.0, -20.0, 1.0, frame=OFFSET))
    vehicle.step(2)
    assert same(said(vehicle), STATE.eta.z + 1.0, NAN, NAN, STATE.eta.x + 10.0, STATE.eta.y - 20.0)
    station.send(local_target(0xFFF8, 0.0, 0.0, -STATE.eta.z - 1.0, frame=OFFSET))
    vehicle.step(2)
    assert "above the water" in "".join(m.text for m in station.messages if m.get_type() == "STATUSTEXT")


@pytest.mark.parametrize(
    "message",
    [
        local_target(REST | VELOCITY | YAW, math.inf, 0.0, 0.0),
        local_target(REST | VELOCITY | YAW, 1e30, 1e30, 0.0),
        local_target(REST | VELOCITY | YAW, 10.0, 0.0, -5.0),
        local_target(REST | VELOCITY | YAW, frame=8),
        local_target(0),
        local_target(REST | VELOCITY | YAW | PLACE | DEPTH),
        local_target(REST | YAW | PLACE | DEPTH, vx=NAN),
        mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 0, (1.0, 0.0, 0.0, 0.0), 0, 0, 0, 0.5),
    ],
)
def test_targets_that_cannot_be_followed_are_refused_in_words_now_and_then(message) -> None:
    vehicle, station = sailing()
    for _ in range(300):
        station.send(message)
        vehicle.step()
    texts = [m for m in station.messages if m.get_type() == "STATUSTEXT" and m.chunk_seq == 0]
    assert len(texts) == 1
    assert "refused" in texts[0].text
    assert all(order.asker == NOBODY for order in vehicle.orders)


def test_a_target_that_is_refused_for_another_reason_says_so_a_second_later() -> None:
    vehicle, station = sailing()
    for x, z in ((10.0, -5.0), (1e30, 5.0)):  # above the water, and beyond everything
        station.send(local_target(REST | VELOCITY | YAW, x, 0.0, z))
        vehicle.step(120)
    texts = [m.text for m in station.messages if m.get_type() == "STATUSTEXT" and m.chunk_seq == 0]
    assert len(texts) == 2
    assert texts[0] != texts[1]


def place(x: float):
    return local_target(REST | VELOCITY | YAW | DEPTH, x, 0.0)


def test_the_last_of_many_targets_in_a_tick_holds_and_disarming_goes_first() -> None:
    vehicle, station = sailing()
    for x in (1.0, 2.0, 3.0):
        station.send(place(x))
    vehicle.step(3)
    assert said(vehicle).x == 3.0
    vehicle.orders.clear()
    station.send(place(9.0))
    station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)
    vehicle.step(3)
    assert vehicle.orders[0].arming is Arming.DISARM
    assert all(math.isnan(order.setpoint.x) for order in vehicle.orders)
    texts = [m for m in station.messages if m.get_type() == "STATUSTEXT"]
    assert "SET_POSITION_TARGET_LOCAL_NED refused: disarmed; arm first" in put_together(texts)[-1]


@pytest.mark.parametrize("first", ["target", "command"])
def test_a_target_and_a_command_of_one_tick_are_both_done_in_the_order_in_which_they_came(first: str) -> None:
    vehicle, station = sailing()
    if first == "target":
        station.send(place(9.0))
    station.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1, 1.25, -1)
    if first == "command":
        station.send(place(9.0))
    vehicle.orders.clear()
    vehicle.step(3)
    done = [order for order in vehicle.orders if order.asker != NOBODY]
    target, command = done if first == "target" else reversed(done)
    assert same(target.setpoint, NAN, NAN, NAN, 9.0, 0.0)
    assert same(command.setpoint, NAN, NAN, 1.25, NAN, NAN)
    assert station.acks() == [(mavlink.MAV_CMD_DO_CHANGE_SPEED, ACCEPTED)]


def test_a_target_that_the_mode_set_before_it_does_not_take_is_refused_in_words() -> None:
    vehicle, station = sailing()
    station.command(mavlink.MAV_CMD_DO_SET_MODE, 1, 2)
    station.send(place(9.0))
    vehicle.step(3)
    assert vehicle.mode is Mode.HOLD
    assert all(math.isnan(order.setpoint.x) for order in vehicle.orders)
    texts = [m for m in station.messages if m.get_type() == "STATUSTEXT"]
    assert put_together(texts)[-1].startswith("SET_POSITION_TARGET_LOCAL_NED refused: ALT_HOLD takes no position")


def test_targets_in_every_tick_hold_up_no_command() -> None:
    vehicle, station = sailing()
    for x in range(8):
        station.send(place(float(x)))
        station.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1, 1.0 + x, -1)
        vehicle.step()
    vehicle.step(8)
    speeds = [order.setpoint.u_d for order in vehicle.orders if math.isfinite(order.setpoint.u_d)]
    assert speeds == [1.0 + x for x in range(8)]
    assert [order.setpoint.x for order in vehicle.orders if math.isfinite(order.setpoint.x)][-1] == 7.0


any_float = st.floats(width=32)


@settings(max_examples=150)
@given(
    st.sampled_from([REPOSITION, 178, 186, 115, 43000, 43001, 43002, 179, 241, 246, 300, 193, 2600]),
    st.integers(0, 255),
    st.tuples(*[any_float] * 4, st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1), any_float),
    st.booleans(),
)
def test_no_command_however_odd_raises_or_orders_what_is_not_finite(command, frame, params, as_int) -> None:
    vehicle, station = sailing()
    if as_int:
        send_int(station, command, frame, *params)
    else:
        station.command(command, *map(float, params))
    vehicle.step(2)
    assert [number for number, _ in station.acks()] == [command]
    assert not any(map(math.isinf, (value for order in vehicle.orders for value in order.setpoint)))
