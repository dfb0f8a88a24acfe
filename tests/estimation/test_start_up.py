"""How a bank begins, how it keeps its members alive, and what it does when it is lost."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.sitl.busless_flight import SENSOR_STD, measure
from sternplane.study.setups import Setup, fly_prbs

from firmware_py.estimation.coefficient_ekf import RESET_AGAIN_TIME, CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.consistency import COUNT, NIS_COUNT_MIN, NIS_DIVERGED, SUM, diverged
from firmware_py.estimation.filter.kernel_arguments import Settings, Tuning
from firmware_py.estimation.filter.start_up import schedule
from firmware_py.estimation.filter.weighting import NEIGHBOUR_REPLACED_BELOW, REPLACED_BELOW, replace_unlikely

from .cases import VEHICLE

FIRST, WIDTH = 11, 16
WAIT, FADE = 5.0, 10.0
SETTINGS = Settings(10.0, 60.0, 5.0, WAIT, FADE)


def tuning() -> Tuning:
    """Motion, two states of water, and five coefficients of which the last only is considered."""
    made = Tuning(*np.zeros((len(Tuning._fields), WIDTH)))
    made.Q_final[:6], made.Q_final[FIRST:] = 1e-8, 1e-9
    made.Q_startup[:6] = 1e-4
    made.may_learn[:], made.may_learn[-1] = 1.0, 0.0
    return made


@given(st.floats(0.0, WAIT, exclude_max=True))
def test_during_the_learning_delay_no_coefficient_learns(age: float) -> None:
    table, clock = tuning(), np.array([age])
    schedule(table, clock, FIRST, 0.01, SETTINGS)
    assert table.learns[:FIRST].all()
    assert not table.learns[FIRST:].any()
    np.testing.assert_array_equal(table.Q[:6], 1e-8)
    assert not table.Q[FIRST:].any()
    assert clock[0] == age + 0.01


@given(st.floats(WAIT, 100.0))
def test_then_start_up_noise_fades(age: float) -> None:
    table, clock = tuning(), np.array([age])
    schedule(table, clock, FIRST, 0.01, SETTINGS)
    np.testing.assert_array_equal(table.learns[FIRST:], [1, 1, 1, 1, 0])
    expected = 1e-8 + 1e-4 * math.exp(-(age - WAIT) / FADE) ** 2
    np.testing.assert_allclose(table.Q[:6], expected, rtol=1e-12)
    np.testing.assert_array_equal(table.Q[FIRST:], [1e-9] * 4 + [0.0])


@given(st.floats(0.0, 100.0))
def test_start_up_noise_of_eddies_is_there_from_the_start_and_fades_too(age: float) -> None:
    table, clock = tuning(), np.array([age])
    table.Q_eddy_startup[:6] = 1e-2
    schedule(table, clock, FIRST, 0.01, SETTINGS)
    np.testing.assert_allclose(table.Q_eddy[:6], 1e-2 * math.exp(-2.0 * max(age - WAIT, 0.0) / FADE), rtol=1e-12)
    assert not table.Q_eddy[6:].any()


def test_start_up_noise_of_eddies_is_that_of_the_filter_that_assumes_them() -> None:
    trial, spreads = fly_prbs(Setup(duration=1.0), 0), []
    z = measure(trial, SENSOR_STD, Setup().rates, 0)
    for noise in (0.0, 1.0):
        ekf = CoefficientEkf(
            VEHICLE, CoefficientParams(turbulence=(0.0, 0.05), learning_delay=5.0, eddy_speed_noise=noise)
        )
        ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
        ekf.run(0.01, trial.inputs, z, SENSOR_STD**2)
        spreads.append(ekf.P[:, 1, 1].copy())
    (calm, eddying), (calm_noisy, eddying_noisy) = spreads
    assert calm_noisy == pytest.approx(calm, rel=1e-2)
    assert eddying_noisy > 1.2 * eddying


def test_start_up_noise_does_not_fade_while_none_may_learn() -> None:
    table, clock = tuning(), np.array([WAIT + 1.0])
    table.may_learn[FIRST:] = 0.0
    for _ in range(100):
        schedule(table, clock, FIRST, 0.01, SETTINGS)
    assert clock[0] == WAIT + 1.0
    assert table.Q[0] > 1e-8


def test_a_filter_far_behind_becomes_a_copy_of_the_most_likely_and_neighbours_stay_for_longer() -> None:
    rng = np.random.default_rng(1)
    filters = CoefficientEkf(VEHICLE, CoefficientParams(turbulence=(0.0, 0.02, 0.05, 0.1, 0.2))).bank.kernel
    filters.x[:], filters.P[:] = rng.standard_normal(filters.x.shape), rng.standard_normal(filters.P.shape)
    far, near = REPLACED_BELOW, NEIGHBOUR_REPLACED_BELOW
    filters.log_likelihood[:] = -3.0 - np.array([1.01 * far, 0.99 * near, 0.0, 1.01 * near, 0.99 * far])
    before = filters.x.copy(), filters.P.copy()
    replace_unlikely(filters)
    np.testing.assert_array_equal(filters.x, before[0][[2, 1, 2, 2, 4]])
    np.testing.assert_array_equal(filters.P, before[1][[2, 1, 2, 2, 4]])
    np.testing.assert_array_equal(
        filters.log_likelihood, -3.0 - np.array([0.5 * far, 0.99 * near, 0.0, 0.5 * near, 0.99 * far])
    )


@pytest.mark.parametrize("sensor", range(3))
def test_a_sensor_that_contradicts_for_long_enough_is_divergence(sensor: int) -> None:
    window = np.zeros((3, 3))
    window[:, COUNT], window[:, SUM] = 2.0 * NIS_COUNT_MIN, 2.0 * NIS_COUNT_MIN
    assert not diverged(window)
    window[sensor, SUM] = 1.01 * NIS_DIVERGED * window[sensor, COUNT]
    assert diverged(window)
    window[sensor] *= 0.49
    assert not diverged(window)


def test_a_filter_whose_current_changes_is_reset_and_keeps_what_it_learned() -> None:
    """The vehicle comes into another current at half time: what was sure is wrong, but the vehicle is the same."""
    first, second = Setup(duration=40.0, current=0.2), Setup(duration=40.0, current=0.6)
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(std=0.5, learning_delay=5.0))
    seen = []
    for seed, setup in ((0, first), (1, second)):
        trial = fly_prbs(setup, seed)
        z = measure(trial, SENSOR_STD, setup.rates, seed)
        if not seen:
            ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
        else:  # the old water is believed in: nobody tells of the new one
            ekf.resume(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
        ekf.run(setup.h, trial.inputs, z, SENSOR_STD**2)
        seen.append((ekf.resets, ekf.estimate(), setup.drift(seed)[:2]))
    (none, _, _), (some, told, drift) = seen
    assert none == 0
    assert some == 1
    np.testing.assert_allclose(told.current, drift, atol=0.02)
    off = told.values / np.array(ekf.model.believed) - 1.0
    assert np.abs(off).max() < 0.1


def test_diverged_again_at_once_its_coefficients_are_reset_too() -> None:
    setup = Setup(duration=20.0)
    trial = fly_prbs(setup, 3)
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(std=0.5))
    ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
    ekf.run(setup.h, trial.inputs, measure(trial, SENSOR_STD, setup.rates, 3), SENSOR_STD**2)
    known, prior = ekf.estimate().std, ekf.prior[ekf.model.first :]
    assert (known < 0.5 * prior).all()
    wild = np.array([1.8, 0, 0, 0, 0, 0, 0, 0, 0.0])
    spins = [0.4 * (-1) ** (k // 60) for k in range(round(RESET_AGAIN_TIME / setup.h))]
    for spin in spins:
        wild[3:6] = spin
        ekf.step(trial.inputs[0], setup.h, wild, SENSOR_STD**2)
        if ekf.resets == 2:
            break
    assert ekf.resets == 2
    np.testing.assert_allclose(ekf.estimate().std, prior, rtol=0.05)
