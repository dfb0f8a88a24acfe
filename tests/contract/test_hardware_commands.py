"""What the vehicle says, as pydronecan understands it: commands, arming, life, and who it is."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import dronecan
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.params import ParamError
from firmware_py.records.command import Applied

from .devices import fin
from .vehicle import DISARMED, OWN, Vehicle

FLYING = Applied((0.25, -0.125, 0.0625, -0.5), 8.0, armed=True, limited=False)
ARRAY, RPM, RAW, ARMING, HARDPOINT, STATUS, SAFETY = 1010, 1031, 1030, 1100, 1070, 341, 20000


def spoken(vehicle: Vehicle, ticks: int, applied: Applied, first: int = 0) -> dict[int, list]:
    """The transfers of some ticks, per type; every one is a broadcast of the vehicle's own node."""
    for k in range(first, first + ticks):
        vehicle.write(k, applied)
    by_type: dict[int, list] = {}
    for transfer in vehicle.said():
        assert transfer.source_node_id == OWN
        assert not transfer.service_not_message
        by_type.setdefault(transfer.data_type_id, []).append(transfer)
    return by_type


@pytest.mark.parametrize(("rate", "hz"), [("hz_50", 50), ("hz_25", 25), ("hz_10", 10)])
def test_each_message_has_its_rate_from_the_first_tick_on(rate, hz):
    with Vehicle(rate) as vehicle:
        said = spoken(vehicle, 1, FLYING)
        assert {kind: len(found) for kind, found in said.items()} == dict.fromkeys(
            (ARRAY, RPM, ARMING, HARDPOINT, STATUS, SAFETY), 1
        )
        said = spoken(vehicle, 299, FLYING, first=1)
        assert {kind: len(found) + 1 for kind, found in said.items()} == {
            ARRAY: 3 * hz,
            RPM: 3 * hz,
            ARMING: 6,
            HARDPOINT: 6,
            STATUS: 3,
            SAFETY: 6,
        }


def test_commands_are_radians_per_fin_and_rpm():
    with Vehicle() as vehicle:
        said = spoken(vehicle, 1, FLYING)
        [fins], [propeller] = said[ARRAY], said[RPM]
        commands = fins.payload.commands
        assert [command.actuator_id for command in commands] == [0, 1, 2, 3]
        assert [command.command_value for command in commands] == list(FLYING.fins)
        assert {command.command_type for command in commands} == {commands[0].COMMAND_TYPE_POSITION}
        assert list(propeller.payload.rpm) == [480]


@given(
    st.lists(st.floats(-0.6, 0.6), min_size=4, max_size=4).map(tuple),
    st.floats(-50.0, 50.0),
)
@settings(max_examples=30)
def test_any_command_arrives_within_the_resolution_of_the_wire(fins, n):
    with Vehicle() as vehicle:
        said = spoken(vehicle, 1, Applied(fins, n, armed=True, limited=False))
        angles = [command.command_value for command in said[ARRAY][0].payload.commands]
        assert angles == pytest.approx(fins, rel=2**-11, abs=1e-7)  # float16 has 11 significant bits
        assert said[RPM][0].payload.rpm[0] == pytest.approx(60.0 * n, abs=0.5 + 1e-9)


@pytest.mark.parametrize(
    ("n", "rpm"), [(1e5, 131_071), (-1e5, -131_072), (-10.0, -600), (10.012, 601), (-10.012, -601), (0.008, 0)]
)
def test_a_propeller_speed_is_rounded_and_beyond_the_field_saturates(n, rpm):
    with Vehicle() as vehicle:
        said = spoken(vehicle, 1, Applied((0.0,) * 4, n, armed=True, limited=False))
        assert list(said[RPM][0].payload.rpm) == [rpm]


NAMES = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")


def wired(**more: object) -> list[dict[str, object]]:
    """[[fins]] of servos that count from 1."""
    return [{"name": name, "id": i + 1, **more} for i, name in enumerate(NAMES)]


def test_servos_are_told_by_their_own_ids_what_they_obey():
    fins = wired()
    fins[0] |= {"command": "unitless", "travel_deg": 30.0}
    fins[1] |= {"command": "pwm", "travel_deg": 57.29577951308232, "reversed": True}
    fins[2] |= {"scale": 2.0, "zero_deg": 5.729577951308232, "travel_deg": 90.0}
    with Vehicle(fins=fins) as vehicle:
        commands = spoken(vehicle, 1, FLYING)[ARRAY][0].payload.commands
    assert [one.actuator_id for one in commands] == [1, 2, 3, 4]
    assert [one.command_type for one in commands] == [0, 4, 1, 1]
    expected = [0.25 / (math.pi / 6.0), 1500.0 + 500.0 * 0.125, 0.1 + 2.0 * 0.0625, -0.5]
    assert [one.command_value for one in commands] == pytest.approx(expected, rel=1e-3)


def test_what_a_servo_is_told_at_rest_is_its_own():
    fins = wired()
    fins[1] |= {"at_rest": "hold"}
    fins[2] |= {"at_rest": "silent"}
    with Vehicle(fins=fins) as vehicle:
        spoken(vehicle, 100, FLYING)
        last = spoken(vehicle, 100, DISARMED, first=100)[ARRAY][-1].payload.commands
        assert [(one.actuator_id, one.command_value) for one in last] == [(1, 0.0), (2, -0.125), (4, 0.0)]


def test_a_servo_that_holds_is_told_nothing_before_it_has_reported_and_then_to_stay_there():
    with Vehicle(fins=wired(at_rest="hold")) as vehicle:
        assert ARRAY not in spoken(vehicle, 100, DISARMED)
        vehicle.node("servo_hub").send(fin(2, 0.375))
        vehicle.read(100)
        vehicle.node("servo_hub").send(fin(2, 0.5))
        vehicle.read(101)
        last = spoken(vehicle, 100, DISARMED, first=101)[ARRAY][-1].payload.commands
        assert [(one.actuator_id, one.command_value) for one in last] == [(2, 0.375)]


@pytest.mark.parametrize(("at_rest", "at_last"), [("centre", 255), ("silent", 0)])
def test_servos_that_wait_for_the_safety_state_may_move_while_armed_or_where_they_are_told_at_rest(at_rest, at_last):
    """AP_Periph holds its outputs until it hears 255."""
    with Vehicle(fins=wired(at_rest=at_rest)) as vehicle:
        assert [one.payload.status for one in spoken(vehicle, 100, FLYING)[SAFETY]] == [255, 255]
        assert spoken(vehicle, 100, DISARMED, first=100)[SAFETY][-1].payload.status == at_last


def test_a_propeller_may_be_told_a_share_of_its_full_speed():
    table = {"command": "raw", "index": 1, "reversed": True, "full_speed_rpm": 960.0}
    with Vehicle(propeller=table) as vehicle:
        [raw] = spoken(vehicle, 1, FLYING)[RAW]
        assert list(raw.payload.cmd) == [0, -4096]
        assert RPM not in spoken(vehicle, 1, FLYING, first=1)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({0: {"name": "fin_1"}}, "fins: fin_1: is no fin of vehicle.toml, which has stern_port"),
        ({0: {"name": "rudder_lower"}}, "fins: rudder_lower: stands there twice"),
        ({0: {"id": 4}}, "fins: stern_port and rudder_lower obey the same actuator id 4"),
        ({0: {"status_id": 4}}, "fins: stern_port and rudder_lower report under the same node and id 4"),
        ({0: {"status_id": 4, "node": 21}}, "fins: stern_port and rudder_lower report under the same node and id 4"),
        ({0: {"travel_deg": 20.0}}, "travel_deg = 20: the servo must turn to 23 deg for the fin's delta_max_deg = 23"),
        ({0: {"node": 10}}, "fins: stern_port: node = 10: is can.node_id already; give another"),
        ({0: {"node": 23, "id": 2}}, "fins: stern_port and stern_starboard obey the same actuator id 2, and all nodes"),
    ],
)
def test_servos_that_cannot_be_are_refused_in_a_line(change, why):
    fins = wired()
    for i, keys in change.items():
        fins[i] |= keys
    with pytest.raises(ParamError, match=re.escape(why)):
        Vehicle(fins=fins)


def test_disarmed_it_goes_on_telling_every_actuator_to_rest():
    with Vehicle() as vehicle:
        assert spoken(vehicle, 100, FLYING)[ARMING][-1].payload.status == 255
        said = spoken(vehicle, 100, DISARMED, first=100)
        assert [transfer.payload.status for transfer in said[ARMING]] == [0, 0]
        assert len(said[ARRAY]) == len(said[RPM]) == 50
        assert all([c.command_value for c in t.payload.commands] == [0.0] * 4 for t in said[ARRAY])
        assert all(list(t.payload.rpm) == [0] for t in said[RPM])


def test_the_hardpoint_holds_until_it_is_to_release_and_is_told_again_and_again():
    with Vehicle() as vehicle:
        held = spoken(vehicle, 100, DISARMED)[HARDPOINT]
        assert [(t.payload.hardpoint_id, t.payload.command) for t in held] == [(0, 1)] * 2
        released = spoken(vehicle, 100, replace(DISARMED, drop=True), first=100)[HARDPOINT]
        assert [(t.payload.hardpoint_id, t.payload.command) for t in released] == [(0, 0)] * 10


def test_commands_win_the_bus_over_everything_else():
    with Vehicle() as vehicle:
        priority = {kind: found[0].transfer_priority for kind, found in spoken(vehicle, 1, FLYING).items()}
        assert max(priority[ARRAY], priority[RPM]) < min(priority[ARMING], priority[STATUS])


def test_transfer_ids_count_per_type_without_a_gap():
    with Vehicle() as vehicle:
        for found in spoken(vehicle, 200, FLYING).values():
            assert [transfer.transfer_id for transfer in found] == [i % 32 for i in range(len(found))]


def test_it_lives_and_is_well_and_counts_its_seconds_and_begins_until_it_knows_attitude_and_depth():
    with Vehicle() as vehicle:
        statuses = [transfer.payload for transfer in spoken(vehicle, 301, FLYING)[STATUS]]
        assert [status.uptime_sec for status in statuses] == [0, 1, 2, 3]
        assert {(status.health, status.mode) for status in statuses} == {
            (statuses[0].HEALTH_OK, statuses[0].MODE_INITIALIZATION)
        }


def test_whoever_asks_is_told_who_it_is():
    with Vehicle() as vehicle:
        asking = vehicle.node(42)
        asking.send(dronecan.uavcan.protocol.NodeStatus())  # so that the request's transfer id is not zero
        transfer_id = asking.send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=OWN)
        vehicle.read(1234)
        vehicle.write(1234)
        [answer] = [transfer for transfer in vehicle.said() if transfer.service_not_message]
        assert (answer.source_node_id, answer.dest_node_id) == (OWN, 42)
        assert (answer.transfer_id, answer.request_not_response) == (transfer_id, False)
        assert bytes(answer.payload.name).decode() == "org.sternplane.autopilot"
        assert answer.payload.status.uptime_sec == 12
        assert len(answer.payload.hardware_version.unique_id) == 16
        vehicle.read(1235)
        vehicle.write(1235)
        assert not vehicle.said()


def test_questions_to_others_and_other_questions_are_not_answered():
    with Vehicle() as vehicle:
        vehicle.node(42).send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=OWN + 1)
        vehicle.node(42).send(dronecan.uavcan.protocol.file.GetInfo.Request(), to=OWN)
        for k in (1, 2):
            vehicle.read(k)
            vehicle.write(k)
        assert not [transfer for transfer in vehicle.said() if transfer.service_not_message]


def test_any_number_of_questions_costs_one_answer_a_tick_behind_the_commands_and_all_are_answered():
    askers = set(range(30, 128))
    with Vehicle() as vehicle:
        for node_id in askers:
            for _ in range(2):
                vehicle.node(node_id).send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=OWN)
        answered = set()
        for k in range(0, 2 * len(askers), 2):
            vehicle.read(k)
            vehicle.write(k, FLYING)
            said = vehicle.said()
            services = [transfer.service_not_message for transfer in said]
            assert services.count(True) == 1
            assert services[-1]
            assert {ARRAY, RPM} <= {transfer.data_type_id for transfer in said}
            answered.add(said[-1].dest_node_id)
        assert answered == askers
