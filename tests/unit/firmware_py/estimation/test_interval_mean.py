"""Means of what was reported, against integrals taken finely."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.estimation.interval_mean import ROOM, IntervalMeans

reports = st.lists(
    st.tuples(st.floats(-1.0, 2.0), st.floats(-5.0, 5.0)), min_size=1, max_size=12, unique_by=lambda r: round(r[0], 3)
).map(sorted)
cuts = st.lists(st.integers(-1500, 2500), min_size=2, max_size=12, unique=True).map(
    lambda cuts: [cut / 1000.0 for cut in sorted(cuts)]
)


def traces(*courses: list[tuple[float, float]], weights: list[list[float]] | None = None) -> IntervalMeans:
    made = IntervalMeans(weights or np.eye(len(courses)).tolist())
    for i, course in enumerate(courses):
        for t, value in course:
            made.add(i, t, value)
    return made


def mean(made: IntervalMeans, a: float, b: float, rows: int = 1) -> np.ndarray:
    sums = np.full(rows, np.nan)
    made.mean(a, b, sums)
    return sums


@given(reports, cuts)
def test_the_mean_is_that_of_a_fine_integral(course: list[tuple[float, float]], cuts: list[float]) -> None:
    made = traces(course)
    knots = [t for t, _ in course]
    for a, b in itertools.pairwise(cuts):
        fine = np.union1d(np.linspace(a, b, 50), [t for t in knots if a < t < b])
        exact = np.trapezoid(np.interp(fine, *zip(*course, strict=True)), fine) / (b - a)
        assert mean(made, a, b)[0] == pytest.approx(exact, rel=1e-9, abs=1e-9)


@given(reports, reports, cuts)
def test_each_quantity_has_its_own_times_and_the_sums_are_weighted(one, other, cuts: list[float]) -> None:
    both = traces(one, other, weights=[[0.5, 0.25], [0.0, -1.0], [0.0, 0.0]])
    alone, apart = traces(one), traces(other)
    for a, b in itertools.pairwise(cuts):
        x, y = mean(alone, a, b)[0], mean(apart, a, b)[0]
        np.testing.assert_allclose(mean(both, a, b, 3), [0.5 * x + 0.25 * y, -y, 0.0], rtol=1e-12, atol=1e-12)


@given(reports, cuts)
def test_a_report_that_is_not_newer_changes_nothing(course: list[tuple[float, float]], cuts: list[float]) -> None:
    clean, spoiled = traces(course), traces(course)
    for t in (course[-1][0], course[0][0], -9.0, float("nan")):
        spoiled.add(0, t, 99.0)
    for a, b in itertools.pairwise(cuts):
        assert mean(clean, a, b).tobytes() == mean(spoiled, a, b).tobytes()


@given(reports, cuts, st.integers(0, 12))
def test_it_goes_on_where_it_was_frozen(course: list[tuple[float, float]], cuts: list[float], at: int) -> None:
    """What is taken over from one that has already forgotten, and what came before, give the same bits."""
    whole, part, late = traces(course), traces(course[:at]), traces([(-3.0, 7.0), (-2.0, 7.0)])
    late.thaw(part.freeze())
    for t, value in course[at:]:
        late.add(0, t, value)
    for a, b in itertools.pairwise(cuts):
        assert mean(whole, a, b).tobytes() == mean(late, a, b).tobytes()
    assert whole.freeze() == late.freeze()


def test_what_is_behind_is_forgotten_and_no_more_is_kept_than_there_is_room_for() -> None:
    made = traces([(0.001 * k, 0.0) for k in range(3 * ROOM)])
    assert len(made.freeze()[0].times) == ROOM
    for k in range(100_000):
        made.add(0, 10.0 + 0.01 * k, float(k))
        mean(made, 9.5 + 0.01 * k, 9.51 + 0.01 * k)
    assert len(made.freeze()[0].times) < 60


def test_what_was_never_reported_counts_as_nothing() -> None:
    assert mean(traces([], [(0.0, 3.0)]), 0.0, 1.0, 2).tolist() == [0.0, 3.0]
