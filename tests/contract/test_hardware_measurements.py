"""What devices say, encoded by pydronecan, reaches its field of the frame in the right unit, sign and time."""

from __future__ import annotations

import dataclasses
import math

import dronecan
import pytest

from firmware_py.estimation.integrity.confirmation import hear_leak
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.records.sensing import fin_bit

from .conftest import FIN_NAMES
from .devices import (
    GOOD,
    NAN,
    NOTHING,
    battery,
    distance,
    fields,
    fin,
    fix,
    hardpoint,
    humidity,
    pressure,
    propeller,
    solution,
)
from .vehicle import LATENCY, NODES, Vehicle, frames

T7 = 0.07
"""The time of tick 7."""


@pytest.mark.parametrize(("role", "message", "field", "value"), GOOD.values(), ids=GOOD)
def test_each_message_reaches_its_field_and_is_news_for_one_tick(role, message, field, value):
    with Vehicle() as vehicle:
        assert fields(vehicle.read(6)) == NOTHING
        vehicle.node(role).send(message())
        frame = vehicle.read(7)
        heard = getattr(frame, field)
        assert heard.value == pytest.approx(value, abs=1e-3, rel=1e-6)
        assert heard.t_valid == pytest.approx(T7 - LATENCY.get(role, 0.0), abs=1e-12)
        assert (heard.fresh, heard.ok) == (True, True)
        assert fields(frame) | {field: NOTHING[field]} == NOTHING
        for k in (8, 9):
            assert getattr(vehicle.read(k), field) == dataclasses.replace(heard, fresh=False)


def test_a_frame_that_was_handed_out_never_changes():
    with Vehicle() as vehicle:
        vehicle.node("pressure").send(pressure(2e5))
        vehicle.node("servo_hub").send(fin(1, 0.25))
        frame = vehicle.read(0)
        before = fields(frame)
        vehicle.node("pressure").send(pressure(3e5))
        vehicle.node("servo_hub").send(fin(1, 0.5))
        vehicle.read(1)
        assert fields(frame) == before


def test_each_fin_has_its_place_and_actuators_beyond_the_fins_have_none():
    with Vehicle() as vehicle:
        angles = {3: 0.25, 0: -0.125, 4: 1.0, 255: 1.0, 2: 0.5}
        for actuator_id, angle in angles.items():
            vehicle.node("servo_hub").send(fin(actuator_id, angle))
        fins = vehicle.read(7).fins
        assert [heard.value for heard in fins] == pytest.approx([-0.125, NAN, 0.5, 0.25], nan_ok=True)
        assert [heard.fresh for heard in fins] == [True, False, True, True]
        assert [heard.ok for heard in fins] == [True, False, True, True]
        assert fins[0].t_valid == pytest.approx(T7 - LATENCY["servo_hub"])
        vehicle.node("servo_hub").send(fin(1, 0.0625))
        later = vehicle.read(8).fins
        assert [heard.fresh for heard in later] == [False, True, False, False]
        assert [heard.value for heard in later] == [-0.125, 0.0625, 0.5, 0.25]


@pytest.mark.parametrize("angle", [60_000.0, -65_504.0, 0.25 + 2.0 * math.pi, 1.06])
def test_a_fin_where_none_can_be_is_not_believed_and_one_at_its_stop_is(angle):
    believed = []
    with Vehicle() as vehicle:
        for k, told in ((0, 1.03), (1, angle), (2, 0.25), (499, 0.25), (502, 0.25)):
            vehicle.node("servo_hub").send(fin(1, told))
            one = vehicle.read(k).fins[1]
            assert one.value == pytest.approx(told, rel=1e-3)
            believed.append(one.ok)
        assert vehicle.hardware.losses()[f"{FIN_NAMES[1]}_impossible_angles"] == 1
    assert believed == [True, False, False, False, True]


def test_only_the_hardpoint_of_the_drop_weight_is_ours():
    with Vehicle() as vehicle:
        vehicle.node("hardpoint").send(hardpoint(0, which=1))
        vehicle.node("battery").send(hardpoint(0))
        assert fields(vehicle.read(0)) == NOTHING
        vehicle.node("hardpoint").send(hardpoint(1))
        heard = vehicle.read(1).hardpoint
        assert heard.ok
        assert heard.value.holds
        assert math.isnan(heard.value.load)


def test_only_the_first_propeller_is_ours():
    with Vehicle() as vehicle:
        vehicle.node("esc").send(propeller(600))
        vehicle.node("esc").send(propeller(6000, index=1))
        assert vehicle.read(0).n.value == 10.0


DOUBTFUL = {
    "attitude unknown": ("ahrs", lambda: solution((NAN,) * 4), "ahrs"),
    "one component unknown": ("ahrs", lambda: solution((0.0, NAN, 0.0, 1.0)), "ahrs"),
    "quaternion of no length": ("ahrs", lambda: solution((0.0,) * 4), "ahrs"),
    "a rate unknown": ("ahrs", lambda: solution(rates=(0.0, 0.0, NAN)), "ahrs"),
    "pressure unknown": ("pressure", lambda: pressure(NAN), "pressure"),
    "range undefined": ("altimeter", lambda: distance(5.0, reading=0), "altitude"),
    "bottom too close": ("altimeter", lambda: distance(0.0, reading=2), "altitude"),
    "bottom too far": ("altimeter", lambda: distance(60.0, reading=3), "altitude"),
    "range not a number": ("altimeter", lambda: distance(NAN), "altitude"),
    "no fix": ("fix", lambda: fix(status=0), "fix"),
    "time only": ("fix", lambda: fix(status=1), "fix"),
    "flat fix": ("fix", lambda: fix(status=2), "fix"),
    "fix of negative variance": ("fix", lambda: fix(covariance=(-1.0,) * 6), "fix"),
    "voltage unknown": ("battery", lambda: battery(voltage=NAN), "battery"),
    "humidity unknown": ("battery", lambda: humidity(NAN), "leak"),
}


@pytest.mark.parametrize(("role", "message", "field"), DOUBTFUL.values(), ids=DOUBTFUL)
def test_what_its_device_does_not_vouch_for_is_heard_and_not_ok(role, message, field):
    with Vehicle() as vehicle:
        vehicle.node(role).send(message())
        frame = vehicle.read(7)
        heard = getattr(frame, field)
        assert (heard.fresh, heard.ok) == (True, False)
        assert fields(frame) | {field: NOTHING[field]} == NOTHING
        assert vehicle.hardware.losses()["transfers_malformed"] == 0


@pytest.mark.parametrize("covariance", [(), (NAN,) * 6, (0.0,) * 6])
@pytest.mark.parametrize(("pdop", "std"), [(1.5, 7.5), (0.0, 10.0), (NAN, 10.0)])
def test_a_fix_without_variance_is_as_good_as_its_dilution_says(covariance, pdop, std):
    with Vehicle() as vehicle:
        vehicle.node("fix").send(fix(covariance=covariance, pdop=pdop))
        heard = vehicle.read(7).fix
        assert (heard.fresh, heard.ok, heard.value.std) == (True, True, std)


def test_of_what_is_no_fix_no_accuracy_is_known():
    with Vehicle() as vehicle:
        vehicle.node("fix").send(fix(status=0, covariance=()))
        assert math.isnan(vehicle.read(7).fix.value.std)


def test_no_fix_is_taken_to_be_better_than_a_tenth_of_a_metre():
    with Vehicle() as vehicle:
        vehicle.node("fix").send(fix(covariance=(1e-6,) * 6, pdop=9.0))
        assert vehicle.read(7).fix.value.std == 0.1


INFINITE = {  # pydronecan does not say infinity, but a device may: little-endian float16 and float32
    "attitude": ("ahrs", solution, "ahrs", (13, b"\x00\x7c")),
    "rate": ("ahrs", solution, "ahrs", (16, b"\x00\xfc")),
    "pressure": ("pressure", lambda: pressure(1e5), "pressure", (0, b"\x00\x00\x80\x7f")),
    "variance": ("fix", fix, "fix", (48, b"\x00\x7c")),
}


@pytest.mark.parametrize(("role", "message", "field", "put"), INFINITE.values(), ids=INFINITE)
def test_infinity_is_heard_and_not_ok(role, message, field, put):
    with Vehicle() as vehicle:
        for can_id, data in frames(message(), NODES[role], put=put):
            vehicle.node(role).raw(can_id, data)
        heard = getattr(vehicle.read(0), field)
        assert (heard.fresh, heard.ok) == (True, False)


def test_a_servo_that_does_not_know_its_angle_is_not_ok():
    with Vehicle() as vehicle:
        vehicle.node("servo_hub").send(fin(2, NAN))
        heard = vehicle.read(0).fins[2]
        assert (heard.fresh, heard.ok) == (True, False)


def test_a_charge_beyond_full_is_unknown():
    with Vehicle() as vehicle:
        vehicle.node("battery").send(battery(charge=127))
        heard = vehicle.read(0).battery
        assert heard.ok
        assert math.isnan(heard.value.remaining)


SEVERAL = {  # role, field, message, unit, what the better and the worse one tell, when a silent one is left out, s
    "hygrometers": ("battery", "leak", humidity, 0.01, (35, 100), 3.0),
    "packs": ("battery", "battery", lambda charge, which: battery(charge=charge, which=which), 0.01, (80, 3), 3.0),
    "altimeters": ("altimeter", "altitude", lambda metres, which: distance(metres, 1, which), 1.0, (9, 2), 1.0),
}


@pytest.mark.parametrize(("role", "field", "message", "unit", "tells", "timeout"), SEVERAL.values(), ids=SEVERAL)
@pytest.mark.parametrize("worse", [0, 1])
def test_of_several_sensors_of_a_node_the_worst_is_heard_while_it_speaks(
    role, field, message, unit, tells, timeout, worse
):
    told = {}
    with Vehicle() as vehicle:
        for k in range(0, 1000, 10):
            which = k // 10 % 2
            if which != worse or 0 < k < 500:
                vehicle.node(role).send(message(tells[which == worse], which))
            one = getattr(vehicle.read(k), field)
            assert one.ok or k == 0
            if one.fresh:
                told[k / 100] = round(getattr(one.value, "remaining", one.value) / unit)
    beside, alone = ({t: told[t] for t in told if since <= t < until} for since, until in ((0.2, 5.0), (5.0, 10.0)))
    assert ({*beside.values()}, len(beside)) == ({tells[1]}, 24)
    assert {*alone.values()} == {tells[0]}
    last_heard = 4.8 + 0.1 * worse
    assert timeout < min(alone) - last_heard < timeout + 0.2


@pytest.mark.parametrize("wet", [0, 1])
def test_one_flooded_compartment_beside_a_dry_one_is_confirmed_to_be_wet(wet):
    watch = SourceWatch(3.0, math.inf, 10)
    with Vehicle() as vehicle:
        for k in range(0, 2000, 50):
            which = k // 50 % 2
            vehicle.node("battery").send(humidity(100.0 if k > 1000 and which == wet else 35.0, which))
            frame = vehicle.read(k)
            if frame.leak.fresh:
                hear_leak(frame.leak, k / 100, watch)
        assert watch.screen(frame.leak).value == 1.0


def test_servos_report_under_their_own_nodes_and_ids_and_with_their_own_angles():
    fins = [{"name": name, "id": 1 + i, "node": 31 + i, "status_id": 0} for i, name in enumerate(FIN_NAMES)]
    fins[1] |= {"reversed": True, "scale": 2.0, "zero_deg": 5.729577951308232, "travel_deg": 90.0}
    with Vehicle(fins=fins) as vehicle:
        for i in range(4):
            vehicle.node(31 + i).send(fin(0, 0.125))
        vehicle.node("servo_hub").send(fin(0, 0.5))
        heard = vehicle.read(0).fins
    assert [one.value for one in heard] == pytest.approx([0.125, -0.0125, 0.125, 0.125])


def test_a_node_that_says_it_does_not_work_takes_its_own_fin_alone():
    fins = [{"name": name, "id": 1 + i, "node": 31 + i, "status_id": 0} for i, name in enumerate(FIN_NAMES)]
    with Vehicle(fins=fins) as vehicle:
        for i in range(4):
            vehicle.node(31 + i).send(fin(0, 0.125))
        vehicle.node(33).send(dronecan.uavcan.protocol.NodeStatus(health=3))
        frame = vehicle.read(0)
    assert [one.ok for one in frame.fins] == [True, True, False, True]
    assert frame.unhealthy == fin_bit(2)


@pytest.mark.parametrize(("sick", "sound"), [("servo_hub", (2, 3)), (31, (0, 1))])
def test_a_hub_that_says_it_does_not_work_takes_no_fin_of_another_node(sick, sound):
    """Two fins are on the hub, the other two on a node of their own."""
    fins = [{"name": name, "id": 1 + i, "node": 31 * (i > 1)} for i, name in enumerate(FIN_NAMES)]
    with Vehicle(fins=fins) as vehicle:
        for i in range(4):
            vehicle.node(31 if i > 1 else "servo_hub").send(fin(1 + i, 0.125))
        vehicle.node(sick).send(dronecan.uavcan.protocol.NodeStatus(health=3))
        frame = vehicle.read(0)
    assert [i for i, one in enumerate(frame.fins) if one.ok] == [*sound]
    assert frame.unhealthy == sum(fin_bit(i) for i in range(4) if i not in sound)
