"""The third layout: every fin of an X steers both planes, also with one that is stuck."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from sternplane.sitl.flight import SCENARIOS

from firmware_py.adapters.installation import configs
from firmware_py.config_files import read_configuration
from firmware_py.config_files import vehicle as vehicle_of
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.records.event import Cause
from firmware_py.records.health import ActuatorFault, SourceState
from tests.shared_flights import Flights
from tests.straight_run import hold, under_way

X = "torpedo_x"
NAMES = ("upper_port", "upper_starboard", "lower_starboard", "lower_port")


def turned_and_dived(flown: Flights, *faults: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """True depth, m, and heading, deg, over time, and the fins that were commanded, rad, of a dive into a turn."""
    outcome, log = flown(under_way(24.0, 10.0, hold(12.0, 40.0), faults=faults, rpm=1753.0), vehicle=X)
    assert outcome.completed
    return log.truth["eta.z"], np.degrees(log.truth["eta.psi"]), log.columns["applied.fins"]


def test_four_fins_dive_and_turn_at_once(flown: Flights) -> None:
    z, psi, fins = turned_and_dived(flown)
    assert z[-300:] == pytest.approx(12.0, abs=0.15)
    assert psi[-300:] == pytest.approx(40.0, abs=2.0)
    assert (np.abs(fins[100:]).max(axis=0) > np.radians(0.5)).all()  # none of them is idle


def test_a_stuck_fin_of_an_x_is_opposed_by_the_three_others(flown: Flights) -> None:
    z, psi, fins = turned_and_dived(flown, "jam:upper_port=8@4")
    assert z[-300:] == pytest.approx(12.0, abs=0.3)
    assert psi[-300:] == pytest.approx(40.0, abs=3.0)
    believed = vehicle_of(read_configuration(configs() / X))
    assert tuple(fin.name for fin in believed.fins) == NAMES
    s, r = believed.effectiveness.s, believed.effectiveness.r
    others = fins[-300:].mean(axis=0) * np.array([0.0, 1.0, 1.0, 1.0])
    stuck = np.radians(8.0)
    assert abs(np.dot(s, others) + s[0] * stuck) < 0.4 * abs(s[0] * stuck)
    assert abs(np.dot(r, others) + r[0] * stuck) < 0.4 * abs(r[0] * stuck)


def test_an_x_that_lost_a_fin_dives_and_turns_with_the_three_others(flown: Flights) -> None:
    """A lost fin still reports that it moves. It is not named yet: lost at once, before anything is known of it."""
    z, psi, fins = turned_and_dived(flown, "lost:upper_port@4")
    assert z[-300:] == pytest.approx(12.0, abs=0.15)
    assert psi[-300:] == pytest.approx(40.0, abs=3.0)
    assert np.abs(fins).max() < np.radians(19.9)  # it is not steered at its limits


@pytest.mark.parametrize(("fin", "lost_at", "seed"), [(0, 110.0, 1), (3, 60.0, 5)])
def test_an_x_that_lost_a_fin_learns_on_and_nothing_sound_is_blamed_for_it(
    flown: Flights, fin: int, lost_at: float, seed: int
) -> None:
    """Its planes turn it then: the heading was not believed for that, and N_v was called valid 59 sigma off.

    The fin that rests is at 0.05 deg and makes no force: by that angle the other three were called weak.
    """
    text = (SCENARIOS / "demo.toml").read_text().replace("duration_s = 330.0", "duration_s = 180.0", 1)
    fault = f'completes = "time"\nfaults = ["lost:{NAMES[fin]}@{lost_at}"]'
    _, log = flown(text.replace('completes = "surfaced"', fault, 1), vehicle=X, seed=seed)
    (named, *_) = [s for s, events in log.events for event in events if event.cause is Cause.DAMAGED]
    c, t = log.columns, log.columns["t"]
    after = t > named
    assert named < lost_at + 35.0  # it is lost on a leg: the next turn tells
    found = c["actuators.fins"][-1].tolist()
    assert found.pop(fin) in (ActuatorFault.LOST, ActuatorFault.WEAK)
    assert not any(found)
    valid, value, std = (c[f"state.learned.{name}"] for name in ("valid", "value", "std"))
    assert valid[t < named].any()
    assert valid[-1].sum() >= 5
    built = asdict(vehicle_of(read_configuration(configs() / X)).coefficients)
    right = np.array([built.get(name, 1.0) for name in TEN])
    off = np.abs(value - right) / std
    assert (off[after][valid[after].astype(bool)] > 4.0).mean() <= 0.01
    assert (c["state.sensors.ahrs.state"] == SourceState.GOOD).all()
    assert np.abs(log.truth["eta.z"] - c["reference.z_d"])[after].max() < 0.25


def test_an_x_with_one_fin_hard_over_comes_up_in_a_circle(flown: Flights) -> None:
    """Its heading law took away what pitch there was: the bow went down by 20 deg, and the propeller stopped."""
    text = under_way(
        120.0,
        20.0,
        hold(20.0),
        completes="surfaced",
        faults=("jam:upper_port=20@4",),
        bottom=60.0,
        rpm=1753.0,
    )
    outcome, log = flown(text, vehicle=X)
    assert outcome.surfaced
    assert log.truth["eta.z"].max() < 21.0
    assert np.ptp(np.unwrap(log.truth["eta.psi"])) > np.radians(360.0)
    assert not log.columns["mode.drop"].any()
