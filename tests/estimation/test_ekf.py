"""The filter's kernels are a Kalman filter: beside dense matrices, Joseph's form and Schmidt's gain, in numpy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.bench.ekf import STD, H, flight

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.kernel_arguments import BATCH, UpdateRows, new_scratch, padded
from firmware_py.estimation.filter.measurement_update import update_covariance, update_state
from firmware_py.estimation.filter.time_update import propagate
from firmware_py.estimation.model.kernel_arguments import ForceTerms, Model, grouped, new_linearisation
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import CURRENT, EDDIES, EQUATIONS, MOVING, STILL, WATER

from .cases import VEHICLE

seeds = st.integers(0, 2**32 - 1)
Matrix = np.ndarray


def covariance(rng: np.random.Generator, n: int) -> Matrix:
    """Positive definite, symmetric, padded with zeros."""
    root = rng.standard_normal((n, n))
    P = np.zeros((n, padded(n)))
    P[:, :n] = root @ root.T + 0.1 * np.eye(n)
    P[:, :n] = 0.5 * (P[:, :n] + P[:, :n].T)
    return P


def empty(width: int) -> UpdateRows:
    return UpdateRows(np.zeros((BATCH, width)), np.zeros((BATCH, width)))


def dense(x: Matrix, P: Matrix, H_i: Matrix, innovation: float, variance: float, learns: Matrix) -> float:
    """One measurement in Joseph's form, in place, with the gain of considered states struck out; its NIS."""
    S = float(H_i @ P @ H_i + variance)
    K = P @ H_i / S * learns
    A = np.eye(len(x)) - np.outer(K, H_i)
    P[:] = A @ P @ A.T + variance * np.outer(K, K)
    x += K * innovation
    return innovation**2 / S


# --- kernels ---------------------------------------------------------------------------------------------------------


@given(seeds, st.sampled_from([STILL, CURRENT, EDDIES]), st.integers(0, 3), st.integers(0, 14))
def test_a_covariance_is_propagated_as_by_dense_matrices(seed: int, water: int, biases: int, parameters: int) -> None:
    rng = np.random.default_rng(seed)
    first = MOVING + water + biases
    n = first + parameters
    P, step = covariance(rng, n), new_linearisation(20)
    step.Phi[:], step.response[:] = rng.standard_normal((9, 16)), rng.standard_normal((9, 16))
    step.regressors[:] = rng.standard_normal(20)
    count = 2 * parameters  # some make two forces, some none
    terms = ForceTerms(
        parameter=rng.integers(0, max(parameters, 1), count),
        regressor=rng.integers(0, 20, count),
        equation=rng.integers(0, EQUATIONS, count),
        constant=np.zeros(count, dtype=np.int64),
        weight=rng.standard_normal(count),
    )

    full = np.eye(n)
    full[:MOVING, :MOVING] = step.Phi[:, :MOVING]
    for d in range(water):
        full[:MOVING, MOVING + d] = step.Phi[:, WATER + (d if d < 2 else d - 2)]
    for parameter, regressor, equation, _, weight in zip(*terms, strict=True):
        full[:MOVING, first + parameter] += weight * step.regressors[regressor] * step.response[:, equation]
    wanted = full @ P[:, :n] @ full.T

    propagate(
        P, Model(np.zeros(1), np.eye(6), terms, grouped(terms), water, first, False), step, new_scratch(padded(n))
    )
    np.testing.assert_allclose(P[:, :n], wanted, rtol=1e-11, atol=1e-12 * np.abs(wanted).max())
    np.testing.assert_array_equal(P[:, :n], P[:, :n].T)
    assert not P[:, n:].any()


@given(seeds, st.integers(13, 30), st.booleans())
def test_a_batch_of_updates_is_that_of_dense_matrices_one_by_one(seed: int, n: int, outlier: bool) -> None:
    rng = np.random.default_rng(seed)
    width = padded(n)
    P, x, rows = covariance(rng, n), np.zeros(width), empty(width)
    x[:n] = rng.standard_normal(n)
    learns = np.ones(width)
    learns[rng.integers(10, n) : n] = 0.0  # what is measured learns, and so do sensors' biases
    x_2, P_2 = x[:n].copy(), P[:, :n].copy()
    for slot in range(BATCH):
        i, bias, variance = int(rng.integers(0, 8)), int(rng.choice((-1, 8, 9))), rng.uniform(0.01, 2.0)
        seen = np.eye(n)[i] + (np.eye(n)[bias] if bias >= 0 else 0.0)
        innovation = 100.0 * math.sqrt(seen @ P_2 @ seen + variance) if outlier and slot == 1 else rng.normal()
        size = seen @ P_2 @ seen + variance
        nis, S, accepted = update_state(x, P, learns, i, bias, innovation, variance, 5.0, slot, rows)
        assert (nis, S) == pytest.approx((innovation**2 / size, size), rel=1e-9)
        assert accepted == (nis <= 25.0)
        if accepted:
            dense(x_2, P_2, seen, innovation, variance, learns[:n])
    update_covariance(P, learns, rows)
    np.testing.assert_allclose(x[:n], x_2, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(P[:, :n], P_2, rtol=1e-8, atol=1e-9 * np.abs(P_2).max())
    np.testing.assert_array_equal(P[:, :n], P[:, :n].T)
    assert not P[:, n:].any()
    assert not np.any(rows), "the next batch begins with nothing"


def test_a_rejected_measurement_changes_nothing() -> None:
    rng = np.random.default_rng(3)
    P, x, rows = covariance(rng, 14), np.zeros(16), empty(16)
    before = P.copy()
    for bad in (math.nan, math.inf, 1e9):
        _, _, accepted = update_state(x, P, np.ones(16), 2, -1, bad, 0.1, 5.0, 0, rows)
        assert not accepted
        update_covariance(P, np.ones(16), rows)
    np.testing.assert_array_equal(P, before)
    assert not x.any()


# --- the whole step --------------------------------------------------------------------------------------------------

SETUPS = {
    "still": CoefficientParams(current=False),
    "current": CoefficientParams(walk=0.01),
    "eddies": CoefficientParams(turbulence=(0.05,)),
    "considered": CoefficientParams(considered=("rest",), names=("M_q", "N_r", "M_dot")),
    "biased": CoefficientParams(
        turbulence=(0.05,), rate_bias=1e-3, angle_bias=0.02, speed_bias=0.02, considered=("Z_w",)
    ),
}


class Dense:
    """One filter of a bank, with dense matrices."""

    def __init__(self, ekf: CoefficientEkf) -> None:
        m = ekf.model
        self.Q, self.learns = ekf.tuning.Q[: m.size], ekf.tuning.learns[: m.size]
        self.params, self.intensity = ekf.params, ekf.intensity[0]
        names = (*"uvwpqr", "phi", "theta", "psi")
        self.model = ObserverModel(VEHICLE, m.names, m.water, tuple(names[i] for i in m.biases))
        self.seen = np.eye(MOVING, m.size)
        for k, i in enumerate(m.biases):
            self.seen[i, MOVING + m.water + k] = 1.0
        self.x, self.P = ekf.x[0].copy(), ekf.P[0].copy()

    def predict(self, inputs: Matrix) -> None:
        n, m = self.model.size, self.model
        full, keep = np.eye(n), math.exp(-H / self.params.turbulence_time)
        assert m.advance(self.x, inputs, H)
        full[:MOVING] = m.transition()
        decay, noise = np.ones(n), H * self.Q
        if m.water == EDDIES:
            decay[11:14] = keep
            noise[11:14] += (1.0 - keep**2) * self.intensity**2
        self.x *= decay
        self.P = np.diag(decay) @ (full @ self.P @ full.T) @ np.diag(decay) + np.diag(noise)

    def update(self, z: Matrix, variance: Matrix) -> Matrix:
        nis = np.full(MOVING, math.nan)
        for i in np.flatnonzero(~np.isnan(z)):
            nis[i] = dense(self.x, self.P, self.seen[i], z[i] - self.seen[i] @ self.x, variance[i], self.learns)
        return nis


def made(params: CoefficientParams) -> CoefficientEkf:
    ekf = CoefficientEkf(VEHICLE, params)
    ekf.start((1.8, 0.01, 0, 0, 0, 0), (0, 0, 0.01), STD * 3.0, {"M_q": 1.2 * ekf.model.believed[0]})
    return ekf


@pytest.mark.parametrize("params", SETUPS.values(), ids=SETUPS)
def test_steps_are_those_of_a_kalman_filter_with_dense_matrices(params: CoefficientParams) -> None:
    ekf = made(params)
    twin, (inputs, z) = Dense(ekf), flight(ekf.model, 40)
    rng = np.random.default_rng(5)
    z[rng.random(z.shape) < 0.3] = np.nan
    for row, heard in zip(inputs, z, strict=True):
        assert ekf.step(row, H, heard, STD**2)
        twin.predict(row)
        np.testing.assert_allclose(ekf.nis, twin.update(heard, STD**2), rtol=1e-6, atol=1e-8)
        np.testing.assert_array_equal(ekf.P[0], ekf.P[0].T)
    scale = np.sqrt(np.diag(twin.P))
    assert np.abs((ekf.x[0] - twin.x) / scale).max() < 1e-7
    assert np.abs((ekf.P[0] - twin.P) / np.outer(scale, scale)).max() < 1e-7
    taught = ekf.model.first + len(params.names)
    np.testing.assert_array_equal(ekf.x[0, taught:], ekf.model.believed[len(params.names) :])
    np.testing.assert_allclose(np.diag(ekf.P[0])[taught:], ekf.prior[taught:] ** 2, rtol=1e-12)
