"""An instrument that is mounted at angles measures what one that sits straight would."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.drivers.driver import Reading
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.marine import body_to_ned, ned_to_body
from firmware_py.records.sensing import Ahrs, Dvl, Fix, Heard

turns = st.floats(-3.1, 3.1)
tilts = st.floats(-1.3, 1.3)
rates = st.floats(-2.0, 2.0)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def reading(role, value):
    return Reading(role, 2, Heard(value, 1.5, True, False))


def same_attitude(one, other):
    """The same axes in north, east, down: the angles themselves may be two ways to say it."""
    for axis in AXES:
        assert body_to_ned(*one, *axis) == pytest.approx(body_to_ned(*other, *axis), abs=1e-7)


@given(turns, tilts, turns, turns, tilts, turns, rates, rates, rates)
def test_attitude_and_rates_are_those_of_the_body(roll, pitch, yaw, phi, theta, psi, p, q, r):
    """By vectors: each axis of the instrument is the body's axis that the mounting says, in the world."""
    turn = Mounting(roll, pitch, yaw).turn()
    turned = turn(reading("ahrs", Ahrs(phi, theta, psi, p, q, r)))
    body = turned.heard.value
    for axis in AXES:
        in_body = body_to_ned(roll, pitch, yaw, *axis)
        there = body_to_ned(*body[:3], *in_body)
        assert there == pytest.approx(body_to_ned(phi, theta, psi, *axis), abs=1e-7)
    assert ned_to_body(roll, pitch, yaw, *body[3:]) == pytest.approx((p, q, r), abs=1e-9)
    assert (turned.role, turned.number) == ("ahrs", 2)
    assert (turned.heard.t_valid, turned.heard.fresh, turned.heard.ok) == (1.5, True, False)


def test_an_ahrs_upside_down_and_turned_to_port_is_seen_upright():
    """Roll 180: its z looks up, its y to port."""
    upside = Mounting(roll=math.pi).turn()(reading("ahrs", Ahrs(math.pi, 0.1, 0.3, 0.1, 0.2, 0.3))).heard.value
    same_attitude(upside[:3], (0.0, 0.1, 0.3))
    assert upside[3:] == pytest.approx((0.1, -0.2, -0.3))
    aside = Mounting(yaw=-math.pi / 2).turn()(reading("ahrs", Ahrs(0.0, 0.0, 0.3, 0.1, 0.0, 0.0))).heard.value
    same_attitude(aside[:3], (0.0, 0.0, 0.3 + math.pi / 2))
    assert aside[3:] == pytest.approx((0.0, -0.1, 0.0))


def test_a_dvl_turned_45_degrees_has_its_velocity_turned_and_its_distance_left():
    turned = Mounting(yaw=math.radians(45.0)).turn()(reading("dvl", Dvl(1.0, 0.0, 0.2, 0.01, 12.0))).heard.value
    assert turned == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0.2, 0.01, 12.0))


@pytest.mark.parametrize("mounting", [Mounting(declination=0.2), Mounting(yaw=0.1, declination=0.1)])
def test_declination_makes_the_heading_true_and_turns_nothing_else(mounting):
    psi = 3.1 + mounting.yaw
    turned = mounting.turn()(reading("ahrs", Ahrs(0.0, 0.0, psi, 0.0, 0.0, 0.0))).heard.value
    assert turned.psi == pytest.approx(3.1 + mounting.declination - math.tau)
    assert turned[:2] == pytest.approx((0.0, 0.0))


@pytest.mark.parametrize("role", ["pressure", "altitude", "fix"])
def test_what_has_no_axes_is_left_as_it_is(role):
    one = reading(role, Fix(0.1, 0.2, 3.0) if role == "fix" else 7.0)
    assert Mounting(0.1, 0.2, 0.3).turn()(one) is one


def test_what_sits_straight_is_left_as_it_is():
    one = reading("ahrs", Ahrs(0.1, 0.2, 0.3, 0.4, 0.5, 0.6))
    assert STRAIGHT.turn()(one) is one


def test_what_is_unknown_stays_unknown():
    nan = math.nan
    value = Mounting(0.1, 0.2, 0.3).turn()(reading("ahrs", Ahrs(nan, nan, nan, 0.1, nan, 0.2))).heard.value
    assert all(map(math.isnan, value[:3]))
