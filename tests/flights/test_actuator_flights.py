"""Faults of actuators in flight: each is named in its time, counted from when the plant has it, and no other is."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from sternplane.logs import reading
from sternplane.sitl.flight import FlightRequest, fly, prepare
from sternplane.study.safety.mission import scenario

from firmware_py.records.event import EventKind
from firmware_py.records.health import ActuatorFault
from sim_bridge.faults import effects
from sim_bridge.faults.target import Effect, FaultTarget, Strike
from tests.straight_run import hold, mission, under_way

FINS = ("stern_port", "stern_starboard", "rudder_upper", "rudder_lower")
Named = dict[str, list[tuple[float, ActuatorFault]]]


def flight(
    folder: Path,
    faults: list[str],
    duration: float,
    eddies: float = 0.1,
    seed: int = 1000,
    orders: str = "",
    current: tuple[float, float] = (0.0, 0.0),
):
    """Return what was named, by actuator, and the truth."""
    orders = orders or hold(10.0, heading=None)
    file, log = folder / "scenario.toml", folder / "log.mcap"
    file.write_text(under_way(duration, 10.0, orders, bottom=45.0, eddies=eddies, current=current))
    fly(prepare(FlightRequest(scenario=str(file), faults=tuple(faults), seed=seed), {}), log)
    flown = reading.read(log)
    named: Named = {}
    for t, events in flown.events:
        for event in events:
            if event.kind in (EventKind.ACTUATOR_FAULT, EventKind.ACTUATOR_GOOD):
                named.setdefault(event.names[0], []).append((t, ActuatorFault(int(event.numbers[0]))))
    return named, flown.truth


def test_with_feedback_every_actuator_is_named_within_a_second(tmp_path: Path) -> None:
    faults = ["jam:stern_port=10@5", "hard-over:rudder_upper@9", "silent:rudder_lower@12", "stuck:propeller@15"]
    named, truth = flight(tmp_path, faults, 18.0)
    jammed = truth["t"] > 6.0
    assert truth["fins"][jammed, 0] == pytest.approx(math.radians(10.0), abs=math.radians(0.3))
    expected = {
        "stern_port": (5.0, ActuatorFault.JAMMED, 1.0),
        "rudder_upper": (9.0, ActuatorFault.HARD_OVER, 1.0),
        "rudder_lower": (12.0, ActuatorFault.SILENT, 1.1),
        "propeller": (15.0, ActuatorFault.JAMMED, 1.0),
    }
    assert set(named) == set(expected)
    for name, (begun, fault, limit) in expected.items():
        (t, first), *others = named[name]
        assert (first, others) == (fault, [])
        assert begun < t <= begun + limit, name


def test_with_fins_too_slow_to_steer_with_it_comes_up_before_it_swings_deeper_and_deeper(tmp_path: Path) -> None:
    """At 2.5 deg/s the depth law and the fins swing against each other: down to 34.9 m, where 28 m was ordered."""
    file, log = tmp_path / "scenario.toml", tmp_path / "log.mcap"
    file.write_text(scenario([f"slow:{fin}=2.5@20" for fin in FINS], eddies=0.1))
    outcome = fly(prepare(FlightRequest(scenario=str(file), seed=1), {}), log)
    flown = reading.read(log)
    assert flown.truth["eta.z"].max() < 15.0
    assert flown.truth["eta.z"][-1] < 0.5
    assert "too slow to steer with" in outcome.reason


@pytest.mark.parametrize("seed", [1000, 1001])
def test_both_planes_jammed_without_feedback_are_named_by_their_consequence_within_15_s(
    tmp_path: Path, seed: int
) -> None:
    faults = ["silent:servo_hub@3", "jam:stern_port=10@10", "jam:stern_starboard=10@10"]
    named, truth = flight(tmp_path, faults, 25.0, seed=seed)
    assert truth["fins"][-1, :2] == pytest.approx(math.radians(10.0), abs=math.radians(0.3))
    for fin in FINS[:2]:
        (_, silent), (t, fault) = named[fin]
        assert (silent, fault) == (ActuatorFault.SILENT, ActuatorFault.JAMMED)
        assert 10.0 < t <= 25.0
    assert all([fault for _, fault in named[fin]] == [ActuatorFault.SILENT] for fin in FINS[2:])
    assert "propeller" not in named


def test_a_propeller_that_lost_its_thrust_is_named_within_half_a_minute(tmp_path: Path) -> None:
    named, truth = flight(tmp_path, ["lost:propeller@10"], 40.0, eddies=0.05)
    ((t, fault),) = named.pop("propeller")
    assert (named, fault) == ({}, ActuatorFault.LOST)
    assert 10.0 < t <= 40.0
    assert truth["nu.u"][truth["t"] < t][-1] < 1.5  # what is done about it follows


def test_a_propeller_that_runs_away_unreported_is_named_by_the_speed_it_makes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full_ahead(run: FaultTarget, _: Strike) -> Callable[[], None]:
        run.shaft_override = 1000.0 / 60.0
        return lambda: None

    monkeypatch.setitem(effects.EFFECTS, ("stuck", "propeller"), Effect(full_ahead))
    named, truth = flight(tmp_path, ["silent:esc@3", "stuck:propeller@10"], 60.0)
    (_, silent), (t, fault) = named.pop("propeller")
    assert (named, silent, fault) == ({}, ActuatorFault.SILENT, ActuatorFault.RUNAWAY)
    assert 10.0 < t < 28.0
    assert truth["eta.z"][-1] < 3.0  # it comes up


@pytest.mark.parametrize("current", [(0.0, 1.0), (0.7, -0.7), (-1.0, 0.0)])
def test_sound_fins_and_a_sound_propeller_are_not_named_in_a_strong_current(
    tmp_path: Path, current: tuple[float, float]
) -> None:
    ahead = mission([(60.0, 10.0), (120.0, 10.0)])
    named, truth = flight(tmp_path, [], 12.0, orders=ahead, current=current)
    assert named == {}
    assert truth["nu.u"][-1] > 1.3
