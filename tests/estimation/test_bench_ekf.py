"""The bench of the filter's step: what is compared is the same step, to the last bit."""

from __future__ import annotations

import ctypes
import shutil
from pathlib import Path

import numpy as np
import pytest
from sternplane.bench import ekf
from sternplane.bench.ekf import CASES, STD, InC, InNumba, NoCompiler, begun, compile_step, flight, settled_filter

from firmware_py.estimation.coefficient_params import CoefficientParams

MORE = {
    "considered": CoefficientParams(considered=("rest",), names=("M_q", "N_r", "M_dot"), walk=0.01),
    "not neutral": CoefficientParams(nuisances=("Z_w", "buoyancy")),
    "biased": CoefficientParams(turbulence=(0.05, 0.2), rate_bias=1e-3, angle_bias=0.02, speed_bias=0.02),
}
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL | None:
    """The C step, which makes the compiler warn of nothing; None where there is no compiler."""
    return compile_step(tmp_path_factory.mktemp("c"), *STRICT) if shutil.which("cc") else None


def test_c_makes_the_same_numbers_to_the_last_bit(library: ctypes.CDLL | None) -> None:
    """Over 1000 steps, through outliers, silence and psi = 180 deg."""
    if library is None:
        return
    wanted, nis, rng = np.zeros((1000, 9)), np.zeros((1000, 9)), np.random.default_rng(7)
    for case in (CASES | MORE).values():
        ours, theirs = settled_filter(case), settled_filter(case)
        inputs, z = flight(ours.model, 1000)
        z[:, 8] = (z[:, 8] + 3.1 + np.pi) % (2.0 * np.pi) - np.pi
        z[rng.random(z.shape) < 0.02] += 1.0
        z[rng.random(z.shape) < 0.2] = np.nan
        for side in (ours, theirs):
            side.start((1.8288, 0, 0, 0, 0, 0), (0, 0, 3.1), STD)
        assert InNumba(ours).run(inputs, z, STD**2, wanted) == 1000
        assert ours.rejected.sum() > 20
        assert InC(library, theirs).run(inputs, z, STD**2, nis) == 1000
        for mine, other in (
            (ours.x, theirs.x),
            (ours.P, theirs.P),
            (ours.log_likelihood, theirs.log_likelihood),
            (wanted, nis),
            (ours.rejected, theirs.rejected),
        ):
            np.testing.assert_array_equal(mine, other)


def test_c_stops_where_numba_stops(library: ctypes.CDLL | None) -> None:
    if library is None:
        return
    ekf = settled_filter(CASES["19 states"])
    inputs, z = flight(ekf.model, 20)
    inputs[12, 0] = np.nan
    for made in (InNumba(ekf), InC(library, settled_filter(CASES["19 states"]))):
        assert made.run(inputs, z, STD**2, np.zeros((20, 9))) == 12


def test_a_bank_is_as_large_as_its_name_says() -> None:
    sizes = {name: begun(case).P.shape for name, case in CASES.items()}
    assert sizes == {
        "19 states": (1, 19, 19),
        "21 states": (1, 21, 21),
        "29 states": (1, 29, 29),
        "bank of 5 by 24 states": (5, 24, 24),
    }


def test_the_table_gives_medians_and_their_ratio() -> None:
    assert ekf.table({"numba": 4.5678, "c": 3.2, "called from python": 6.0}, "") == {
        "numba us": 4.57,
        "c us": 3.2,
        "called from python us": 6.0,
        "numba over c": 1.43,
    }


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(NoCompiler, match="no C compiler"):
        compile_step(tmp_path)
    found = ekf.measure(rounds=1, seconds=1)
    assert set(found) == set(CASES)
    for case in found.values():
        assert case["c us"] == "not measured: no C compiler (cc) on this machine"
        assert case["numba us"] > 0.0


def test_a_compiler_that_fails_is_quoted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    cc = tmp_path / "cc"
    cc.write_text("#!/bin/sh\necho 'math.h: not found' >&2\nexit 1\n")
    cc.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(cc))
    with pytest.raises(NoCompiler, match=r"cannot compile ekf_step.c: math.h: not found"):
        compile_step(tmp_path)
