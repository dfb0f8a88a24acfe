"""What must hold however long the filter runs: P stays a covariance, nothing is allocated, bad numbers are told."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from sternplane.bench.ekf import CASES, STD, FilterInputs, H, begun, flight

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter import bank
from firmware_py.estimation.filter.kernel_arguments import padded

LONG = 100_000


@pytest.fixture(scope="module")
def long_flight() -> FilterInputs:
    """1000 s, seen without noise."""
    return flight(begun(CASES["21 states"]).model, LONG, noise=0.0)


@pytest.mark.parametrize("share", [1.0, 1e-4], ids=["noisy", "as good as noise-free"])
@pytest.mark.parametrize("name", CASES)
def test_a_covariance_stays_one_for_1e5_steps(name: str, share: float, long_flight: FilterInputs) -> None:
    ekf, std = begun(CASES[name]), share * STD
    z = long_flight.z + std * np.random.default_rng(2).standard_normal(long_flight.z.shape)
    steps = LONG if len(ekf.intensity) == 1 else LONG // 5
    history = ekf.run(H, long_flight.inputs[:steps], z[:steps], std**2, every=steps)
    assert history.steps == steps
    for P in ekf.P:
        np.testing.assert_array_equal(P, P.T)
        scale = np.sqrt(np.diag(P))
        assert np.linalg.eigvalsh(P / np.outer(scale, scale))[0] > 1e-9
    assert not ekf.bank.kernel.x[:, ekf.model.size :].any()
    assert not ekf.bank.kernel.P[:, :, ekf.model.size :].any()
    assert ekf.bank.kernel.P.shape[2] == padded(ekf.model.size)


def test_runs_are_the_same_to_the_last_bit_however_they_are_cut(long_flight: FilterInputs) -> None:
    inputs, z = long_flight.inputs[:400], long_flight.z[:400]
    whole, parts, calls = (begun(CASES["bank of 5 by 24 states"]) for _ in range(3))
    whole.run(H, inputs, z, STD**2)
    for k in range(0, 400, 100):
        parts.run(H, inputs[k : k + 100], z[k : k + 100], STD**2)
    for row, heard in zip(inputs, z, strict=True):
        calls.step(row, H, heard, STD**2)
    assert whole.x.tobytes() == parts.x.tobytes() == calls.x.tobytes()
    assert whole.P.tobytes() == parts.P.tobytes() == calls.P.tobytes()
    assert whole.log_likelihood.tobytes() == parts.log_likelihood.tobytes() == calls.log_likelihood.tobytes()


@numba.njit
def many(steps: int, filters, inputs, h, z, R, nis, rejected) -> None:
    for _ in range(steps):
        bank.step(filters, inputs, h, z, R, nis, rejected)


def test_a_step_allocates_and_compiles_nothing() -> None:
    ekf = begun(CASES["bank of 5 by 24 states"])
    z = ekf.x[0, :9].copy()
    arguments = (ekf.bank.kernel, np.array([0.1, 0.1, 0.0, 8.0]), H, z, STD**2, ekf.nis, ekf.rejected)
    _nrt_python.memsys_enable_stats()

    def allocated(steps: int) -> tuple[int, int]:
        """By a call of that many steps; the call itself boxes its arrays."""
        before = rtsys.get_allocation_stats()
        many(steps, *arguments)
        after = rtsys.get_allocation_stats()
        return after.alloc - before.alloc, after.mi_alloc - before.mi_alloc

    allocated(1)
    signatures = list(bank.step.signatures)
    assert allocated(1) == allocated(200)
    assert bank.step.signatures == signatures


def nothing_heard(ekf: CoefficientEkf) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
    return np.array([0.1, 0.1, 0.0, 8.0]), H, np.full(9, np.nan), STD**2


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("what", ["inputs", "h", "x", "P", "variance", "log_likelihood"])
def test_a_number_that_is_not_finite_is_told(what: str, bad: float) -> None:
    ekf = begun(CoefficientParams(turbulence=(0.0, 0.1)))
    inputs, h, z, variance = nothing_heard(ekf)
    assert ekf.step(inputs, h, z, variance)
    if what == "inputs":
        inputs[1] = bad
    elif what == "h":
        h = bad
    elif what == "x":
        ekf.x[1, ekf.model.place("M_q")] = bad
    elif what == "P":
        ekf.P[1, 4, 4] = bad
    elif what == "log_likelihood":
        ekf.log_likelihood[1] = bad
    else:
        variance, z[4] = np.where(np.arange(9) == 4, np.nan, variance), 0.0
    assert not ekf.step(inputs, h, z, variance)


def test_a_measurement_that_is_not_finite_is_gated_out() -> None:
    ekf = begun(CoefficientParams())
    silent = begun(CoefficientParams())
    inputs, h, z, variance = nothing_heard(ekf)
    assert silent.step(inputs, h, z, variance)
    z[[2, 5, 8]] = np.inf
    assert ekf.step(inputs, h, z, variance)
    assert ekf.rejected.tolist() == [0, 0, 1, 0, 0, 1, 0, 0, 1]
    np.testing.assert_array_equal(ekf.x, silent.x)
    np.testing.assert_array_equal(ekf.P, silent.P)
