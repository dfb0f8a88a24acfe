"""Commands: what they order, and that each gets one answer that tells what became of it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py import __version__
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.commands.queue import MAX_WAITING
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.order import Arming, Mode, Order
from firmware_py.tick import Tick
from tests.unit.firmware_py.mavlink.station import DT_NS, LinkedVehicle, Station, cycle, node, parse

ARM, SET_MODE = mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_CMD_DO_SET_MODE
TERMINATE, GRIPPER = mavlink.MAV_CMD_DO_FLIGHTTERMINATION, mavlink.MAV_CMD_DO_GRIPPER
REQUEST, INTERVAL = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
ACCEPTED, REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
CUSTOM = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
SURFACE = 9
OURS = {
    *(ARM, SET_MODE, REQUEST, INTERVAL, mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, mavlink.MAV_CMD_RUN_PREARM_CHECKS),
    *(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, mavlink.MAV_CMD_CONTROL_HIGH_LATENCY),
    mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION,
    *(mavlink.MAV_CMD_DO_SET_STANDARD_MODE, mavlink.MAV_CMD_MISSION_START, mavlink.MAV_CMD_DO_PAUSE_CONTINUE),
    *(mavlink.MAV_CMD_NAV_LOITER_UNLIM, mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH),
    *(mavlink.MAV_CMD_DO_REPOSITION, mavlink.MAV_CMD_DO_CHANGE_SPEED, mavlink.MAV_CMD_DO_CHANGE_ALTITUDE),
    *(mavlink.MAV_CMD_GUIDED_CHANGE_SPEED, mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE),
    *(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, mavlink.MAV_CMD_CONDITION_YAW, mavlink.MAV_CMD_DO_SET_HOME),
    *(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, mavlink.MAV_CMD_DO_FENCE_ENABLE, TERMINATE, GRIPPER),
    *(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, mavlink.MAV_CMD_PREFLIGHT_CALIBRATION),
}
COMMANDS = sorted(
    {value for name, value in vars(mavlink).items() if name.startswith("MAV_CMD_") and not name.endswith("_END")}
)


def stubborn(mode: Mode, order: Order) -> tuple[Mode, tuple[Event, ...]]:
    asked = order.arming is Arming.ARM
    refusals = (
        Event(EventKind.ARMING_REFUSED, Severity.WARNING, cause=Cause.FINS_NOT_HEARD, numbers=(1.0,)),
        Event(EventKind.ARMING_REFUSED, Severity.WARNING, cause=Cause.CHARGE_NEEDED, numbers=(0.05, 0.2)),
    )
    return mode, refusals if asked else ()


def armed(**options) -> tuple[LinkedVehicle, Station]:
    vehicle = LinkedVehicle(**options)
    vehicle.stations[0].command(ARM, 1)
    vehicle.step()
    assert vehicle.stations[0].acks() == [(ARM, ACCEPTED)]
    return vehicle, vehicle.stations[0]


def test_arming_and_disarming_are_answered_by_the_cycle_that_obeys() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    for param, mode in ((1, Mode.MANUAL), (0, Mode.DISARMED)):
        station.command(ARM, param)
        vehicle.step()
        assert vehicle.mode is mode
        (ack,) = station.heard("COMMAND_ACK")
        assert (ack.command, ack.result) == (ARM, ACCEPTED)
        assert (ack.target_system, ack.target_component) == (255, 190)
    vehicle.step(300)
    assert station.acks() == []
    assert vehicle.asked() == [(Arming.ARM, None), (Arming.DISARM, None)]


def test_a_refusal_is_told_with_its_reasons_before_the_answer() -> None:
    vehicle = LinkedVehicle(supervisor=stubborn)
    (station,) = vehicle.stations
    station.command(ARM, 1)
    vehicle.step()
    said = [m for m in station.messages if m.get_type() in ("STATUSTEXT", "COMMAND_ACK")]
    assert [m.get_type() for m in said] == ["STATUSTEXT", "STATUSTEXT", "COMMAND_ACK"]
    text = said[0].text + said[1].text
    assert text == "arming refused: not every fin heard within 1 s (fin_needed); battery at 5%, needs 20%"
    assert said[0].severity == mavlink.MAV_SEVERITY_WARNING
    assert said[2].result == REJECTED


def set_mode(identity: Identity, *params: float) -> tuple[list[Mode | None], list[tuple[int, int]]]:
    """The modes ordered, and the answers, where a vehicle that holds is sent DO_SET_MODE."""
    vehicle = LinkedVehicle()
    vehicle.node, vehicle.mode = node(identities=(identity,)), Mode.HOLD
    vehicle.stations[0].command(SET_MODE, *params)
    vehicle.step(2)
    return [order.mode for order in vehicle.orders if order.mode is not None], vehicle.stations[0].acks()


@pytest.mark.parametrize("identity", Identity)
@pytest.mark.parametrize(
    ("params", "mode"),
    [
        ((CUSTOM, 4, 4), Mode.MISSION),  # PX4's main and sub mode, as MAVSDK sends them
        ((CUSTOM, 4, 3), Mode.LOITER),
        ((CUSTOM, 4, 5), Mode.RETURN),
        ((CUSTOM, 6, 0), Mode.GUIDED),
        ((CUSTOM | 128, 4, 6), Mode.SURFACE),
        ((CUSTOM, 4 << 24 | 4 << 16, 0), Mode.MISSION),  # both in one number, as PX4's heartbeats have it
        ((CUSTOM, 2 << 16, 0), Mode.HOLD),
        ((CUSTOM, 3 << 16, 0), Mode.LOITER),
    ],
)
def test_px4s_modes_are_understood_by_every_identity(identity, params, mode) -> None:
    assert set_mode(identity, *params) == ([mode], [(SET_MODE, ACCEPTED)])


@pytest.mark.parametrize(
    ("number", "ardusub", "generic"),
    [
        (1, None, Mode.MANUAL),
        (2, Mode.HOLD, Mode.HOLD),  # ALT_HOLD, and ALTCTL
        (3, Mode.MISSION, Mode.LOITER),  # AUTO, and POSCTL: MAVSDK's position control starts no mission
        (4, Mode.GUIDED, None),
        (7, None, None),
        (9, Mode.SURFACE, None),
        (16, Mode.LOITER, None),
        (19, Mode.MANUAL, None),
    ],
)
@pytest.mark.parametrize("sub", [0.0, math.nan])
def test_a_small_number_is_ardusubs_on_its_links_and_px4s_main_mode_on_generic_ones(
    number, ardusub, generic, sub
) -> None:
    for identity, mode in ((Identity.ARDUSUB, ardusub), (Identity.GENERIC, generic)):
        expected = ([], [(SET_MODE, DENIED)]) if mode is None else ([mode], [(SET_MODE, ACCEPTED)])
        assert set_mode(identity, CUSTOM, number, sub) == expected


@pytest.mark.parametrize(
    "params",
    [
        (CUSTOM, 7, 0),
        (CUSTOM, 2.5, 0),
        (CUSTOM, 4, 9),
        (CUSTOM, math.nan, 0),
        (CUSTOM, math.inf, 0),
        (0, 2, 0),
        (math.nan, 2, 0),
        (math.inf, 2, 0),
    ],
)
def test_a_mode_that_does_not_exist_is_denied_and_named(params) -> None:
    vehicle, station = armed()
    station.command(SET_MODE, *params)
    vehicle.step()
    vehicle.step()
    texts = [m for m in station.messages if m.get_type() == "STATUSTEXT"]
    assert {m.severity for m in texts} == {mavlink.MAV_SEVERITY_WARNING}
    assert "mode" in "".join(m.text for m in texts)
    assert station.acks() == [(SET_MODE, DENIED)]
    assert vehicle.mode is Mode.MANUAL


def test_the_old_set_mode_works_and_is_answered_under_its_own_id() -> None:
    vehicle, station = armed()
    station.send(mavlink.MAVLink_set_mode_message(1, CUSTOM, 2))
    vehicle.step()
    assert vehicle.mode is Mode.HOLD
    assert station.acks() == [(mavlink.MAVLINK_MSG_ID_SET_MODE, ACCEPTED)]


def test_a_mode_of_a_disarmed_vehicle_is_granted_if_the_supervisor_took_it() -> None:
    vehicle = LinkedVehicle(supervisor=stubborn)
    (station,) = vehicle.stations
    station.command(SET_MODE, CUSTOM, 19)
    vehicle.step()
    assert station.acks() == [(SET_MODE, ACCEPTED)]  # it is in force already
    station.command(SET_MODE, CUSTOM, 2)
    vehicle.step()
    assert station.acks() == [(SET_MODE, REJECTED)]
    assert vehicle.asked() == [(Arming.KEEP, Mode.MANUAL), (Arming.KEEP, Mode.HOLD)]


def test_a_stations_start_of_a_mission_is_guided_then_arming_then_the_start() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    station.command(SET_MODE, CUSTOM, 4)
    station.command(ARM, 1)
    station.command(mavlink.MAV_CMD_MISSION_START)
    vehicle.step(5)
    assert station.acks() == [(SET_MODE, ACCEPTED), (ARM, ACCEPTED), (mavlink.MAV_CMD_MISSION_START, ACCEPTED)]
    assert vehicle.mode is Mode.MISSION


def test_disarming_by_force_is_another_order() -> None:
    vehicle, station = armed()
    station.command(ARM, 0, 21196)
    vehicle.step()
    assert vehicle.asked()[1:] == [(Arming.FORCE_DISARM, None)]
    assert station.acks() == [(ARM, ACCEPTED)]


def test_the_end_of_the_flight_is_one_order_and_takes_one() -> None:
    vehicle, station = armed()
    for param in (0, -1, 0.5, math.nan):
        station.command(TERMINATE, param)
        vehicle.step(2)
        assert station.acks() == [(TERMINATE, DENIED)]
    station.command(TERMINATE, 1)
    vehicle.step(2)
    assert station.acks() == [(TERMINATE, ACCEPTED)]
    assert vehicle.mode is Mode.SURFACE
    assert [order.terminate for order in vehicle.orders].count(True) == 1


def test_the_last_heartbeat_of_a_station_is_in_every_order() -> None:
    vehicle = LinkedVehicle(links=2)
    vehicle.step(10)
    assert vehicle.orders[-1].t_station == -math.inf
    beat = (mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE)
    vehicle.stations[0].send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_SUBMARINE, *beat, 3))
    vehicle.step()
    assert vehicle.orders[-1].t_station == -math.inf  # another vehicle watches nobody
    vehicle.stations[1].send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, *beat, 3))
    vehicle.step(20)
    assert {order.t_station for order in vehicle.orders[-20:]} == {Tick(11, DT_NS).t}
    vehicle.stations[0].command(ARM, 1)
    vehicle.step()
    assert (vehicle.orders[-1].arming, vehicle.orders[-1].t_station) == (Arming.ARM, Tick(11, DT_NS).t)


@pytest.mark.parametrize("param", [2, -1, 0.5, math.nan, math.inf])
def test_arming_takes_one_or_zero(param: float) -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].command(ARM, param)
    vehicle.step()
    assert vehicle.stations[0].acks() == [(ARM, DENIED)]
    assert vehicle.asked() == []


def test_nobody_arms_by_force() -> None:
    vehicle = LinkedVehicle(supervisor=stubborn)
    vehicle.stations[0].command(ARM, 1, 21196)
    vehicle.step()
    assert vehicle.stations[0].acks() == [(ARM, REJECTED)]


@pytest.mark.parametrize("as_int", [False, True])
def test_every_other_command_is_answered_once_as_unsupported(as_int: bool) -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    for command in COMMANDS:
        if command in OURS:
            continue
        if as_int:
            station.send(mavlink.MAVLink_command_int_message(1, 1, 0, command, 0, 0, 1, 1, 1, 1, 1, 1, 1))
        else:
            station.command(command, 1, 1, 1, 1, 1, 1, 1)
        vehicle.step()
        assert station.acks() == [(command, UNSUPPORTED)]
    assert vehicle.asked() == []


def test_command_int_arms_as_command_long_does() -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].send(mavlink.MAVLink_command_int_message(1, 1, 0, ARM, 0, 0, 1, 0, 0, 0, 0, 0, 0))
    vehicle.step()
    assert vehicle.mode is Mode.MANUAL
    assert vehicle.stations[0].acks() == [(ARM, ACCEPTED)]


@pytest.mark.parametrize(("system", "component", "ours"), [(1, 1, True), (1, 0, True), (0, 0, True), (0, 1, True)])
def test_a_broadcast_reaches_us(system: int, component: int, ours: bool) -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].command(ARM, 1, system=system, component=component)
    vehicle.step()
    assert vehicle.stations[0].acks() == [(ARM, ACCEPTED)]


@pytest.mark.parametrize(("system", "component"), [(2, 1), (2, 0), (1, 2), (0, 100), (255, 190)])
def test_what_is_meant_for_others_is_neither_done_nor_answered(system: int, component: int) -> None:
    vehicle = LinkedVehicle()
    vehicle.stations[0].command(ARM, 1, system=system, component=component)
    vehicle.stations[0].command(REQUEST, 148, system=system, component=component)
    vehicle.step(50)
    assert vehicle.asked() == []
    assert vehicle.stations[0].acks() == []


def test_our_own_words_come_back_unheard() -> None:
    vehicle = LinkedVehicle()
    echo = Station(vehicle, system=1)
    echo.mav.srcComponent = 1
    echo.command(ARM, 1)
    vehicle.step()
    assert vehicle.asked() == []


def test_a_fleet_tells_its_vehicles_apart() -> None:
    vehicle = LinkedVehicle(system=7)
    vehicle.stations[0].command(ARM, 1, system=1)
    vehicle.stations[0].command(ARM, 1, system=7)
    vehicle.step()
    (ack,) = vehicle.stations[0].heard("COMMAND_ACK")
    assert ack.get_srcSystem() == 7


def test_a_command_repeated_while_it_waits_is_one_command() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    for again in range(4):
        station.command(ARM, 1, again=again)
    vehicle.step(10)
    assert station.acks() == [(ARM, ACCEPTED)]
    assert vehicle.asked() == [(Arming.ARM, None)]


def test_a_command_whose_answer_was_lost_is_answered_again_and_not_done_again() -> None:
    vehicle, station = armed()
    vehicle.mode = Mode.DISARMED  # it came up, and disarmed itself
    station.command(ARM, 1, again=1)
    vehicle.step()
    assert station.acks() == [(ARM, ACCEPTED)]
    assert vehicle.mode is Mode.DISARMED
    station.command(ARM, 1)  # this one is meant anew
    vehicle.step()
    assert vehicle.mode is Mode.MANUAL


def test_disarming_is_done_however_often_it_was_answered() -> None:
    vehicle, station = armed()
    for again in (0, 1):
        vehicle.mode = Mode.MANUAL
        station.command(ARM, 0, again=again)
        vehicle.step()
        assert station.acks() == [(ARM, ACCEPTED)]
        assert vehicle.mode is Mode.DISARMED


def test_a_repetition_of_what_was_undone_since_is_meant_anew() -> None:
    vehicle, station = armed()
    station.command(ARM, 0)
    vehicle.step()
    station.command(ARM, 1, again=1)  # its first transmission was lost
    vehicle.step()
    assert vehicle.mode is Mode.MANUAL
    assert station.acks() == [(ARM, ACCEPTED)] * 2


def test_a_repetition_much_later_is_meant_anew() -> None:
    vehicle, station = armed()
    vehicle.mode = Mode.DISARMED
    vehicle.step(1001)
    station.command(ARM, 1, again=1)
    vehicle.step()
    assert vehicle.mode is Mode.MANUAL


def test_wishes_are_obeyed_one_a_tick_in_their_order() -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    station.command(ARM, 1)
    station.command(SET_MODE, CUSTOM, 2)
    station.command(SET_MODE, CUSTOM, 3)
    vehicle.step(3)
    assert [(o.arming, o.mode) for o in vehicle.orders] == [
        (Arming.ARM, None),
        (Arming.KEEP, Mode.HOLD),
        (Arming.KEEP, Mode.MISSION),
    ]
    assert station.acks() == [(ARM, ACCEPTED), (SET_MODE, ACCEPTED), (SET_MODE, ACCEPTED)]


def test_disarming_goes_first_whoever_asks_and_ends_what_waited() -> None:
    vehicle, station = armed(links=2)
    station.command(SET_MODE, CUSTOM, 2)
    station.command(SET_MODE, CUSTOM, 3)
    station.command(ARM, 1)
    vehicle.stations[1].command(ARM, 0)
    vehicle.step(20)
    assert vehicle.asked()[1:] == [(Arming.DISARM, None)]
    assert vehicle.mode is Mode.DISARMED
    assert sorted(station.acks()) == [(SET_MODE, REJECTED), (SET_MODE, REJECTED), (ARM, REJECTED)]
    assert vehicle.stations[1].acks() == [(ARM, ACCEPTED)]


def test_two_who_disarm_at_once_are_both_answered_with_yes() -> None:
    vehicle, _ = armed(links=2)
    for each in vehicle.stations:
        each.command(ARM, 0)
    vehicle.step(5)
    assert [each.acks() for each in vehicle.stations] == [[(ARM, ACCEPTED)]] * 2


def test_more_wishes_than_may_wait_are_refused_at_once_but_not_disarming() -> None:
    vehicle, station = armed()
    for number in range(MAX_WAITING + 2):
        Station(vehicle, system=10 + number).command(SET_MODE, CUSTOM, 2)
    station.command(ARM, 0)
    vehicle.step(20)
    results = [result for _, result in station.acks()]
    assert len(results) == MAX_WAITING + 3
    assert results.count(ACCEPTED) == 1
    assert vehicle.mode is Mode.DISARMED


def test_each_link_hears_its_own_answers_and_everyone_the_events() -> None:
    vehicle = LinkedVehicle(links=2, supervisor=stubborn)
    vehicle.stations[1].command(ARM, 1)
    vehicle.step()
    texts = [[m.text for m in each.messages if m.get_type() == "STATUSTEXT"] for each in vehicle.stations]
    assert texts[0] == texts[1] != []
    assert [each.acks() for each in vehicle.stations] == [[], [(ARM, REJECTED)]]


@pytest.mark.parametrize("name", ["ATTITUDE", "HEARTBEAT", "AUTOPILOT_VERSION", "HOME_POSITION", "GPS_GLOBAL_ORIGIN"])
def test_a_message_that_is_asked_for_comes_once_after_the_answer(name: str) -> None:
    vehicle = LinkedVehicle(surface=300.0)
    (station,) = vehicle.stations
    vehicle.step(49)
    station.messages.clear()
    station.command(REQUEST, getattr(mavlink, f"MAVLINK_MSG_ID_{name}"))
    vehicle.step()
    assert [m.get_type() for m in station.messages] == ["COMMAND_ACK", name]
    assert station.messages[0].result == ACCEPTED
    if name in ("HOME_POSITION", "GPS_GLOBAL_ORIGIN"):
        place = station.messages[1]
        assert (place.latitude, place.longitude, place.altitude) == (465_000_000, 66_000_000, 300_000)


@pytest.mark.parametrize("name", [11_000_000, 27, -1, math.nan, math.inf])
def test_a_message_that_we_do_not_have_is_unsupported(name: float) -> None:
    vehicle = LinkedVehicle()
    for command in (REQUEST, INTERVAL):
        vehicle.stations[0].command(command, name, 100_000)
        vehicle.step()
        assert vehicle.stations[0].acks() == [(command, UNSUPPORTED)]


@pytest.mark.parametrize(
    ("identity", "encoding"),
    [
        (Identity.ARDUSUB, mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST),
        (Identity.GENERIC, mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE),
    ],
)
def test_capabilities_claim_what_there_is_and_one_encoding(identity: Identity, encoding: int) -> None:
    vehicle = LinkedVehicle()
    vehicle.node = node(identities=(identity,))
    vehicle.stations[0].command(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1)
    vehicle.step()
    (version,) = vehicle.stations[0].heard("AUTOPILOT_VERSION")
    numbers = [version.flight_sw_version >> shift & 0xFF for shift in (24, 16, 8)]
    assert ".".join(map(str, numbers)) == __version__.removesuffix(".dev0")
    assert (version.flight_sw_version & 0xFF == mavlink.FIRMWARE_VERSION_TYPE_OFFICIAL) == (
        not __version__.endswith(".dev0")
    )
    assert version.capabilities == (
        encoding
        | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
        | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_FTP
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
        | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    )


@pytest.mark.parametrize(("interval_us", "count"), [(50_000, 40), (250_000, 8), (1, 100), (0, 20), (-1, 0)])
def test_a_rate_can_be_asked_for_within_bounds(interval_us: float, count: int) -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    vehicle.step(33)
    station.command(INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE, interval_us)
    vehicle.step()
    assert station.acks() == [(INTERVAL, ACCEPTED)]
    vehicle.step(200)
    assert len(station.heard("ATTITUDE")) == count


@pytest.mark.parametrize("interval_us", [math.nan, math.inf, -2.0, 1e30])
def test_a_rate_that_is_none_is_denied_and_so_is_silence_of_the_heartbeat(interval_us: float) -> None:
    vehicle = LinkedVehicle()
    (station,) = vehicle.stations
    station.command(INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE, interval_us)
    station.command(INTERVAL, mavlink.MAVLINK_MSG_ID_HEARTBEAT, -1)
    vehicle.step(3)
    assert station.acks() == [(INTERVAL, DENIED), (INTERVAL, DENIED)]
    vehicle.step(99)
    assert sorted({m.get_type() for m in station.messages} & {"ATTITUDE", "HEARTBEAT"}) == ["ATTITUDE", "HEARTBEAT"]


commands = st.one_of(
    st.tuples(st.just(ARM), st.sampled_from([0.0, 1.0, 3.0]), st.just(0.0), st.just(0.0)),
    st.tuples(st.just(SET_MODE), st.just(float(CUSTOM)), st.sampled_from([2.0, 3.0, 9.0, 19.0, 5.0]), st.just(0.0)),
    st.tuples(st.just(REQUEST), st.sampled_from([0.0, 30.0, 77.0]), st.just(0.0), st.just(0.0)),
    st.tuples(st.sampled_from(COMMANDS), st.just(0.0), st.just(0.0), st.just(0.0)),
)


@settings(max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 12), st.integers(0, 1), commands), max_size=20))
def test_whatever_is_asked_each_command_is_answered_exactly_once(script) -> None:
    vehicle = LinkedVehicle(links=2)
    asked = [[], []]
    for number, (wait, link, (command, *params)) in enumerate(script):
        # Every one by another asker, so that none is the repetition of another's.
        Station(vehicle, link, system=20 + number).command(command, *params)
        asked[link].append((command, 20 + number))
        vehicle.step(wait)
    vehicle.step(60)
    for station in vehicle.stations:
        answered = [(ack.command, ack.target_system) for ack in station.heard("COMMAND_ACK")]
        assert sorted(answered) == sorted(asked[station.link])


def test_what_every_link_says_is_the_same_bytes_for_the_same_inputs() -> None:
    def run() -> list[bytes]:
        vehicle = node(identities=(Identity.ARDUSUB, Identity.GENERIC))
        return [datagram for k in range(200) for datagram in vehicle.report(cycle(k))]

    assert run() == run()
    assert sum(map(len, map(parse, run()))) == 2 * 2 * (2 * 10 + 5 * 5 + 7 * 2 + 11 * 1)
