"""Modes and messages that are asked for, data streams, upkeep, and the mission's course."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import all as mavlink

from firmware_py.marine import Eta, Nu
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.link import Link
from firmware_py.mavlink.plans.plan_builder import MISSION, plan_of_mission
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import Arming, Mode

from .station import LEARNED, ORIGIN, LinkedVehicle, cycle, node, parse

ACCEPTED, REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
REQUEST, START, PAUSE = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_MISSION_START, 193
FOUR = Mission(tuple(Waypoint(100.0 * i, 0.0, 5.0, 0.0) for i in range(4)))
REBOOT, CALIBRATE = mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, mavlink.MAV_CMD_PREFLIGHT_CALIBRATION


def heard(datagram: bytes) -> list:
    """What a station makes of it that knows every message of the standard."""
    return mavlink.MAVLink(None).parse_buffer(datagram) or []


def talk(vehicle: LinkedVehicle, number: int, *params: float, ticks: int = 3) -> list:
    """A command, and all messages of the next ticks."""
    vehicle.stations[0].command(number, *params)
    messages = []
    for _ in range(ticks):
        tick = cycle(vehicle.k).tick
        vehicle.node.receive(tick, vehicle.incoming)
        vehicle.incoming[0].clear()
        order = vehicle.node.order()
        vehicle.mode, events, *_ = vehicle.supervisor(vehicle.mode, order)
        vehicle.orders.append(order)
        messages += heard(vehicle.node.report(cycle(vehicle.k, vehicle.mode, order, events))[0])
        vehicle.k += 1
    return messages


def test_every_mode_is_listed_by_number_and_can_be_set_by_what_is_listed() -> None:
    for identity in Identity:
        vehicle = LinkedVehicle()
        vehicle.node = node(identities=(identity,))
        modes = [m for m in talk(vehicle, REQUEST, 435, 0, ticks=6) if m.get_type() == "AVAILABLE_MODES"]
        names = ["Manual", "Depth hold", "Position hold", "Guided", "Auto", "Surface"]
        names += ["Return"] if identity is Identity.GENERIC else []  # ArduSub has no number for it
        assert [m.mode_index for m in modes] == [*range(1, len(names) + 1)]
        assert {m.number_modes for m in modes} == {len(names)}
        assert [m.mode_name for m in modes] == names
        talk(vehicle, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        for m in modes[1:]:
            said = talk(vehicle, mavlink.MAV_CMD_DO_SET_MODE, 1, m.custom_mode)
            assert [a.result for a in said if a.get_type() == "COMMAND_ACK"] == [ACCEPTED]
            current = [c for c in talk(vehicle, REQUEST, 436) if c.get_type() == "CURRENT_MODE"]
            assert {(c.custom_mode, c.intended_custom_mode, c.standard_mode) for c in current} == {
                (m.custom_mode, m.custom_mode, m.standard_mode)
            }


def test_only_standard_modes_that_this_vehicle_can_fly_are_claimed_and_set() -> None:
    vehicle = LinkedVehicle()
    claimed = {m.standard_mode for m in talk(vehicle, REQUEST, 435, 0, ticks=6) if m.get_type() == "AVAILABLE_MODES"}
    assert claimed <= {0, mavlink.MAV_STANDARD_MODE_MISSION, mavlink.MAV_STANDARD_MODE_LAND}
    vehicle.mode = Mode.MANUAL
    for number, mode in ((6, Mode.MISSION), (7, Mode.SURFACE), (5, Mode.RETURN)):
        talk(vehicle, mavlink.MAV_CMD_DO_SET_STANDARD_MODE, number)
        assert vehicle.mode is mode
    for number in (0, 1, 3, 4, 9, math.nan):
        said = talk(vehicle, mavlink.MAV_CMD_DO_SET_STANDARD_MODE, number, ticks=2)
        assert [a.result for a in said if a.get_type() == "COMMAND_ACK"] == [DENIED]


def test_one_mode_can_be_asked_for_and_one_that_is_not_there_is_denied() -> None:
    said = talk(LinkedVehicle(), REQUEST, 435, 4)
    assert [m.mode_name for m in said if m.get_type() == "AVAILABLE_MODES"] == ["Guided"]
    said = talk(LinkedVehicle(), REQUEST, 435, 7)
    assert [m.get_type() for m in said if m.get_type() in ("AVAILABLE_MODES", "COMMAND_ACK")] == ["COMMAND_ACK"]


@pytest.mark.parametrize(
    ("number", "params", "mode"),
    [
        (START, (0, 0), Mode.MISSION),
        (PAUSE, (0,), Mode.LOITER),
        (PAUSE, (1,), Mode.MISSION),
        (mavlink.MAV_CMD_NAV_LOITER_UNLIM, (), Mode.LOITER),
        (mavlink.MAV_CMD_NAV_LAND, (), Mode.SURFACE),
        (mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, (), Mode.RETURN),
    ],
)
def test_the_missions_course_is_set_by_command(number: int, params: tuple, mode: Mode) -> None:
    vehicle = LinkedVehicle()
    vehicle.mode = Mode.MANUAL
    vehicle.stations[0].command(number, *params)
    vehicle.step()
    assert vehicle.mode is mode
    assert vehicle.stations[0].acks() == [(number, ACCEPTED)]
    disarmed = LinkedVehicle()
    disarmed.stations[0].command(number, *params)
    disarmed.step()
    assert disarmed.stations[0].acks() == [(number, REJECTED)]


@pytest.mark.parametrize(("identity", "jump"), [(Identity.ARDUSUB, 2), (Identity.GENERIC, 3)])
def test_a_mission_starts_at_an_item_as_the_link_counts_them(identity: Identity, jump: int) -> None:
    vehicle = LinkedVehicle()
    vehicle.node = node(identities=(identity,), plans={MISSION: plan_of_mission(FOUR, WaterFrame(ORIGIN, 0.0))})
    vehicle.mode = Mode.MANUAL
    vehicle.stations[0].command(START, 3, 0)
    vehicle.step()
    assert (vehicle.orders[-1].mode, vehicle.orders[-1].jump) == (Mode.MISSION, jump)


@pytest.mark.parametrize(("number", "param"), [(START, -1), (START, math.nan), (PAUSE, 2), (PAUSE, math.nan)])
def test_a_course_that_makes_no_sense_is_denied(number: int, param: float) -> None:
    vehicle = LinkedVehicle()
    vehicle.mode = Mode.MANUAL
    vehicle.stations[0].command(number, param)
    vehicle.step()
    assert vehicle.stations[0].acks() == [(number, DENIED)]


def test_the_checks_before_arming_are_run_on_request_and_only_while_disarmed() -> None:
    def supervisor(mode: Mode, order) -> tuple[Mode, tuple[Event, ...]]:
        passed = Event(EventKind.ARMING_CHECK_PASSED, Severity.INFO)
        return mode, (passed,) if order.arming is Arming.CHECK and mode is Mode.DISARMED else ()

    vehicle = LinkedVehicle(supervisor=supervisor)
    (station,) = vehicle.stations
    armed = "RUN_PREARM_CHECKS refused: the vehicle is armed: there is nothing to check"
    for mode, result, text, severity in (
        (Mode.DISARMED, ACCEPTED, "ready to be armed", mavlink.MAV_SEVERITY_INFO),
        (Mode.MANUAL, REJECTED, armed, mavlink.MAV_SEVERITY_WARNING),
    ):
        vehicle.mode = mode
        station.command(mavlink.MAV_CMD_RUN_PREARM_CHECKS)
        vehicle.step()
        said = [m for m in station.messages if m.get_type() == "STATUSTEXT"]
        assert "".join(m.text for m in said) == text
        assert {m.severity for m in said} == {severity}
        assert station.acks() == [(mavlink.MAV_CMD_RUN_PREARM_CHECKS, result)]


def test_intervals_are_told_as_they_are() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    for name, interval in ((mavlink.MAVLINK_MSG_ID_ATTITUDE, 100_000), (mavlink.MAVLINK_MSG_ID_HIGH_LATENCY2, -1)):
        station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, name)
        vehicle.step()
        (told,) = [m for m in station.messages if m.get_type() == "MESSAGE_INTERVAL"]
        assert (told.message_id, told.interval_us) == (name, interval)
        assert station.acks() == [(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, ACCEPTED)]
    station.command(REQUEST, mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL, 27)
    vehicle.step()
    (told,) = station.heard("MESSAGE_INTERVAL")
    assert (told.message_id, told.interval_us) == (27, 0)


def test_data_streams_set_the_rates_of_their_messages_and_end_them() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations

    def in_a_second(stream: int, rate: int, on: int = 1) -> dict[str, int]:
        station.send(mavlink.MAVLink_request_data_stream_message(1, 1, stream, rate, on))
        vehicle.step(2)
        station.messages.clear()
        vehicle.step(100)
        names = [m.get_type() for m in station.messages]
        station.messages.clear()
        return {name: names.count(name) for name in ("ATTITUDE", "GLOBAL_POSITION_INT", "SYS_STATUS", "HEARTBEAT")}

    assert in_a_second(mavlink.MAV_DATA_STREAM_EXTRA1, 25) == dict(
        zip(("ATTITUDE", "GLOBAL_POSITION_INT", "SYS_STATUS", "HEARTBEAT"), (25, 5, 1, 1), strict=True)
    )
    assert set(in_a_second(mavlink.MAV_DATA_STREAM_ALL, 4).values()) == {4, 1}
    silent = in_a_second(mavlink.MAV_DATA_STREAM_ALL, 4, on=0)
    assert silent == {"ATTITUDE": 0, "GLOBAL_POSITION_INT": 0, "SYS_STATUS": 0, "HEARTBEAT": 1}
    assert in_a_second(200, 4)["HEARTBEAT"] == 1


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.SURFACE, Mode.LOITER, Mode.GUIDED])
@pytest.mark.parametrize(("number", "params"), [(REBOOT, (1,)), (REBOOT, (2, 0, 0, 0, 0, 20190226)), (CALIBRATE, (1,))])
def test_no_armed_vehicle_is_restarted_or_calibrated_by_force_neither(mode: Mode, number: int, params: tuple) -> None:
    vehicle = LinkedVehicle()
    vehicle.mode = mode
    vehicle.step()
    vehicle.stations[0].messages.clear()
    vehicle.stations[0].command(number, *params)
    vehicle.step(2)
    assert "armed" in "".join(m.text for m in vehicle.stations[0].messages if m.get_type() == "STATUSTEXT")
    assert vehicle.stations[0].acks() == [(number, REJECTED)]
    assert vehicle.node.end_request == ""


@pytest.mark.parametrize(("param", "ending", "result"), [(1, "reboot", 0), (2, "shutdown", 0), (3, "", 2), (0, "", 0)])
def test_a_disarmed_vehicle_is_restarted(param: int, ending: str, result: int) -> None:
    vehicle = LinkedVehicle()
    vehicle.node.allow_end()
    vehicle.stations[0].command(REBOOT, param)
    vehicle.step()
    assert vehicle.stations[0].acks() == [(REBOOT, result)]
    assert (vehicle.node.end_request, vehicle.node.end_requester) == (ending, "255/190" if ending else "")


def test_a_simulation_is_not_ended_from_afar() -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].command(REBOOT, 1)
    vehicle.step(2)
    assert vehicle.stations[0].acks() == [(REBOOT, DENIED)]
    assert vehicle.node.end_request == ""


LATITUDE, LONGITUDE, LAKE_MM = 465_000_000, 66_000_000, 300_000


@pytest.mark.parametrize(
    ("message", "agreed"),
    [
        (mavlink.MAVLink_set_gps_global_origin_message(1, LATITUDE, LONGITUDE, LAKE_MM), True),
        (mavlink.MAVLink_set_gps_global_origin_message(1, LATITUDE + 1000, LONGITUDE, LAKE_MM), False),
        (mavlink.MAVLink_set_gps_global_origin_message(1, LATITUDE, LONGITUDE, 0), False),
        (
            mavlink.MAVLink_set_home_position_message(1, LATITUDE, LONGITUDE, 0, 0, 0, 0, (1, 0, 0, 0), 0, 0, 0),
            False,
        ),
    ],
)
def test_an_origin_that_is_said_again_and_again_is_answered_with_the_one_that_holds(message, agreed: bool) -> None:
    vehicle = LinkedVehicle(surface=300.0)
    (station,) = vehicle.stations
    for _ in range(3):
        station.send(message)
        vehicle.step(4)
        said = {m.get_type(): m for m in station.messages}
        station.messages.clear()
        place = said.get("GPS_GLOBAL_ORIGIN") or said["HOME_POSITION"]
        assert (place.latitude, place.longitude, place.altitude) == (LATITUDE, LONGITUDE, LAKE_MM)
        assert ("STATUSTEXT" in said) != agreed


def test_a_home_that_disagrees_is_denied() -> None:
    vehicle = LinkedVehicle(surface=300.0)
    (station,) = vehicle.stations
    number = mavlink.MAV_CMD_DO_SET_HOME
    for params, result in (
        ((1, 0, 0, 0, 0, 0, 0), DENIED),
        ((0, 0, 0, 0, 46.5, 6.6, 300.0), ACCEPTED),
        ((0, 0, 0, 0, 46.5, 6.6, 0.0), DENIED),
        ((0, 0, 0, 0, math.nan, 6.6, 0.0), DENIED),
    ):
        station.command(number, *params)
        vehicle.step(3)
        assert station.acks() == [(number, result)]


def acoustic() -> LinkedVehicle:
    return LinkedVehicle(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])


def test_a_link_of_high_latency_says_one_message_in_five_seconds_and_answers() -> None:
    vehicle = acoustic()
    (station,) = vehicle.stations
    vehicle.step(2000)
    assert [m.get_type() for m in station.messages] == ["HIGH_LATENCY2"] * 4
    station.messages.clear()
    station.command(REQUEST, mavlink.MAVLINK_MSG_ID_ATTITUDE)
    vehicle.step(20)
    assert [m.get_type() for m in station.messages if m.get_type() != "HIGH_LATENCY2"] == ["COMMAND_ACK", "ATTITUDE"]


def test_of_events_only_critical_ones_go_over_a_link_of_high_latency() -> None:
    link: Link = acoustic().node.links[0]
    link.send_events(
        (
            Event(EventKind.MODE_CHANGED, Severity.CRITICAL, Mode.MISSION, Mode.SURFACE, Cause.LEAK),
            Event(EventKind.WAYPOINT_PASSED, Severity.INFO, numbers=(1.0, 3.0)),
        )
    )
    messages = [m for k in range(5) for m in parse(link.report(cycle(k)))]
    (text,) = [m.text for m in messages if m.get_type() == "STATUSTEXT"]
    assert text.endswith("water in the hull")


def test_high_latency_can_be_begun_and_ended_on_any_link() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    number = mavlink.MAV_CMD_CONTROL_HIGH_LATENCY
    for on, count in ((1, 2), (0, 0)):
        station.command(number, on)
        vehicle.step()
        assert station.acks() == [(number, ACCEPTED)]
        vehicle.step(1000)
        assert len(station.heard("HIGH_LATENCY2")) == count


def test_high_latency_says_what_matters() -> None:
    vehicle = node(surface=300.0, configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
    eta = Eta(0.0, 0.0, 12.34, 0.0, 0.0, math.radians(-90.0))
    (m,) = parse(vehicle.report(cycle(0, Mode.LOITER, eta=eta, learned=LEARNED, depth_ok=False))[0])
    assert (m.latitude, m.longitude) == (LATITUDE, LONGITUDE)
    assert m.altitude == 288
    assert (m.custom1 + 127 * m.custom2) / 10 == 12.3
    assert m.heading * 2 == 270
    assert m.custom_mode == 16
    assert m.custom0 & 128 == 128  # armed, as ArduPilot says it
    assert m.battery == 80
    assert m.failure_flags & mavlink.HL_FAILURE_FLAG_ABSOLUTE_PRESSURE
    assert m.windspeed / 5 == pytest.approx(0.28, abs=0.1)
    assert m.wind_heading * 2 == pytest.approx(math.degrees(math.atan2(-0.25, 0.125)) % 360.0, abs=2.0)


@given(st.tuples(*[st.floats()] * 6), st.tuples(*[st.floats()] * 6), st.floats())
def test_no_state_however_broken_makes_it_unsayable(eta, nu, std) -> None:
    vehicle = node(configurations=[LinkConfiguration(identity, high_latency=True) for identity in Identity])
    for datagram in vehicle.report(cycle(0, eta=Eta(*eta), nu=Nu(*nu), position_std=std)):
        assert [m.get_type() for m in parse(datagram)] == ["HIGH_LATENCY2"]
    assert not any(link.codec.not_encodable for link in vehicle.links)


class Talker:
    """A service that always has a word to say."""

    def __init__(self, name: str) -> None:
        self.name = name

    def message_handlers(self) -> dict:
        return {}

    def due(self, tick) -> list:
        return [mavlink.MAVLink_statustext_message(6, self.name.encode())]


def test_services_say_what_they_have_in_turn_beside_the_streams() -> None:
    vehicle = LinkedVehicle()
    for name in "abcdef":
        vehicle.node.links[0].add_service(Talker(name))
    vehicle.step(60)
    said = [m for m in vehicle.stations[0].messages if m.get_type() == "STATUSTEXT"]
    counts = [sum(m.text == name for m in said) for name in "abcdef"]
    assert sum(counts) >= 3 * 60
    assert max(counts) - min(counts) <= 1
    assert "ATTITUDE" in {m.get_type() for m in vehicle.stations[0].messages}
