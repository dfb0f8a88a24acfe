"""Motion and water smoothed: what is known afterwards, against the truth and against least squares over all at once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.sitl.busless_flight import SENSOR_STD, measure
from sternplane.study.setups import Setup, fly_prbs

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.measurement_history import new_history, record
from firmware_py.estimation.iteration.rts_smoother import SMOOTHED, divide, factored, smooth
from firmware_py.estimation.iteration.smoother_pass import BLOCK, RING, SmootherPass
from firmware_py.estimation.model.state import EDDY_NORTH

from .cases import VEHICLE

STATES = 12
EDDYING = Setup(duration=10.0, turbulence=0.05)


@given(st.integers(0, 2**32 - 1))
def test_division_is_by_the_whole_matrix(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root, right = rng.normal(size=(STATES, STATES)), rng.normal(size=(STATES, STATES))
    C = root @ root.T + 0.1 * np.eye(STATES)
    L, G = C.copy(), right.copy()
    assert factored(L)
    divide(L, G)
    np.testing.assert_allclose(C @ G, right, atol=1e-9 * np.linalg.cond(C))


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan])
def test_what_has_no_inverse_is_said_to_have_none(wrong: float) -> None:
    C = np.eye(STATES)
    C[5, 5] = wrong
    assert not factored(C)


@given(st.integers(0, 2**32 - 1))
def test_it_finds_what_least_squares_over_all_rows_at_once_finds(seed: int) -> None:
    """A linear system of twelve states, measured at every row with noise; P, F, Q and R as they come."""
    rng = np.random.default_rng(seed)
    rows = 6
    F = np.eye(STATES) + 0.2 * rng.normal(size=(STATES, STATES))
    root = rng.normal(size=(STATES, STATES))
    Q, P = 0.1 * root @ root.T + 0.1 * np.eye(STATES), np.eye(STATES)
    z = 0.1 * rng.normal(size=(rows, STATES))  # so small that no angle turns over

    filtered, predicted = np.zeros((rows, STATES)), np.zeros((rows, STATES))
    gains, x = np.zeros((rows, STATES, STATES)), np.zeros(STATES)
    A, b = [np.eye(STATES, STATES * (rows + 1))], [np.zeros(STATES)]
    weight = np.linalg.cholesky(np.linalg.inv(Q)).T
    for k in range(rows):
        filtered[k] = x
        after = F @ P @ F.T + Q
        L, gains[k] = after.copy(), F @ P
        assert factored(L)
        divide(L, gains[k])
        predicted[k] = x = F @ x
        S = after + np.eye(STATES)
        x, P = x + after @ np.linalg.solve(S, z[k] - x), after - after @ np.linalg.solve(S, after)
        step, seen = np.zeros((STATES, STATES * (rows + 1))), np.zeros((STATES, STATES * (rows + 1)))
        step[:, STATES * k : STATES * (k + 1)], step[:, STATES * (k + 1) : STATES * (k + 2)] = -weight @ F, weight
        seen[:, STATES * (k + 1) : STATES * (k + 2)] = np.eye(STATES)
        A += [step, seen]
        b += [np.zeros(STATES), z[k]]
    whole = np.linalg.lstsq(np.concatenate(A), np.concatenate(b), rcond=None)[0].reshape(rows + 1, STATES)
    end = np.zeros(20)
    end[:9], end[EDDY_NORTH : EDDY_NORTH + 3] = x[:9], x[9:]
    path = np.zeros((rows, STATES))
    smooth(end, 0, rows, filtered, predicted, gains, np.zeros(STATES), path)
    np.testing.assert_allclose(path, whole[:-1], atol=1e-6)


def test_afterwards_the_eddies_are_known_better_than_at_the_moment() -> None:
    trial = fly_prbs(EDDYING, 0)
    z = measure(trial, SENSOR_STD, EDDYING.rates, 0)
    params = CoefficientParams(turbulence=(0.05,))
    ekf, filters = CoefficientEkf(VEHICLE, params), BankArrays(VEHICLE, params)
    ekf.start(trial.x[0, :6], trial.x[0, 6:], SENSOR_STD)
    filters.take(*ekf.bank.copy())
    filters.tuning.learns[:] = filters.tuning.may_learn
    history = new_history(len(z))
    for k, (u, heard) in enumerate(zip(trial.inputs, z, strict=True)):
        record(history, k, EDDYING.h, u, heard, SENSOR_STD**2)
    smoother = SmootherPass(filters)
    smoother.start(filters.x[0].copy(), 0)
    first, now = [], []
    while smoother.smoothed_to < len(z):
        begin = smoother.smoothed_to
        while smoother.row < min(smoother.row_max, len(z)):
            assert smoother.run(history, min(smoother.row + 8, len(z)))
            now.append((smoother.row, smoother.bank.x[0, EDDY_NORTH : EDDY_NORTH + 3].copy()))
        smoother.smooth_back(whole=smoother.row == len(z))
        first += [(k, smoother.path[k % RING, 9:].copy()) for k in range(begin, smoother.smoothed_to)]
    assert smoother.path.shape == (3 * BLOCK, SMOOTHED)

    def error(said: list[tuple[int, np.ndarray]]) -> float:
        return float(np.sqrt(np.mean([(e - trial.water[k - 1]) ** 2 for k, e in said if k > 100])))

    assert error(first) < 0.65 * error(now) < 0.65 * 0.05
