"""The bank: probabilities follow Bayes' rule, and the filter that assumes the right eddies wins."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal
from sternplane.bench.ekf import DVL_EVERY, STD, FilterInputs, H, begun, flight

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.measurement_update import wrapped
from firmware_py.estimation.filter.weighting import weigh
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import EDDIES

from .cases import VEHICLE

INTENSITIES = (0.0, 0.01, 0.02, 0.04, 0.08)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=7))
def test_weights_are_the_filters_likelihoods_and_sum_to_one(logs: list[float]) -> None:
    log_likelihood, weights = np.array(logs), np.zeros(len(logs))
    best = weigh(log_likelihood, weights)
    assert math.fsum(weights) == pytest.approx(1.0, abs=1e-12)
    assert log_likelihood[best] == log_likelihood.max()
    np.testing.assert_allclose(weights / weights[best], np.exp(log_likelihood - log_likelihood.max()), rtol=1e-12)


@given(st.floats(-100.0, 100.0))
def test_an_angle_is_wrapped_to_one_that_points_the_same_way(angle: float) -> None:
    got = wrapped(angle)
    assert -math.pi <= got < math.pi
    assert math.cos(got - angle) == pytest.approx(1.0)
    assert math.sin(got - angle) == pytest.approx(0.0, abs=1e-12)
    assert wrapped(got) == got


def test_a_step_adds_the_log_likelihood_of_all_that_was_measured() -> None:
    params = CoefficientParams(rate_bias=1e-3, speed_bias=0.02, turbulence=(0.05,))
    ekf, before = begun(params), begun(params)
    inputs, variance = np.array([0.1, -0.1, 0.0, 8.0]), STD**2
    assert before.step(inputs, H, np.full(9, np.nan), variance)
    assert before.log_likelihood[0] == 0.0
    x, P, n = before.x[0], before.P[0], before.model.size
    seen = np.eye(9, n)
    for k, i in enumerate(before.model.biases):
        seen[i, 9 + EDDIES + k] = 1.0
    z = seen @ x + 2.0 * STD * np.random.default_rng(4).standard_normal(9)
    for heard in (np.arange(9), np.array([3, 4, 5, 7]), np.array([0])):
        ekf = begun(params)
        partly = np.full(9, np.nan)
        partly[heard] = z[heard]
        assert ekf.step(inputs, H, partly, variance)
        expected = multivariate_normal.logpdf(
            z[heard], seen[heard] @ x, seen[heard] @ P @ seen[heard].T + np.diag(variance[heard])
        )
        assert ekf.log_likelihood[0] - 0.5 * len(heard) * math.log(math.tau) == pytest.approx(expected, rel=1e-9)


def test_log_likelihood_fades_with_the_memory() -> None:
    ekf = begun(CoefficientParams(likelihood_memory=10.0))
    ekf.log_likelihood[0] = -5.0
    for _ in range(1000):
        ekf.step(np.array([0.0, 0.0, 0.0, 8.0]), H, np.full(9, np.nan), STD**2)
    assert ekf.log_likelihood[0] == pytest.approx(-5.0 * math.exp(-1.0))


def through_eddies(intensity: float, steps: int, seed: int) -> FilterInputs:
    """As `flight`, but in eddies, an Ornstein-Uhlenbeck process of 10 s on each axis."""
    rng = np.random.default_rng(seed)
    model = ObserverModel(VEHICLE, ("M_q",), EDDIES)
    inputs, z = flight(model, steps, seed)
    x, keep = model.state((1.8, 0, 0, 0, 0, 0), (0, 0, 0)), math.exp(-H / 10.0)
    x[9:11], x[11:14] = (0.2, -0.1), intensity * rng.standard_normal(3)
    for k in range(steps):
        assert model.advance(x, inputs[k], H)
        x[11:14] = keep * x[11:14] + math.sqrt(1.0 - keep**2) * intensity * rng.standard_normal(3)
        z[k] = x[:9] + STD * rng.standard_normal(9)
    z[:, 6:9:2] = (z[:, 6:9:2] + math.pi) % math.tau - math.pi
    z[np.arange(steps) % DVL_EVERY != 0, :3] = np.nan
    return FilterInputs(inputs, z)


def after_a_minute(intensity: float, seed: int) -> CoefficientEkf:
    """The bank after a minute in such eddies, with one coefficient to learn, known to 5 %.

    So little, because this is about the choice between filters: with the ten, from 70 %, a filter's coefficients at
    times diverge, and with them its likelihood.
    """
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(names=("M_q",), std=0.05, turbulence=INTENSITIES))
    ekf.start((1.8, 0, 0, 0, 0, 0), (0, 0, 0), STD * 3.0)
    inputs, z = through_eddies(intensity, 6000, seed)
    history = ekf.run(H, inputs, z, STD**2, every=100)
    assert history.steps == len(inputs)
    np.testing.assert_allclose(history.weights.sum(axis=1), 1.0, rtol=1e-12)
    return ekf


@pytest.mark.parametrize("right", range(1, len(INTENSITIES)))
def test_the_filter_with_the_right_intensity_wins(right: int) -> None:
    winners = [int(np.argmax(after_a_minute(INTENSITIES[right], seed).log_likelihood)) for seed in range(5)]
    assert winners == [right] * 5


def test_in_steady_water_the_bank_finds_next_to_no_eddies() -> None:
    assert max(after_a_minute(0.0, seed).estimate().turbulence for seed in range(3)) < 0.01
