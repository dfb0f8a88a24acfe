"""What was learned, as pymavlink hears it and as its users ask for it."""

from __future__ import annotations

import dataclasses
import math

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.identity import Identity
from firmware_py.records.adoption import Adopted, AxisDesign, Refusal, Source
from firmware_py.records.estimate import NOTHING_LEARNED, Learned
from firmware_py.records.health import SOUND_FIN, FinEvidence, FinHealth
from firmware_py.records.manoeuvrability import RESERVE, UNLIMITED
from tests.unit.firmware_py.mavlink.station import LEARNED, NAMES, SOUND, LinkedVehicle, cycle, frame, node, parse, told

BESIDE = ["nis_dvl", "nis_gyro", "nis_att", "current_n", "current_e", "turbulence"]


def reports(learned: Learned, seconds: float = 1.0, vehicle=None, link: int = 0, **state) -> list:
    vehicle = vehicle or node(coefficients=NAMES)
    ticks = range(round(100 * seconds))
    return [m for k in ticks for m in parse(vehicle.report(cycle(k, learned=learned, **state))[link])]


def arrays(learned: Learned) -> dict[str, list]:
    found: dict[str, list] = {}
    for message in reports(learned):
        if message.get_type() == "DEBUG_FLOAT_ARRAY":
            found.setdefault(message.name, []).append(message)
    return found


def test_values_sigmas_and_states_are_arrays_in_the_order_of_the_names() -> None:
    found = arrays(LEARNED)
    assert {name: len(messages) for name, messages in found.items()} == {
        "late_us": 1, "xi": 1, "xi_std": 1, "xi_state": 1, "design": 1, "fins": 4, "damage": 1
    }  # fmt: skip
    assert found["xi"][0].data[:4] == [-0.0625, 0.03125, 1.25, 0.0]
    assert found["xi_std"][0].data[:4] == [0.0078125, 0.015625, 0.5, 0.0]
    assert found["xi_state"][0].data[:4] == [1.0, 2.0, 3.0, 0.0]
    assert found["xi"][0].time_usec == 150_000


def test_the_design_in_force_is_an_array() -> None:
    depth = AxisDesign(Source.LEARNED, Refusal.NONE, -2.0, 0.0625, (-0.4, -0.5), 3.0)
    heading = AxisDesign(Source.NOMINAL, Refusal.RESIDUALS, -0.5, 0.125, (-0.4, -0.5), -20.0)
    adopted = Adopted((-0.0625, -0.5), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0), depth, heading, 0.25)
    vehicle = node(coefficients=NAMES)
    ticks = [dataclasses.replace(cycle(k, learned=LEARNED), adopted=adopted) for k in range(100)]
    heard = [message for one in ticks for message in parse(vehicle.report(one)[0])]
    (design,) = [m for m in heard if m.get_type() == "DEBUG_FLOAT_ARRAY" and m.name == "design"]
    laws = [2.0, 0.0, -2.0, 0.0625, 4.0, 5.0, -0.5, 0.125]
    assert design.data[:18] == [-0.0625, -0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, *laws, 0.25, 0.0]


def test_damage_is_an_array() -> None:
    left = (SOUND_FIN, FinHealth(1.0, 0.125, FinEvidence.FEEDBACK), *[FinHealth(0.5, source=FinEvidence.MOTION)] * 2)
    able = UNLIMITED._replace(turn=0.0625, turn_left=0.5, dive_left=0.25, speed=0.75)
    actuators = dataclasses.replace(SOUND, left=left)
    for damaged, health in ((1.0, actuators), (0.0, SOUND)):
        vehicle = node(coefficients=NAMES)
        ticks = [dataclasses.replace(cycle(k, actuators=health), left=able) for k in range(100)]
        heard = [message for one in ticks for message in parse(vehicle.report(one)[0])]
        (damage,) = [m for m in heard if m.get_type() == "DEBUG_FLOAT_ARRAY" and m.name == "damage"]
        assert damage.data[:3] == [damaged, 0.25, 0.5]
        assert damage.data[3] == pytest.approx(16.0 / RESERVE)
        assert damage.data[4] == 0.75
        fins = [1.0, math.nan, 1.0, 0.125, 0.5, math.nan, 0.5, math.nan] if damaged else [1.0, math.nan] * 4
        assert damage.data[5:13] == pytest.approx(fins, nan_ok=True)


def test_every_array_has_a_number_of_its_own() -> None:
    """Stations tell arrays apart by their numbers, not by their names."""
    numbers = {name: {message.array_id for message in messages} for name, messages in arrays(LEARNED).items()}
    assert sorted(number for found in numbers.values() for number in found) == [0, 1, 2, 3, 4, 5, 6]


def test_more_coefficients_than_an_array_holds_are_cut_off() -> None:
    many = dataclasses.replace(
        LEARNED, value=tuple(map(float, range(70))), std=(1.0,) * 70, valid=(True,) * 70, excited=(True,) * 70
    )
    assert arrays(many)["xi"][0].data == [float(i) for i in range(58)]


def test_a_vehicle_that_learns_nothing_says_nothing_of_it() -> None:
    assert set(arrays(NOTHING_LEARNED)) == {"late_us", "fins", "damage"}
    assert "NAMED_VALUE_FLOAT" not in {message.get_type() for message in reports(NOTHING_LEARNED, 3.0)}


def test_each_coefficient_has_its_name_and_its_turn() -> None:
    said = [m for m in reports(LEARNED, 4.0) if m.get_type() == "NAMED_VALUE_FLOAT"]
    assert [message.name for message in said[:9]] == [*NAMES, *BESIDE]
    assert [message.value for message in said[:9]] == [*LEARNED.value, *LEARNED.nis, *LEARNED.current, 0.0625]
    assert [message.name for message in said[9:]] == [*NAMES, *BESIDE, *NAMES][: len(said) - 9]


def test_every_link_hears_every_name() -> None:
    for link in (0, 1):
        vehicle = node(coefficients=NAMES, identities=(Identity.ARDUSUB, Identity.GENERIC))
        said = [m.name for m in reports(LEARNED, 2.0, vehicle, link) if m.get_type() == "NAMED_VALUE_FLOAT"]
        assert set(said) == {*NAMES, *BESIDE}


@pytest.mark.parametrize("interval_us", [100_000, 400_000, 1_000_000, 1_800_000])
def test_at_whatever_rate_they_are_asked_for_every_name_comes(interval_us: int) -> None:
    vehicle = LinkedVehicle(coefficients=NAMES)
    station = vehicle.stations[0]
    station.command(511, mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT, interval_us)
    vehicle.node.receive(cycle().tick, vehicle.incoming)
    said = [m.name for m in reports(LEARNED, 20.0, vehicle.node) if m.get_type() == "NAMED_VALUE_FLOAT"]
    assert set(said) == {*NAMES, *BESIDE}


def test_a_station_without_the_names_still_hears_the_rest() -> None:
    said = [m.name for m in reports(LEARNED, 3.0, node()) if m.get_type() == "NAMED_VALUE_FLOAT"]
    assert said[:6] == BESIDE


def test_pymavlinks_users_find_them_by_name_and_by_number() -> None:
    """As they write it to MAVProxy's graph: NAMED_VALUE_FLOAT['M_q'].value, DEBUG_FLOAT_ARRAY[2].data[0]."""
    messages: dict = {}
    for message in reports(LEARNED, 3.0):
        mavutil.add_message(messages, message.get_type(), message)
    assert mavutil.evaluate_expression("NAMED_VALUE_FLOAT['M_q'].value", messages) == -0.0625
    assert mavutil.evaluate_expression("NAMED_VALUE_FLOAT['turbulence'].value", messages) == 0.0625
    assert mavutil.evaluate_expression("DEBUG_FLOAT_ARRAY[2].data[0]", messages) == -0.0625
    assert mavutil.evaluate_expression("DEBUG_FLOAT_ARRAY[3].data[1]", messages) == 0.015625


ATTITUDE, DEPTH, BOTTOM = 1, 32, 64
MOVING = 2 | 4 | 8 | 256
PLACED = 16 | 512


@pytest.mark.parametrize(
    ("state", "flags"),
    [
        ({}, ATTITUDE | MOVING | PLACED | DEPTH | BOTTOM),
        ({"attitude_ok": False}, DEPTH | BOTTOM),
        ({"velocity_ok": False}, ATTITUDE | DEPTH | BOTTOM),
        ({"depth_ok": False}, ATTITUDE | MOVING | PLACED | BOTTOM),
        ({"altitude": math.nan}, ATTITUDE | MOVING | PLACED | DEPTH),
        ({"position_std": 100.0}, ATTITUDE | MOVING | DEPTH | BOTTOM),
        ({"position_std": math.nan}, ATTITUDE | MOVING | DEPTH | BOTTOM),
    ],
)
def test_the_estimators_flags_are_those_that_are_true(state: dict, flags: int) -> None:
    assert told(**state)["ESTIMATOR_STATUS"].flags == flags


def test_test_ratios_are_innovations_over_three_sigma() -> None:
    said = told(learned=LEARNED, position_std=2.0, depth_std=0.25)["ESTIMATOR_STATUS"]
    assert (said.vel_ratio, said.mag_ratio) == (0.125, 0.25)
    assert (said.pos_horiz_accuracy, said.pos_vert_accuracy) == (2.0, 0.25)
    assert all(map(math.isnan, (said.pos_horiz_ratio, said.pos_vert_ratio, said.hagl_ratio, said.tas_ratio)))


def test_ratios_that_nobody_knows_are_unknown() -> None:
    said = told(sensors=frame())["ESTIMATOR_STATUS"]
    assert math.isnan(said.vel_ratio)
    assert math.isnan(said.mag_ratio)


def test_bytes_are_those_of_the_standard() -> None:
    """Written out by hand from common.xml: the fields in MAVLink's order, little-endian, zeros at the end cut off."""
    frames = {}
    vehicle = node(coefficients=NAMES)
    for k in range(100):
        datagram = vehicle.report(cycle(k, learned=LEARNED, position_std=2.0, depth_std=0.25))[0]
        if datagram:
            frames.setdefault(int.from_bytes(datagram[7:10], "little"), datagram[10:-2])
    assert frames[251].hex() == "78000000000080bd4d5f71"  # 120 ms, -0.0625, "M_q"
    assert frames[230].hex() == (
        "b08f060000000000"  # 430 ms
        "0000003e" "0000c07f" "0000c07f" "0000803e" "0000c07f" "0000c07f"  # 1.125 / 9, unknown, unknown, 2.25 / 9, ...
        "00000040" "0000803e"  # 2 m, 0.25 m
        "7f03"  # 895: all but constant position, GPS glitch and accelerometer error
    )  # fmt: skip
