"""Damaged fins, judged by where the plant really is: the vehicle flies on with what is left."""

from __future__ import annotations

import math

import numpy as np
from sternplane.sitl.flight import SCENARIOS
from sternplane.study.setups import vehicle
from sternplane.study.waypoints import waypoint

from firmware_py.estimation.coefficient_params import TEN
from firmware_py.records.event import Cause, EventKind
from firmware_py.records.health import ActuatorFault
from firmware_py.records.order import Mode
from tests.shared_flights import KNOWN_DEMONSTRATION, Flights
from tests.straight_run import hold, under_way

M_DS = TEN.index("M_ds")


def test_a_plane_that_jams_at_10_deg_is_opposed_and_the_flight_goes_on(flown: Flights) -> None:
    text = under_way(40.0, 10.0, hold(10.0), completes="time", faults=("jam:stern_port=10@10",), rpm=492.0)
    _, log = flown(text, seed=1001)
    c, t = log.columns, log.columns["t"]
    late = t > 25.0
    assert (c["mode.mode"][late] == Mode.HOLD).all()
    assert np.abs(log.truth["eta.z"] - c["reference.z_d"])[late].max() < 0.4
    assert np.degrees(np.median(c["applied.fins"][late, 1])) < -7.0  # it opposes the other one
    warned = [(s, e) for s, events in log.events for e in events if e.cause is Cause.DAMAGED]
    ((since, event),) = warned
    assert since < 11.3
    assert event.kind is EventKind.RULE_WARNS
    assert event.names == ("stern_port",)
    assert 0.2 < event.numbers[1] < 0.35
    assert event.numbers[2] == 1.0
    left = c["actuators.left.stuck"][-1]
    assert math.isclose(left[0], math.radians(10.0), abs_tol=math.radians(0.3))
    assert np.isnan(left[1:]).all()


def test_a_rudder_that_jams_at_20_deg_leaves_too_little_and_brings_the_vehicle_up(flown: Flights) -> None:
    text = under_way(25.0, 6.0, hold(6.0), completes="time", faults=("jam:rudder_upper=20@8",), rpm=492.0)
    _, log = flown(text, seed=1001)
    assert log.columns["mode.mode"][-1] in (Mode.SURFACE, Mode.DISARMED)
    causes = [e.cause for _, events in log.events for e in events if e.kind is EventKind.MODE_CHANGED]
    assert Cause.RUDDER_FAULT in causes


def test_half_of_the_rudder_that_is_lost_in_a_turn_is_not_taken_for_all_of_it(flown: Flights) -> None:
    """What is missing is a step then, greater at first than what a filter that is used to no rudder would see."""
    text = KNOWN_DEMONSTRATION.replace("duration_s = 330.0", "duration_s = 195.0", 1)
    faulty = text.replace('completes = "surfaced"', 'completes = "time"\nfaults = ["lost:rudder_upper@186"]', 1)
    _, log = flown(faulty, seed=1004)
    c, t = log.columns, log.columns["t"]
    weak = c["actuators.fins"][:, 2:] == ActuatorFault.WEAK
    assert 0.5 < t[weak.any(axis=1)][0] - 186.0 < 2.0
    assert not (c["actuators.fins"] == ActuatorFault.LOST).any()
    assert c["mode.mode"][-1] == Mode.MISSION


def test_planes_that_are_lost_beside_a_silent_one_bring_the_vehicle_up(flown: Flights) -> None:
    """Called sound, the one that reports let half of diving count as left, and it flew on without any, ever deeper."""
    faults = ("silent:stern_port@10", "lost:stern_port@30", "lost:stern_starboard@30")
    legs = "".join(waypoint((45.0 + 60.0 * i, 15.0 * (i % 2), 8.0 + 4.0 * (i % 2)), 1.8) for i in range(6))
    orders = '[[orders]]\nt_s = 0.5\narming = "arm"\n[[orders]]\nt_s = 1.0\nmode = "mission"\n'
    text = under_way(320.0, 6.0, orders + legs, faults=faults, rpm=492.0)
    _, log = flown(text, seed=1)
    assert Cause.PLANE_FAULT in [event.cause for _, events in log.events for event in events]
    assert log.truth["eta.z"].max() < 20.0
    assert log.truth["eta.z"][-1] < 0.6


def test_a_plane_that_is_lost_while_planes_hardly_move_is_named_once_the_half_is_learned(flown: Flights) -> None:
    """The half was learned step by step and became what sound planes do: never named, and valid 6 sigma off."""
    text = (SCENARIOS / "demo.toml").read_text().replace("duration_s = 330.0", "duration_s = 215.0", 1)
    faulty = text.replace('completes = "surfaced"', 'completes = "time"\nfaults = ["lost:stern_port@100"]', 1)
    _, log = flown(faulty)
    named = [s for s, events in log.events for event in events if event.cause is Cause.DAMAGED]
    assert 100.0 < named[0] < 180.0
    half = 0.5 * vehicle().coefficients.M_ds
    value, std, valid = [log.columns[f"state.learned.{name}"][-1, M_DS] for name in ("value", "std", "valid")]
    assert valid
    assert abs(value - half) < 3.0 * std < 0.3 * abs(half)
