"""The iterated filter: slopes about one motion, the Cramer-Rao bound, and never a bit of chance."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from scipy.stats import chi2
from sternplane.sitl.busless_flight import SENSOR_STD, BuslessFlight, measure
from sternplane.study.setups import FilterRun, Setup, bound_std, fly_prbs, flying, run_filter, starts

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.kernel_arguments import Tuning
from firmware_py.estimation.iteration.iterated_filter import LAST, PATIENCE, ROWS_PER_STEP
from firmware_py.estimation.iteration.relinearised_pass import move_with_reference
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import EDDIES
from firmware_py.params import ParamError

from .cases import VEHICLE, WIDE, case, seeds, state

CURRENT = Setup(duration=40.0, current=0.2)
SEEDS = range(12)
SURE = flying(turbulence=(0.0,))
SOON = dataclasses.replace(SURE, learning_delay=0.5, iteration_times=(2.0, 5.0))
NOW = Setup(duration=16.0, current=0.2)


@given(seeds)
def test_a_state_beside_another_follows_as_the_model_would_take_it(seed: int) -> None:
    model, at, rng = ObserverModel(VEHICLE, WIDE, EDDIES), case(seed), np.random.default_rng(seed)
    about = state(model, at)
    size = np.array([0.1] * 6 + [0.05] * 3 + [0.1] * 5 + [*(np.abs(model.believed) * 0.1)])
    deviation = 1e-4 * size * rng.standard_normal(model.size)
    beside, there = about + deviation, about.copy()
    assert model.advance(beside, at.inputs, 0.01)
    assert model.advance(there, at.inputs, 0.01)
    x = np.zeros(model.size)
    move_with_reference(model.arrays, model.linearisation, there, deviation, x)
    moved = np.abs(beside[:9] - there[:9]).max()
    assert np.abs(x[:9] - beside[:9]).max() < 1e-3 * moved


def learned(seed: int, params: CoefficientParams) -> tuple[FilterRun, BuslessFlight, CoefficientEkf]:
    flight, ekf = fly_prbs(CURRENT, seed), CoefficientEkf(VEHICLE, params)
    return run_filter(CURRENT, flight, ekf, seed, starts(seed, 0.5)), flight, ekf


def test_after_an_iteration_the_filter_stands_at_the_bound_and_knows_it() -> None:
    runs = [learned(seed, SURE) for seed in SEEDS]
    assert all(ekf.iteration.accepted for _, _, ekf in runs)
    squares = sum(run.nees[-1, 0] for run, _, _ in runs)
    low, high = chi2.ppf((0.0005, 0.9995), 10 * len(SEEDS))
    assert low < squares < high
    for seed, (run, flight, ekf) in zip(SEEDS, runs[:3], strict=False):
        limit = bound_std(CURRENT, flight, ekf, seed, run.t[-1:])[0]
        np.testing.assert_allclose(run.std[-1] / limit, 1.0, atol=0.05)


def test_without_an_iteration_it_does_not_reach_the_bound() -> None:
    run, flight, ekf = learned(0, dataclasses.replace(SURE, iteration_times=()))
    limit = bound_std(CURRENT, flight, ekf, 0, run.t[-1:])[0]
    assert (run.std[-1] / limit).max() > 1.2


def given_to(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    trial = fly_prbs(NOW, seed)
    return trial.x[0], trial.inputs, measure(trial, SENSOR_STD, NOW.rates, seed)


def started(x: np.ndarray, params: CoefficientParams = SOON) -> CoefficientEkf:
    ekf = CoefficientEkf(VEHICLE, params)
    ekf.start(x[:6], x[6:], SENSOR_STD, {"M_q": 1.3 * VEHICLE.coefficients.M_q})
    return ekf


def bits(ekf: CoefficientEkf) -> bytes:
    return ekf.x.tobytes() + ekf.P.tobytes() + ekf.log_likelihood.tobytes() + ekf.age.tobytes()


def test_a_run_is_the_same_to_the_last_bit_however_it_is_cut() -> None:
    x, inputs, z = given_to(1)
    whole, parts, calls = started(x), started(x), started(x)
    whole.run(NOW.h, inputs, z, SENSOR_STD**2)
    for k in range(0, len(inputs), 37):
        parts.run(NOW.h, inputs[k : k + 37], z[k : k + 37], SENSOR_STD**2)
    for u, heard in zip(inputs, z, strict=True):
        assert calls.step(u, NOW.h, heard, SENSOR_STD**2)
    assert whole.iteration.accepted
    assert bits(whole) == bits(parts) == bits(calls)


def test_steps_before_a_divergence_are_in_the_history_however_they_were_cut() -> None:
    x, inputs, z = given_to(1)
    z[70:130, 3:6] += 0.3  # the gyros contradict the filter
    whole, calls = (started(x, dataclasses.replace(SOON, iteration_times=(10.0,))) for _ in range(2))
    whole.run(NOW.h, inputs[:200], z[:200], SENSOR_STD**2)
    for u, heard in zip(inputs[:200], z[:200], strict=True):
        assert calls.step(u, NOW.h, heard, SENSOR_STD**2)
    assert whole.resets
    assert whole.iteration.used == calls.iteration.used == 200
    np.testing.assert_array_equal(whole.iteration.history.z[:200], z[:200])
    assert bits(whole) == bits(calls)


def test_other_parameters_reach_the_passes_too() -> None:
    x, inputs, z = given_to(2)
    before, after = started(x), started(x, dataclasses.replace(SOON, surge_noise=0.05, bound=2.0))
    made = [array.copy() for array in after.banks[1].tuning]
    before.run(NOW.h, inputs[:230], z[:230], SENSOR_STD**2)
    after.thaw(before.freeze())
    for name in ("Q_final", "lower", "upper"):
        place = Tuning._fields.index(name)
        np.testing.assert_array_equal(after.banks[1].tuning[place], made[place])
        assert (made[place] != before.banks[1].tuning[place]).any()


def test_it_is_taken_up_again_in_the_middle() -> None:
    x, inputs, z = given_to(2)
    one, other = started(x), started(x)
    one.run(NOW.h, inputs[:230], z[:230], SENSOR_STD**2)
    other.thaw(one.freeze())
    for ekf in (one, other):
        ekf.run(NOW.h, inputs[230:], z[230:], SENSOR_STD**2)
    assert one.iteration.accepted == other.iteration.accepted >= 1
    assert bits(one) == bits(other)


def test_it_takes_over_when_the_history_has_been_gone_through() -> None:
    x, inputs, z = given_to(3)
    ekf = started(x)
    steps = 0
    while not ekf.iteration.accepted:
        ekf.step(inputs[steps], NOW.h, z[steps], SENSOR_STD**2)
        steps += 1
    rows = (
        2.0 / NOW.h * (ROWS_PER_STEP / (ROWS_PER_STEP - 1)) ** (LAST + 1)
    )  # gone through at least once a stage, growing meanwhile
    assert rows < steps < 2.0 * rows
    assert ekf.iteration.used == steps


def test_a_reset_of_motion_is_in_the_history() -> None:
    x, inputs, z = given_to(4)
    ekf = started(x)
    ekf.run(NOW.h, inputs[:150], z[:150], SENSOR_STD**2)
    later = fly_prbs(NOW, 4).x[300]
    ekf.resume(later[:6], later[6:], SENSOR_STD)
    ekf.run(NOW.h, inputs[300:], z[300:], SENSOR_STD**2)
    assert ekf.iteration.accepted
    assert not ekf.resets
    told = ekf.estimate()
    off = (told.values - np.array(ekf.model.believed)) / told.std
    assert off @ off / 10.0 < 3.0


def test_without_anything_to_learn_the_history_begins_again_and_again() -> None:
    x, inputs, z = given_to(5)
    ekf = started(x)
    ekf.permit(np.zeros(10, dtype=np.bool_))
    ekf.run(NOW.h, inputs, z, SENSOR_STD**2)
    assert ekf.iteration.used <= (SOON.learning_delay + PATIENCE) / NOW.h + 1
    assert not ekf.iteration.accepted
    np.testing.assert_array_equal(ekf.estimate().values[1:], ekf.model.believed[1:])


def test_what_is_only_considered_stays_as_believed() -> None:
    x, inputs, z = given_to(6)
    ekf = started(x, dataclasses.replace(SOON, considered=("K_p", "M_w", "N_rdot")))
    ekf.run(NOW.h, inputs, z, SENSOR_STD**2)
    assert ekf.iteration.accepted
    believed = dict(zip(ekf.model.names, ekf.model.believed, strict=True))
    for name in ("K_p", "M_w", "N_rdot"):
        assert ekf.x[0, ekf.model.place(name)] == believed[name]


def test_an_iteration_that_becomes_non_finite_changes_nothing() -> None:
    x, inputs, z = given_to(7)
    ekf, alone = started(x), started(x, dataclasses.replace(SOON, iteration_times=()))
    ekf.run(NOW.h, inputs[:100], z[:100], SENSOR_STD**2)
    ekf.iteration.history.inputs[50, 0] = math.nan
    ekf.run(NOW.h, inputs[100:400], z[100:400], SENSOR_STD**2)
    alone.run(NOW.h, inputs[:400], z[:400], SENSOR_STD**2)
    assert not ekf.iteration.accepted
    assert bits(ekf) == bits(alone)


@pytest.mark.parametrize("times", [(20.0, 10.0), (10.0, 10.0)])
def test_lengths_that_do_not_rise_are_refused(times: tuple[float, ...]) -> None:
    with pytest.raises(ParamError, match="do not rise"):
        CoefficientParams(iteration_times=times)
