"""The bound is the textbooks', on a flight small enough to work it out another way; and it names what is hidden."""

from __future__ import annotations

import numpy as np
import pytest
from sternplane.identification.cramer_rao_bound import bound, bounds, true_states
from sternplane.sitl.busless_flight import N_TRIM, SENSOR_STD, BuslessFlight, fly, measurement_mask

from firmware_py.estimation.identifiability import unlearned
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.guidance.excitation import opposite, prbs
from firmware_py.run.usage_error import UsageError

from .cases import TEN, TRUTH, VEHICLE

H = 0.01
RATES = (5.0,) * 3 + (100.0,) * 6
BIASES = {"speed": 0.002, "rate": 1e-4, "angle": 2e-3}


def flight(steps: int, rudder: float = 0.3) -> BuslessFlight:
    sides = [(0.25 * prbs(k, 100, 9), rudder * prbs(k, 100, opposite(9))) for k in range(steps)]
    return fly(TRUTH, np.array(sides), N_TRIM, H)


def prior_of(model: ObserverModel, share: float = 0.5) -> np.ndarray:
    return np.concatenate(
        [SENSOR_STD, [0.3] * model.water, [2e-3] * len(model.biases), share * np.abs(np.array(model.believed))]
    )


def test_it_is_the_inverse_of_the_information_of_perturbed_flights() -> None:
    steps = 300
    trial, model = flight(steps), ObserverModel(VEHICLE, TEN, 2, ("u", "q"))
    prior, came = prior_of(model), measurement_mask(steps, H, RATES)
    states = true_states(model, trial.x)

    def heard(offset: np.ndarray) -> np.ndarray:
        """Every measurement that came, over its noise, of a flight that begins elsewhere."""
        x, found = states[0] + offset, []
        for k in range(steps):
            assert model.advance(x, trial.inputs[k], H)
            bias = np.zeros(9)
            bias[0], bias[4] = x[11], x[12]
            found.append(((x[:9] + bias) / SENSOR_STD)[came[k]])
        return np.concatenate(found)

    scale = 1e-3 * prior
    slopes = np.array([(heard(s) - heard(-s)) / 2.0 for s in np.diag(scale)]).T / 1e-3  # per prior sigma
    wanted = np.linalg.inv(slopes.T @ slopes + np.eye(model.size))
    got = bound(model, states, trial.inputs, H, came, SENSOR_STD, prior)[9:, 9:] / np.outer(prior[9:], prior[9:])
    np.testing.assert_allclose(got, wanted[9:, 9:], rtol=2e-3, atol=2e-3 * np.abs(wanted[9:, 9:]).max())


def test_more_measurements_never_tell_less_and_what_is_known_stays_known() -> None:
    trial, model = flight(900), ObserverModel(VEHICLE, TEN)
    prior = prior_of(model)
    prior[9:11] = 0.0
    came = measurement_mask(900, H, RATES)
    states = true_states(model, trial.x)
    found = bounds(model, states, trial.inputs, H, came, SENSOR_STD, prior, (300, 600, 900))
    sigma = np.sqrt(np.diagonal(found, axis1=1, axis2=2))
    assert (np.diff(sigma[:, model.first :], axis=0) < 0.0).all()
    assert (sigma[:, 9:11] == 0.0).all()
    np.testing.assert_array_equal(found[-1], bound(model, states, trial.inputs, H, came, SENSOR_STD, prior))


def test_a_locked_rudder_leaves_the_rudder_s_terms_unlearned_and_named() -> None:
    trial, model = flight(1500, rudder=0.0), ObserverModel(VEHICLE, TEN)
    prior = prior_of(model)
    covariance = bound(
        model, true_states(model, trial.x), trial.inputs, H, measurement_mask(1500, H, RATES), SENSOR_STD, prior
    )[model.first :, model.first :]
    hidden = unlearned(covariance, TEN, prior[model.first :])
    words = " ".join(direction.words for direction in hidden)
    for name in ("N_dr", "Y_dr"):
        assert name in words
    for name in ("M_q", "M_ds", "Z_ds"):
        assert name not in words
    moved = flight(1500)
    both = bound(
        model, true_states(model, moved.x), moved.inputs, H, measurement_mask(1500, H, RATES), SENSOR_STD, prior
    )
    assert not unlearned(both[model.first :, model.first :], TEN, prior[model.first :])


def test_without_belief_what_the_flight_is_silent_about_is_boundless() -> None:
    trial, model = flight(200, rudder=0.0), ObserverModel(VEHICLE, ("N_dr", "M_ds"), 0)
    prior = np.array([*SENSOR_STD, np.inf, np.inf])
    covariance = bound(
        model, true_states(model, trial.x), trial.inputs, H, measurement_mask(200, H, RATES), SENSOR_STD, prior
    )
    assert np.sqrt(covariance[9, 9]) > 1e6 * 0.013
    assert np.sqrt(covariance[10, 10]) < 0.1 * 0.041


def test_eddies_are_refused() -> None:
    trial, model = flight(10), ObserverModel(VEHICLE, TEN, 5)
    states = true_states(model, trial.x, (0.0,) * 5)
    with pytest.raises(UsageError, match="no process noise"):
        bound(model, states, trial.inputs, H, measurement_mask(10, H, RATES), SENSOR_STD, np.ones(model.size))
