"""Whole flights with fixed seeds, judged by where the vehicle really went."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sternplane.logs.summary import summarise
from sternplane.sitl.flight import Outcome

from firmware_py.records.command import AscentStage
from firmware_py.records.order import Mode
from tests.shared_flights import Flights, demonstration, without_learning
from tests.straight_run import hold, under_way


@pytest.mark.parametrize(("seed", "waypoints", "ends"), [(1, 5, (270.0, 330.0)), (2, 3, (185.0, 245.0))])
def test_the_demonstration_dives_passes_its_waypoints_surfaces_and_disarms(
    flown: Flights, seed: int, waypoints: int, ends: tuple[float, float]
) -> None:
    outcome, log = flown(demonstration(waypoints), seed)
    c, truth, summary = log.columns, log.truth, summarise(log)
    assert outcome == Outcome(True, "completed")
    assert summary["waypoints_passed"] == summary["waypoints_total"] == waypoints
    assert ends[0] < c["t"][-1] < ends[1]
    assert truth["eta.z"].max() == pytest.approx(10.0, abs=0.3)
    assert truth["eta.z"][-1] < 0.5
    mission = c["mode.mode"] == Mode.MISSION
    depth_error = (c["reference.z_d"] - truth["eta.z"])[mission]
    assert np.sqrt(np.mean(depth_error**2)) < 0.06
    for x, y, z, _ in log.header["mission"]["waypoints"][:-1]:  # the path goes by every corner, on the inside
        distance = np.hypot(truth["eta.x"] - x, truth["eta.y"] - y)
        assert distance.min() < 10.0
        assert truth["eta.z"][distance.argmin()] == pytest.approx(z, abs=0.8)
    away = np.hypot(c["state.eta.x"] - truth["eta.x"], c["state.eta.y"] - truth["eta.y"])
    assert np.mean(away < 2.5 * c["state.position_std"]) > 0.95
    assert c["mode.mode"][-1] == Mode.DISARMED
    assert not c["applied.fins"][-1].any()
    assert c["applied.n"][-1] == 0.0


def settled(t: np.ndarray, error: np.ndarray, begin: float, width: float) -> float:
    """How long after `begin` the error was last larger than `width`."""
    outside = np.flatnonzero((np.abs(error) > width) & (t >= begin) & (t < begin + 49.0))
    return float(t[outside[-1]] - begin)


def test_the_papers_depth_gains_settle_a_step_of_a_metre_in_20_seconds_without_overshoot(flown: Flights) -> None:
    _, log = flown(without_learning("paper-depth"))
    t, z = log.columns["t"], log.truth["eta.z"]
    for begin, target, way in ((20.0, 11.0, 1.0), (70.0, 10.0, -1.0)):
        after = (t >= begin) & (t < begin + 49.0)
        assert settled(t, z - target, begin, 0.05) == pytest.approx(20.0, abs=1.5)
        assert np.max(way * (z - target)[after]) < 0.01
    s = log.columns["demand.delta_s"]
    assert np.abs(s).max() <= math.radians(23.0)


def test_the_papers_heading_gains_reach_a_path_a_metre_to_the_side_in_17_seconds(flown: Flights) -> None:
    _, log = flown(without_learning("paper-heading"))
    c, y = log.columns, log.truth["eta.y"]
    first, *_, last = np.flatnonzero(np.diff(c["reference.waypoint"])) + 1
    for begin, target, way in ((c["t"][first], 1.0, 1.0), (c["t"][last], 0.0, -1.0)):
        after = (c["t"] >= begin) & (c["t"] < begin + 49.0)
        assert settled(c["t"], y - target, begin, 0.05) == pytest.approx(17.0, abs=1.5)
        assert np.max(way * (y - target)[after]) < 0.05


def test_the_turning_circle_to_starboard_is_a_circle(flown: Flights) -> None:
    _, log = flown(without_learning("turning-circle"))
    t, psi = log.columns["t"], np.unwrap(log.truth["eta.psi"])
    steady = t > 100.0
    rate = np.diff(psi[steady]) / 0.01
    assert np.std(rate) < 0.02 * np.mean(rate)
    assert np.mean(rate) > math.radians(3.0)
    assert psi[-1] > 1.5 * math.tau
    assert log.columns["applied.fins"][steady][:, 2:].mean() < 0.0  # to port of centre: it turns to starboard


def test_the_zigzag_puts_its_rudder_over_at_20_degrees_each_time(flown: Flights) -> None:
    _, log = flown(without_learning("zigzag").replace("duration_s = 150.0", "duration_s = 90.0"))
    c = log.columns
    rudder, psi = c["order.sticks.delta_r"], np.degrees(np.unwrap(c["state.eta.psi"]))
    moving = np.flatnonzero(np.diff(rudder))
    base = psi[moving[0]]
    executes = psi[moving[1:]] - base
    assert len(executes) >= 4
    assert np.all(np.abs(np.abs(executes) - 20.0) < 0.5)
    assert np.all(np.sign(executes[1:]) == -np.sign(executes[:-1]))


def struck(start: float, depth: float, bottom: float = 60.0, *faults: str, completes: str = "surfaced") -> str:
    """Something breaks in the middle of a straight run."""
    duration = 150.0 if completes == "surfaced" else 60.0
    return under_way(duration, start, hold(depth), completes=completes, faults=faults, bottom=bottom, rpm=492.0)


@pytest.mark.parametrize(
    ("start", "depth", "bottom", "faults", "cause"),
    [
        (8.0, 8.0, 60.0, ["off:pressure@20"], "depth"),
        (22.0, 35.0, 60.0, [], "depth"),
        (16.0, 25.0, 26.0, [], "altitude"),
    ],
)
def test_what_the_first_rules_find_brings_the_vehicle_up_by_itself(
    flown: Flights, start: float, depth: float, bottom: float, faults: list[str], cause: str
) -> None:
    outcome, log = flown(struck(start, depth, bottom, *faults))
    assert not outcome.completed  # it came up, but nobody had meant it to
    assert outcome.surfaced
    assert outcome.reason.startswith("surfaced safely")
    assert cause in outcome.reason
    assert log.columns["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6
    assert log.truth["eta.z"].max() < min(depth, 30.0) + 2.5
    assert (bottom - log.truth["eta.z"]).min() > 1.0


def test_an_ahrs_that_falls_silent_does_not_keep_the_vehicle_down(flown: Flights) -> None:
    outcome, log = flown(struck(8.0, 8.0, 60.0, "off:ahrs@20"))
    c = log.columns
    assert outcome.reason.startswith("surfaced safely because of a rule: no good attitude")
    blind = c["mode.ascent"] == AscentStage.BLIND
    assert blind.any()
    assert (c["demand.delta_s"][blind] < 0.0).all()
    assert not c["demand.delta_r"][blind].any()
    assert c["mode.mode"][-1] == Mode.DISARMED
    assert log.truth["eta.z"][-1] < 0.6
    assert log.truth["eta.z"].max() < 11.0


def test_the_pid_baseline_flies_to_the_waypoints_of_the_demonstration_too(flown: Flights) -> None:
    outcome, log = flown(demonstration(2) + '\n[autopilot.control]\nlaw = "pid"\n')
    assert outcome.completed
    assert summarise(log)["depth_tracking_error_rms_m"] < 0.1


@pytest.mark.parametrize("rate", [50, 200])
def test_another_base_rate_flies_as_well(flown: Flights, rate: int) -> None:
    outcome, log = flown(f"{struck(8.0, 6.0, completes='time')}\n[autopilot]\nrate_hz = {rate}\n")
    assert outcome.completed, outcome.reason
    assert len(log.cycle_bytes) == 60 * rate
    assert log.truth["eta.z"][-1] == pytest.approx(6.0, abs=0.2)
