"""Runs of the estimation study in which the filter broke off: they are counted, and no figure leaves them out."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from sternplane.study.cases import consistency, exact, noisy, wrong
from sternplane.study.figures import final
from sternplane.study.rows import RunArrays
from sternplane.study.setups import Setup, fly_prbs, run_filter, starts


def test_a_filter_that_breaks_off_leaves_no_number_from_there_on(monkeypatch: pytest.MonkeyPatch) -> None:
    setup, ekf = Setup(duration=12.0), noisy.still_water()
    advance, calls = ekf.run, iter(range(24))

    def run(*args: object, **kwargs: object) -> object:
        history = advance(*args, **kwargs)
        return history._replace(steps=history.steps - (next(calls) == 5))

    monkeypatch.setattr(ekf, "run", run)
    found = run_filter(setup, fly_prbs(setup, 1), ekf, 1, starts(1, 0.5))
    assert found.t == pytest.approx(np.linspace(0.5, 12.0, 24))
    for array in (found.error, found.std, found.nees, found.weights):
        assert len(array) == 24
        assert np.isfinite(array[:5]).all()
        assert np.isnan(array[5:]).all()


def filtered(duration: float, *, breaks_off: float = math.inf, padded: bool = True) -> RunArrays:
    """Return what a filter as good as the bound might leave; `padded`: NaN where it broke off, else nothing."""
    t = np.linspace(0.0, duration, 25)[1:]
    random = np.random.default_rng(int(1e3 * duration))
    bound = 0.01 * np.sqrt(duration / t)[:, None] * np.ones(10)
    error = bound * random.choice((-1.0, 1.0), bound.shape)
    alive = t < breaks_off
    error[~alive] = math.nan
    arrays = {"t": t, "error": error, "bound": bound, "considered": error, "its sigma": bound, "std": bound}
    arrays |= {"steps": np.array(alive.sum()), "current": 1e-5 * error[:, :2]}
    if not padded:
        arrays = {name: array[alive] if array.ndim else array for name, array in arrays.items()}
    return {**arrays, "with current": arrays["error"][-1:], "bound with current": arrays["bound"][-1:]}


def streamed(stream: RunArrays, still: RunArrays) -> RunArrays:
    """Return the run of a flight in a current and of one without."""
    two = (("still", still), ("stream", stream))
    return {**{f"{label} {name}": array for label, run in two for name, array in run.items()}, "t": stream["t"]}


@pytest.mark.parametrize("padded", [True, False])
@pytest.mark.parametrize("broken", [0, 3])
def test_runs_that_broke_off_are_counted_and_miss_their_target(broken: int, padded: bool) -> None:
    def runs(duration: float, count: int) -> list[RunArrays]:
        off = 0.3 * duration
        return [filtered(duration, breaks_off=off if k == broken else math.inf, padded=padded) for k in range(count)]

    judged = {
        "noisy": noisy.CASES[0].evaluate(runs(60.0, 8)),
        "long": noisy.CASES[1].evaluate(runs(900.0, 8)),
        "current": noisy.CASES[2].evaluate([streamed(filtered(60.0), one) for one in runs(60.0, 8)]),
        "wrong": wrong.CASES[0].evaluate(runs(300.0, 8)),
    }
    for name, results in judged.items():
        (row,) = [row for row in results.rows if row.figure == "runs that broke off"]
        assert (row.value, row.ok) == (1.0, False), name
        json.dumps([row.plain() for row in results.rows], allow_nan=False)
    assert all(row.ok for row in judged["wrong"].rows if row.n)  # of the seven others
    (plot,) = exact.CASES[0].evaluate(runs(120.0, 5)).plots
    assert len(plot.figure.data[0].x) == 24


@pytest.mark.parametrize("broken", [1, 4])
def test_the_case_of_consistency_counts_runs_that_broke_off(broken: int) -> None:
    def run(k: int) -> RunArrays:
        arrays = filtered(60.0, breaks_off=30.0 if k < broken else math.inf)
        ones = np.where(np.isfinite(arrays["error"][:, :1]), 1.0, math.nan)
        arrays |= {"nees": ones * (10.0, 19.0), "freedom": np.array((10, 19)), "resets": np.array(0)}
        arrays |= {"nis": ones[:, :, None] * np.full((3, 2), 300.0), "weights": ones * np.full(5, 0.2)}
        return {f"no eddies {name}": array for name, array in arrays.items()}

    rows = consistency.evaluate({"no eddies": Setup()}, [run(k) for k in range(4)]).rows
    missed = {row.figure for row in rows if row.ok is False}
    assert {row.value for row in rows if row.figure == "runs that broke off"} == {float(broken)}
    assert missed - {"NEES of the ten per degree of freedom"} == {"runs that broke off"}


def test_a_study_in_which_every_run_broke_off_says_so() -> None:
    (row,) = wrong.CASES[0].evaluate([filtered(300.0, breaks_off=50.0)] * 4).rows
    assert (row.value, row.ok) == (4.0, False)
    assert np.isnan(final([filtered(60.0, breaks_off=50.0, padded=False)] * 2, 60.0)).all()
