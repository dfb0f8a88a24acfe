"""A trial is the plant's motion, its inputs are what the fins did, and its measurements come at their rates."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sternplane.sitl.busless_flight import N_TRIM, SENSOR_STD, fly, held_level, measure, scaled_truth

from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.guidance.excitation import opposite, prbs
from firmware_py.run.usage_error import UsageError

from .cases import TRUTH, VEHICLE

H = 0.01


def demands(steps: int, size: float = 0.25, clock: int = 150) -> np.ndarray:
    return size * np.array([(prbs(k, clock, 5), prbs(k, clock, opposite(5))) for k in range(steps)])


@pytest.mark.parametrize(("ideal", "most"), [(True, 1e-11), (False, 1e-4)])
def test_the_observer_model_under_a_trial_s_inputs_moves_as_the_vehicle_did(ideal: bool, most: float) -> None:
    trial = fly(TRUTH, demands(2000), N_TRIM, H, current=(0.2, -0.1, 0.0), ideal_fins=ideal)
    model = ObserverModel(VEHICLE, ())
    x = model.state(trial.x[0, :6].tolist(), trial.x[0, 6:].tolist())
    x[9:11] = 0.2, -0.1
    for k in range(2000):
        assert model.advance(x, trial.inputs[k], H)
        assert np.abs(x[:8] - trial.x[k + 1, :8]).max() < most


def test_inputs_are_means_of_lagging_fins_and_stay_within_their_travel() -> None:
    trial = fly(TRUTH, demands(1000, size=1.0), N_TRIM, H, ideal_fins=False)
    steps = np.abs(np.diff(trial.inputs[:, :2], axis=0))
    assert steps.max() <= TRUTH.servo.rate * H * 1.0001
    assert np.abs(trial.inputs[:, :2]).max() == pytest.approx(TRUTH.servo.limit, abs=np.radians(0.06))


def test_a_hold_keeps_a_quarter_of_an_hour_of_prbs_upright_and_in_the_sea() -> None:
    trial = fly(TRUTH, demands(18000, 0.3, 50), N_TRIM, 0.05, hold=held_level())
    assert np.abs(trial.x[:, 7]).max() < np.radians(40.0)
    assert np.abs(trial.eta[:, 2] - 100.0).max() < 30.0


def test_turbulence_follows_from_the_seed_and_is_the_water_of_each_step() -> None:
    same, again, other = (fly(TRUTH, demands(400), N_TRIM, H, seed, turbulence=0.1) for seed in (1, 1, 2))
    np.testing.assert_array_equal(same.x, again.x)
    assert np.abs(same.water - other.water).max() > 0.01
    calm = fly(TRUTH, demands(400), N_TRIM, H, current=(0.3, 0.0, 0.0))
    np.testing.assert_array_equal(calm.water, np.tile((0.3, 0.0, 0.0), (400, 1)))


def test_measurements_come_at_their_rates_with_their_noise() -> None:
    trial = fly(TRUTH, demands(6000), N_TRIM, H, hold=held_level())
    z = measure(trial, SENSOR_STD, (5.0,) * 3 + (100.0,) * 5 + (0.0,), 3)
    came = np.isfinite(z)
    assert came.sum(axis=0).tolist() == [300] * 3 + [6000] * 5 + [0]
    assert came[19, 0]
    off = (z - trial.x[1:])[:, 3:8] / SENSOR_STD[3:8]
    assert off.std(axis=0) == pytest.approx(np.ones(5), rel=0.05)
    np.testing.assert_array_equal(z, measure(trial, SENSOR_STD, (5.0,) * 3 + (100.0,) * 5 + (0.0,), 3))


def test_a_rate_that_does_not_fit_the_steps_is_refused() -> None:
    trial = fly(TRUTH, demands(10), N_TRIM, H)
    with pytest.raises(UsageError, match=r"30 Hz does not fit steps of 0\.01 s; give a rate that divides 100"):
        measure(trial, SENSOR_STD, (30.0,) * 9, 0)


def test_an_altered_vehicle_differs_in_what_was_altered_alone() -> None:
    other = scaled_truth(TRUTH, {"Y_vdot": 1.2, "C_dy": 0.8, "C_d0": 1.1})
    assert other.coefficients.Y_vdot == pytest.approx(1.2 * TRUTH.coefficients.Y_vdot)
    assert other.hull.C_dy == pytest.approx(0.8 * TRUTH.hull.C_dy)
    assert other.propeller.C_d0 == pytest.approx(1.1 * TRUTH.propeller.C_d0)
    back = scaled_truth(other, {"Y_vdot": 1 / 1.2, "C_dy": 1 / 0.8, "C_d0": 1 / 1.1})
    assert dataclasses.asdict(back)["coefficients"] == pytest.approx(dataclasses.asdict(TRUTH)["coefficients"])
