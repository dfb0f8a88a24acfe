"""Servos, fins and shaft against the differential equations that they stand for."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from firmware_py.marine import Eta, Nu
from sim_bridge.plant.actuators import lag, play
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.plant import Plant

from .plants import TRUTH

DEG = math.pi / 180.0


def new_plant(dt: float = 0.01, substeps: int = 1, **servo: float) -> Plant:
    truth = dataclasses.replace(TRUTH, servo=dataclasses.replace(TRUTH.servo, **servo))
    environment = Environment(EnvironmentParams(), 0, dt)
    return Plant(truth, environment, dt, substeps, Eta(0.0, 0.0, 50.0, 0.0, 0.0, 0.0), Nu(1.5, 0.0, 0.0, 0.0, 0.0, 0.0))


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.02, 1.0), st.floats(0.05, 5.0), st.floats(0.001, 2.0))
def test_the_lag_solves_its_equation(value: float, target: float, tau: float, rate: float, dt: float) -> None:
    def slope(_: float, y: list[float]) -> float:
        return min(max((target - y[0]) / tau, -rate), rate)

    reached = solve_ivp(slope, (0.0, dt), [value], rtol=1e-9, atol=1e-11, max_step=tau / 4.0).y[0, -1]
    assert lag(value, target, tau, rate, dt) == pytest.approx(reached, abs=1e-5)


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.001, 1.0), st.integers(2, 50))
def test_the_lag_does_not_care_how_time_is_cut(value: float, target: float, dt: float, cuts: int) -> None:
    whole = lag(value, target, 0.1, 0.7, dt)
    for _ in range(cuts):
        value = lag(value, target, 0.1, 0.7, dt / cuts)
    assert value == pytest.approx(whole, abs=1e-12)


def test_a_small_step_reaches_63_percent_in_one_time_constant() -> None:
    plant = new_plant(tau=0.1, rate=1e3, backlash=0.0)
    for _ in range(10):
        plant.step((0.02, 0.0, 0.0, 0.0), 0.0)
    assert plant.fins[0] == pytest.approx(0.02 * (1.0 - math.exp(-1.0)), rel=1e-12)
    assert plant.fins[1:] == (0.0, 0.0, 0.0)


def test_a_large_step_slews_at_the_rate_limit_and_stops_at_the_travel() -> None:
    plant = new_plant(tau=0.05, rate=40.0 * DEG, backlash=0.0)
    angles = []
    for _ in range(300):
        plant.step((1.0, -1.0, 0.0, 0.0), 0.0)
        angles.append(plant.fins[0])
    steps = [b - a for a, b in zip([0.0, *angles], angles, strict=False)]
    assert max(steps) == pytest.approx(0.4 * DEG, rel=1e-12)
    assert steps[:30] == pytest.approx([0.4 * DEG] * 30, rel=1e-12)
    assert max(angles) <= 23.0 * DEG
    assert angles[-1] == pytest.approx(23.0 * DEG, rel=1e-9)
    assert plant.fins[1] == pytest.approx(-23.0 * DEG, rel=1e-9)


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30), st.floats(0.0, 0.5))
def test_the_fin_follows_within_the_play_and_moves_only_when_pushed(leaders: list[float], half: float) -> None:
    fin = leaders[0]
    for leader in leaders:
        before, fin = fin, play(fin, leader, half)
        assert abs(fin - leader) <= half + 1e-12
        assert fin == before or abs(fin - leader) == pytest.approx(half, abs=1e-12)


def test_backlash_leaves_the_fin_behind_by_half_the_play_on_either_side() -> None:
    plant = new_plant(tau=0.02, rate=1e3, backlash=0.4 * DEG)
    for target, expected in ((5.0, 4.8), (4.7, 4.8), (4.0, 4.2), (5.0, 4.8)):
        for _ in range(100):
            plant.step((target * DEG,) * 4, 0.0)
        assert plant.fins == pytest.approx((expected * DEG,) * 4, abs=1e-9)


def test_the_shaft_lags_is_limited_in_acceleration_and_saturates_both_ways() -> None:
    shaft = TRUTH.shaft
    for way in (1.0, -1.0):
        plant = new_plant()
        plant.step((0.0,) * 4, way * 1e3)
        assert plant.n == pytest.approx(way * shaft.rate * 0.01, rel=1e-12)
        assert plant.n_dot == pytest.approx(way * shaft.rate, rel=1e-12)
        for _ in range(1000):
            plant.step((0.0,) * 4, way * 1e3)
        assert plant.n == pytest.approx(way * 1000.0 / 60.0, rel=1e-6)
        assert plant.n_dot == pytest.approx(0.0, abs=1e-3)
    small = new_plant()
    for _ in range(round(shaft.tau / 0.01)):
        small.step((0.0,) * 4, 0.1)
    assert small.n == pytest.approx(0.1 * (1.0 - math.exp(-1.0)), rel=1e-9)


def test_actuators_arrive_at_the_same_place_whatever_the_substep() -> None:
    coarse, fine = new_plant(substeps=1), new_plant(substeps=8)
    for k in range(200):
        command = tuple(0.3 * math.sin(0.05 * k + i) for i in range(4))
        coarse.step(command, 8.0)
        fine.step(command, 8.0)
    assert coarse.fins == pytest.approx(fine.fins, abs=1e-12)
    assert coarse.n == pytest.approx(fine.n, abs=1e-12)


def test_a_jammed_fin_stays_and_works_again_when_freed() -> None:
    plant = new_plant()
    for _ in range(50):
        plant.step((0.1,) * 4, 0.0)
    held = plant.fins[2]
    plant.jam(2)
    for _ in range(50):
        plant.step((-0.1,) * 4, 0.0)
    assert plant.fins[2] == held
    assert plant.fins[3] < 0.0
    plant.jam(2, jammed=False)
    for _ in range(200):
        plant.step((-0.1,) * 4, 0.0)
    assert plant.fins[2] == pytest.approx(plant.fins[3], abs=1e-9)
