"""An AHRS on the bus that does not sit straight: attitude and rates of the vehicle, whatever its own axes; by SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from firmware_py.records.sensing import candidate_bit

from .devices import pressure, solution
from .test_hardware_measurements import DOUBTFUL, INFINITE
from .test_nodes import send
from .vehicle import NODES, Vehicle, frames

WITHOUT_AHRS = {name: node for name, node in NODES.items() if name != "ahrs"}
LATENCY_S = 0.2
MOUNTINGS = {
    "straight": (0.0, 0.0, 0.0),
    "upside down": (180.0, 0.0, 0.0),
    "its x axis astern": (0.0, 0.0, 180.0),
    "its x axis to starboard": (0.0, 0.0, 90.0),
    "its x axis up": (0.0, 90.0, 0.0),
    "askew": (-100.0, 35.0, 160.0),
}
"""Roll, pitch, yaw, deg."""
ATTITUDES = [(0.0, 0.0, 0.0), (0.2, -0.3, 1.0), (-0.5, 0.4, -3.0), (3.0, 1.2, 2.0)]
"""Roll, pitch, yaw of the vehicle, rad."""
RATES = (0.05, -0.02, 0.03)


def askew(angles=MOUNTINGS["askew"], node: int = NODES["ahrs"], declination: float = 0.0, **more: object):
    roll, pitch, yaw = angles
    mounting = {"roll_deg": roll, "pitch_deg": pitch, "yaw_deg": yaw, "declination_deg": declination}
    return {"driver": "dronecan", "node": node, "role": "ahrs", "latency_s": LATENCY_S, "mounting": mounting} | more


def rotation(roll: float, pitch: float, yaw: float) -> Rotation:
    """Of axes that are turned so, yaw first."""
    return Rotation.from_euler("ZYX", (yaw, pitch, roll))


def seen(attitude, rates=RATES, angles=MOUNTINGS["askew"]):
    """What an AHRS says that is mounted so in a vehicle of this attitude, with these rates."""
    mounted = rotation(*np.radians(angles))
    return solution((rotation(*attitude) * mounted).as_quat(), mounted.inv().apply(rates))


def apart(one, other) -> float:
    """The angle between two attitudes, rad: the angles themselves may be two ways to say one."""
    return (rotation(*one).inv() * rotation(*other)).magnitude()


@pytest.mark.parametrize("angles", MOUNTINGS.values(), ids=MOUNTINGS)
@pytest.mark.parametrize("attitude", ATTITUDES)
def test_attitude_and_rates_are_those_of_the_vehicle(attitude, angles):
    with Vehicle(nodes=WITHOUT_AHRS, instruments=[askew(angles)]) as vehicle:
        vehicle.node(NODES["ahrs"]).send(seen(attitude, angles=angles))
        heard = vehicle.read(100).ahrs
        assert (heard.fresh, heard.ok, heard.t_valid) == (True, True, pytest.approx(1.0 - LATENCY_S))
        assert apart(heard.value[:3], attitude) < 2e-3
        assert heard.value[3:] == pytest.approx(RATES, abs=1e-4)
        later = vehicle.read(101).ahrs
        assert (later.value, later.fresh) == (heard.value, False)


def test_declination_makes_its_heading_true_and_leaves_the_rest():
    with Vehicle(nodes=WITHOUT_AHRS, instruments=[askew(declination=20.0)]) as vehicle:
        vehicle.node(NODES["ahrs"]).send(seen((0.2, -0.3, 3.0)))
        value = vehicle.read(0).ahrs.value
        assert value[:3] == pytest.approx((0.2, -0.3, 3.0 + math.radians(20.0) - math.tau), abs=2e-3)
        assert value[3:] == pytest.approx(RATES, abs=1e-4)


def test_each_of_two_is_turned_by_its_own_mounting_and_one_of_nodes_by_none():
    second, third = askew(node=33, priority=2), askew(MOUNTINGS["upside down"], 34, priority=3)
    attitude = ATTITUDES[1]
    with Vehicle(instruments=[second, third]) as vehicle:
        for node, name in ((NODES["ahrs"], "straight"), (33, "askew"), (34, "upside down")):
            vehicle.node(node).send(seen(attitude, angles=MOUNTINGS[name]))
        frame = vehicle.read(0)
    for heard in (frame.ahrs, *frame.spare_ahrs):
        assert apart(heard.value[:3], attitude) < 2e-3
        assert heard.value[3:] == pytest.approx(RATES, abs=1e-4)


@pytest.mark.parametrize("name", [name for name, case in DOUBTFUL.items() if case[0] == "ahrs"])
def test_what_it_does_not_vouch_for_is_heard_and_not_ok(name):
    with Vehicle(nodes=WITHOUT_AHRS, instruments=[askew()]) as vehicle:
        vehicle.node(NODES["ahrs"]).send(DOUBTFUL[name][1]())
        heard = vehicle.read(0).ahrs
        assert (heard.fresh, heard.ok) == (True, False)


@pytest.mark.parametrize("name", [name for name, case in INFINITE.items() if case[0] == "ahrs"])
def test_infinity_is_heard_and_not_ok(name):
    _, message, _, put = INFINITE[name]
    with Vehicle(nodes=WITHOUT_AHRS, instruments=[askew()]) as vehicle:
        for can_id, data in frames(message(), NODES["ahrs"], put=put):
            vehicle.node(NODES["ahrs"]).raw(can_id, data)
        heard = vehicle.read(0).ahrs
        assert (heard.fresh, heard.ok) == (True, False)


def test_of_two_under_its_id_nothing_is_believed_however_it_is_mounted():
    with Vehicle(instruments=[askew(node=33, priority=2)]) as vehicle:
        for i in range(20):
            for shift, attitude in ((0, ATTITUDES[0]), (9, ATTITUDES[1])):
                send(vehicle, 33, seen(attitude), i + shift)
            send(vehicle, NODES["pressure"], pressure(1.2e5), i)
            frame = vehicle.read(5 * i)
    assert frame.two_senders == candidate_bit("ahrs", 1)
    assert (frame.spare_ahrs[0].ok, frame.pressure.ok) == (False, True)
