"""How a bank begins, how it keeps its members alive, and what it does when it is lost."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.sitl.busless_flight import SENSOR_STD, measure
from sternplane.study.setups import Setup, flown

from firmware_py.estimation.coefficient_ekf import SOON, CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.consistency import COUNT, SUM
from firmware_py.estimation.filter.start_up import (
    BEGINNING,
    ENOUGH,
    FLOOR,
    GROWTH,
    HOPELESS,
    LEARNS,
    LOST,
    MAY,
    RULES,
    STIRRED,
    STIRS,
    lost,
    revive,
    settle,
)

from .cases import VEHICLE

FIRST, WIDTH = 11, 16
WAIT, FADE = 5.0, 10.0


def rules() -> np.ndarray:
    """Motion, two states of water, and five coefficients of which the last only is considered."""
    made = np.zeros((RULES, WIDTH))
    made[FLOOR, :6], made[FLOOR, FIRST:] = 1e-8, 1e-9
    made[BEGINNING, :6] = 1e-4
    made[MAY], made[MAY, -1] = 1.0, 0.0
    return made


@given(st.floats(0.0, WAIT, exclude_max=True))
def test_at_first_the_water_is_found_and_nothing_is_learned(age: float) -> None:
    table, clock = rules(), np.array([age])
    settle(table, clock, FIRST, 0.01, WAIT, FADE)
    assert table[LEARNS, :FIRST].all()
    assert not table[LEARNS, FIRST:].any()
    np.testing.assert_array_equal(table[GROWTH, :6], 1e-8)
    assert not table[GROWTH, FIRST:].any()
    assert clock[0] == age + 0.01


@given(st.floats(WAIT, 100.0))
def test_then_doubt_about_slopes_fades_as_they_are_learned(age: float) -> None:
    table, clock = rules(), np.array([age])
    settle(table, clock, FIRST, 0.01, WAIT, FADE)
    np.testing.assert_array_equal(table[LEARNS, FIRST:], [1, 1, 1, 1, 0])
    expected = 1e-8 + 1e-4 * math.exp(-(age - WAIT) / FADE) ** 2
    np.testing.assert_allclose(table[GROWTH, :6], expected, rtol=1e-12)
    np.testing.assert_array_equal(table[GROWTH, FIRST:], [1e-9] * 4 + [0.0])


@given(st.floats(0.0, 100.0))
def test_what_wavering_water_stirs_up_is_there_from_the_start_and_fades_with_the_doubt(age: float) -> None:
    table, clock = rules(), np.array([age])
    table[STIRRED, :6] = 1e-2
    settle(table, clock, FIRST, 0.01, WAIT, FADE)
    np.testing.assert_allclose(table[STIRS, :6], 1e-2 * math.exp(-2.0 * max(age - WAIT, 0.0) / FADE), rtol=1e-12)
    assert not table[STIRS, 6:].any()


def test_of_two_members_the_one_that_reckons_with_eddies_is_stirred() -> None:
    trial, spreads = flown(Setup(duration=1.0), 0), []
    z = measure(trial, SENSOR_STD, Setup().rates, 0)
    for stirred in (0.0, 1.0):
        ekf = CoefficientEkf(VEHICLE, CoefficientParams(turbulence=(0.0, 0.05), wait=5.0, speed_stirred=stirred))
        ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
        ekf.run(0.01, trial.inputs, z, SENSOR_STD**2)
        spreads.append(ekf.P[:, 1, 1].copy())
    (calm, wavering), (calm_stirred, wavering_stirred) = spreads
    assert calm_stirred == pytest.approx(calm, rel=1e-2)
    assert wavering_stirred > 1.2 * wavering


def test_doubt_does_not_fade_while_none_may_learn() -> None:
    table, clock = rules(), np.array([WAIT + 1.0])
    table[MAY, FIRST:] = 0.0
    for _ in range(100):
        settle(table, clock, FIRST, 0.01, WAIT, FADE)
    assert clock[0] == WAIT + 1.0
    assert table[GROWTH, 0] > 1e-8


def test_a_member_without_hope_becomes_the_likeliest_and_the_others_stay() -> None:
    rng = np.random.default_rng(1)
    x, P = rng.standard_normal((3, 8)), rng.standard_normal((3, 6, 8))
    evidence = np.array([-3.0 - 1.01 * HOPELESS, -3.0 - 0.99 * HOPELESS, -3.0])
    before = x.copy(), P.copy()
    revive(x, P, evidence)
    np.testing.assert_array_equal(x, before[0][[2, 1, 2]])
    np.testing.assert_array_equal(P, before[1][[2, 1, 2]])
    np.testing.assert_array_equal(evidence, [-3.0 - 0.5 * HOPELESS, -3.0 - 0.99 * HOPELESS, -3.0])


@pytest.mark.parametrize("sensor", range(3))
def test_a_sensor_that_contradicts_for_long_enough_is_no_chance(sensor: int) -> None:
    window = np.zeros((3, 3))
    window[:, COUNT], window[:, SUM] = 2.0 * ENOUGH, 2.0 * ENOUGH
    assert not lost(window)
    window[sensor, SUM] = 1.01 * LOST * window[sensor, COUNT]
    assert lost(window)
    window[sensor] *= 0.49
    assert not lost(window)


def test_a_filter_whose_current_turns_round_begins_anew_and_keeps_what_it_learned() -> None:
    """The boat comes into another stream at half time: what was sure is wrong, but the boat is the same."""
    first, second = Setup(duration=40.0, current=0.2), Setup(duration=40.0, current=0.6)
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(std=0.5, wait=5.0))
    seen = []
    for seed, setup in ((0, first), (1, second)):
        trial = flown(setup, seed)
        z = measure(trial, SENSOR_STD, setup.rates, seed)
        if not seen:
            ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
        else:  # the old water is believed in: nobody tells of the new one
            ekf.resume(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
        ekf.run(setup.h, trial.inputs, z, SENSOR_STD**2)
        seen.append((ekf.restarts, ekf.estimate(), setup.drift(seed)[:2]))
    (none, _, _), (some, told, drift) = seen
    assert none == 0
    assert some == 1
    np.testing.assert_allclose(told.current, drift, atol=0.02)
    off = told.values / np.array(ekf.model.believed) - 1.0
    assert np.abs(off).max() < 0.1


def test_lost_again_at_once_it_doubts_its_coefficients_too() -> None:
    setup = Setup(duration=20.0)
    trial = flown(setup, 3)
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(std=0.5))
    ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
    ekf.run(setup.h, trial.inputs, measure(trial, SENSOR_STD, setup.rates, 3), SENSOR_STD**2)
    known, prior = ekf.estimate().std, ekf.prior[ekf.model.first :]
    assert (known < 0.5 * prior).all()
    wild = np.array([1.8, 0, 0, 0, 0, 0, 0, 0, 0.0])
    spins = [0.4 * (-1) ** (k // 60) for k in range(round(SOON / setup.h))]
    for spin in spins:
        wild[3:6] = spin
        ekf.step(trial.inputs[0], setup.h, wild, SENSOR_STD**2)
        if ekf.restarts == 2:
            break
    assert ekf.restarts == 2
    np.testing.assert_allclose(ekf.estimate().std, prior, rtol=0.05)
