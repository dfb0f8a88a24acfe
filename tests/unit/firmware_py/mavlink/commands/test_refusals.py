"""Whatever is refused comes with one sentence, in the words of the link's stations."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pymavlink import mavutil
from pymavlink.dialects.v20 import all as mavlink

from firmware_py.mavlink.base.codec import Message
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.modes import available_modes
from firmware_py.mavlink.base.refusal import ModeReason, ModeRefusal, refusal_text
from firmware_py.records.event import Event
from firmware_py.records.health import sound
from firmware_py.records.order import Mode, Order
from firmware_py.safety.start import NOT_ARMED, KeptMode
from firmware_py.safety.supervisor import SafetyParams, Supervisor
from firmware_py.tick import Tick
from tests.unit.firmware_py.mavlink.station import DT_NS, STATE, LinkedVehicle, Station, frame, node, put_together

ACCEPTED, REJECTED, DENIED = 0, 1, 2
COMMANDS = sorted(number for number in mavlink.enums["MAV_CMD"] if number != mavlink.MAV_CMD_ENUM_END)
ARM, SET_MODE = mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_CMD_DO_SET_MODE
NAN, INF = math.nan, math.inf
PARAMS = st.sampled_from([0.0, 1.0, 2.0, 3.0, 7.0, -1.0, 0.5, 129.0, 300.0, 1e9, NAN, INF])
ARDUSUB = {
    Mode.MANUAL: "MANUAL",
    Mode.HOLD: "ALT_HOLD",
    Mode.MISSION: "AUTO",
    Mode.SURFACE: "SURFACE",
    Mode.LOITER: "POSHOLD",
    Mode.GUIDED: "GUIDED",
}
"""As pymavlink's mode_mapping_sub has them, which MAVProxy shows."""


def strict(kept: KeptMode = NOT_ARMED) -> object:
    """The vehicle's own supervisor, without a mission; an earlier run ended as `kept` says."""
    supervisor, ticks = Supervisor(SafetyParams(), has_mission=False), iter(range(1_000_000))
    supervisor.resume(weight_gone=False, kept=kept)

    def decide(mode: Mode, order: Order) -> tuple[Mode, tuple[Event, ...], dict[str, object]]:
        tick = Tick(next(ticks), DT_NS)
        supervisor.thaw(supervisor.freeze()._replace(mode=mode))
        answer = supervisor.update(tick, frame(tick.t), STATE, sound(0), order, False)
        return answer.mode, supervisor.events, {"chosen": answer.chosen, "drop": answer.drop}

    return decide


def vehicle_in(mode: Mode) -> tuple[LinkedVehicle, Station]:
    vehicle = LinkedVehicle(supervisor=strict())
    vehicle.mode = mode
    vehicle.step()
    vehicle.stations[0].messages.clear()
    return vehicle, vehicle.stations[0]


def refused(messages: list[Message]) -> list[str]:
    """The sentences of a refusal: no notices, and no change of mode."""
    texts = put_together([m for m in messages if m.get_type() == "STATUSTEXT"])
    return [text for text in texts if " refused" in text]


@settings(max_examples=25)
@given(st.lists(PARAMS, min_size=7, max_size=7), st.sampled_from(Mode), st.booleans())
@example([0.0] * 7, Mode.DISARMED, False)
@example([1.0] * 7, Mode.DISARMED, False)
@example([1.0] * 7, Mode.HOLD, False)
@example([3.0] * 7, Mode.DISARMED, True)
@example([0.0, 0.0, 0.0, 0.0, NAN, NAN, NAN], Mode.SURFACE, False)
def test_whatever_command_is_refused_says_why_in_one_sentence(params: list[float], mode: Mode, as_int: bool) -> None:
    vehicle, station = vehicle_in(mode)
    for number in COMMANDS:
        vehicle.mode = mode
        if as_int:
            x, y = (int(value) if math.isfinite(value) else 0 for value in params[4:6])
            station.send(mavlink.MAVLink_command_int_message(1, 1, 3, number, 0, 0, *params[:4], x, y, params[6]))
        else:
            station.command(number, *params)
        vehicle.step(3)
        (answer,) = [m.result for m in station.messages if m.get_type() == "COMMAND_ACK"]
        least, most = answer in (DENIED, REJECTED), answer != ACCEPTED  # what is unsupported may do without
        assert least <= len(refused(station.messages)) <= most, (number, answer, station.messages)
        station.messages.clear()


def test_who_is_disarmed_is_told_to_arm_first() -> None:
    vehicle, station = vehicle_in(Mode.DISARMED)
    for command in (
        (mavlink.MAV_CMD_CONDITION_YAW, 90.0),
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, 1.5),
        (mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,),
        (mavlink.MAV_CMD_NAV_LAND,),
        (mavlink.MAV_CMD_DO_PAUSE_CONTINUE, 0.0),
    ):
        station.command(*command)
        vehicle.step(3)
        (sentence,) = refused(station.messages)
        assert "arm first" in sentence
        assert station.acks() == [(command[0], REJECTED)]


@pytest.mark.parametrize("mode", ARDUSUB)
def test_a_mode_set_while_disarmed_is_shown_and_held_at_arming(mode: Mode) -> None:
    vehicle, station = vehicle_in(Mode.DISARMED)
    (number,) = [number for number, name in mavutil.mode_mapping_sub.items() if name == ARDUSUB[mode]]
    station.command(SET_MODE, 1, number)
    vehicle.step(100)
    if mode is Mode.MISSION:  # there is none
        assert refused(station.messages) == ["AUTO refused to station 255/190: no mission is loaded"]
        assert station.acks() == [(SET_MODE, REJECTED)]
        return
    assert [(beat.custom_mode, beat.base_mode & 128) for beat in station.heard("HEARTBEAT")] == [(number, 0)]
    station.command(ARM, 1)
    vehicle.step(100)
    assert vehicle.mode is mode
    assert [(beat.custom_mode, beat.base_mode & 128) for beat in station.heard("HEARTBEAT")] == [(number, 128)]


@pytest.mark.parametrize("mode", Mode)
def test_modes_are_called_what_the_links_stations_show(mode: Mode) -> None:
    refusal = ModeRefusal(ModeReason.SPEED_ONLY, mode, (mode, Mode.MANUAL))
    ours, theirs = (refusal_text(refusal, identity).split(" takes ")[0] for identity in Identity)
    assert ours == ARDUSUB.get(mode, mode.name)
    assert theirs in {message.mode_name for message in available_modes(Identity.GENERIC, 0)} | {"Disarmed"}
    assert refusal_text(refusal, Identity.ARDUSUB) == f"{ours} takes a speed only; set {ours} or MANUAL"


def test_a_refusal_without_modes_is_sent_as_it_stands() -> None:
    sentence = "no parameter MISSION, SURFACE or HOLD"
    assert {refusal_text(sentence, identity) for identity in Identity} == {sentence}


@pytest.mark.parametrize(
    ("identity", "known"),
    [
        (Identity.ARDUSUB, "MANUAL 19, ALT_HOLD 2, POSHOLD 16, GUIDED 4, AUTO 3, SURFACE 9"),
        (
            Identity.GENERIC,
            "Manual 1/0, Depth hold 2/0, Position hold 4/3, Guided 6/0, Auto 4/4, Surface 4/6, Return 4/5",
        ),
    ],
)
def test_an_unknown_mode_is_refused_with_those_that_there_are(identity: Identity, known: str) -> None:
    vehicle = LinkedVehicle()
    vehicle.node = node(identities=(identity,))
    vehicle.stations[0].command(SET_MODE, 1, 77)
    vehicle.step(2)
    assert refused(vehicle.stations[0].messages) == [f"DO_SET_MODE refused: mode 77/0 is unknown; {known}"]


def test_each_link_reads_an_event_in_its_own_words() -> None:
    vehicle = LinkedVehicle(links=2, supervisor=strict())
    vehicle.node = node(identities=(Identity.ARDUSUB, Identity.GENERIC))
    one, two = vehicle.stations
    one.command(ARM, 1)
    vehicle.step()
    one.messages.clear()
    two.messages.clear()
    two.command(SET_MODE, 1, 2)
    vehicle.step(2)
    heard = [put_together([m for m in each.messages if m.get_type() == "STATUSTEXT"]) for each in (one, two)]
    assert heard == [
        ["MANUAL -> ALT_HOLD: ordered by station 255/190"],
        ["Manual -> Depth hold: ordered by station 255/190"],
    ]


def test_what_waited_when_somebody_disarmed_says_so() -> None:
    vehicle, station = vehicle_in(Mode.HOLD)
    station.command(SET_MODE, 1, 19)
    station.command(ARM, 0, 21196)
    vehicle.step(3)
    assert refused(station.messages) == ["DO_SET_MODE refused: disarming goes first"]
    assert sorted(station.acks()) == [(SET_MODE, REJECTED), (ARM, ACCEPTED)]


def test_who_began_under_water_and_is_to_come_up_is_not_told_that_it_was_disarmed() -> None:
    vehicle = LinkedVehicle(supervisor=strict(KeptMode(Mode.MISSION, 10.0, 15.0)))
    station = vehicle.stations[0]
    station.command(ARM, 0)
    vehicle.step(2)
    assert len(refused(station.messages)) == 1
    assert station.acks() == [(ARM, REJECTED)]


def test_an_order_that_others_overrule_says_what_holds() -> None:
    vehicle = LinkedVehicle(supervisor=lambda mode, order: (Mode.HOLD, ()))
    vehicle.stations[0].command(ARM, 1)
    vehicle.step()
    vehicle.stations[0].messages.clear()
    vehicle.stations[0].command(SET_MODE, 1, 9)
    vehicle.step(2)
    (sentence,) = refused(vehicle.stations[0].messages)
    assert sentence == "DO_SET_MODE refused: another order was obeyed, and the mode is ALT_HOLD"


def test_a_mission_is_not_cleared_while_one_is_sent_and_the_station_is_told() -> None:
    vehicle = LinkedVehicle(links=2)
    sender, other = vehicle.stations
    sender.send(mavlink.MAVLink_mission_count_message(1, 1, 3, 0))
    vehicle.step()
    other.send(mavlink.MAVLink_mission_clear_all_message(1, 1, 0))
    vehicle.step(2)
    assert refused(other.messages) == ["MISSION_CLEAR_ALL refused: a station is sending a plan"]
    assert [m.type for m in other.messages if m.get_type() == "MISSION_ACK"] == [mavlink.MAV_MISSION_DENIED]


def test_no_home_and_no_origin_is_taken_from_a_place_that_is_none() -> None:
    vehicle, station = vehicle_in(Mode.DISARMED)
    station.send(mavlink.MAVLink_set_gps_global_origin_message(1, 0, 0, 300_000))
    vehicle.step(4)
    (sentence,) = refused(station.messages)
    assert sentence.startswith("SET_GPS_GLOBAL_ORIGIN refused: origin stays at 46.5")
