"""Distances to a path, and angles for people."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tools.tracking import distance, unwrapped_deg, wrapped_deg

PLACE = st.tuples(st.integers(-100, 100), st.integers(-100, 100))


def test_the_distance_to_a_path_with_a_corner() -> None:
    path = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 60.0]])
    places = np.array([[30.0, 4.0], [30.0, -4.0], [-3.0, -4.0], [63.0, -4.0], [57.0, 2.5], [62.0, 30.0], [55.0, 900.0]])
    assert distance(places, path) == pytest.approx([4.0, 4.0, 5.0, 5.0, 2.5, 2.0, 5.0])


@given(st.lists(PLACE, min_size=2, max_size=6), PLACE)
def test_it_is_that_of_the_nearest_of_all_points(path: list[tuple[int, int]], place: tuple[int, int]) -> None:
    way, places = np.array(path, dtype=float), np.array([place], dtype=float)
    share = np.linspace(0.0, 1.0, 400)[:, None]
    points = np.vstack([a + share * (b - a) for a, b in itertools.pairwise(way)])
    nearest = np.hypot(*(points - place).T).min()
    ended = distance(places, np.vstack((way, way[-1])))[0]
    assert ended <= nearest + 1e-9
    assert ended >= nearest - 0.36  # half a step of the longest leg: 283 m / 399 / 2
    beyond = way[-1] + np.arange(3000.0)[:, None] * (way[-1] - way[-2])
    endless = distance(places, way)[0]
    assert endless <= ended
    assert endless <= np.hypot(*(beyond - place).T).min() + 1e-9
    assert endless == pytest.approx(distance(places, np.vstack((way, beyond[-1], beyond[-1])))[0])


def test_an_estimate_that_is_not_there_yet_does_not_hide_the_rest() -> None:
    path = np.array([[math.nan, math.nan], [60.0, 0.0], [60.0, 60.0]])
    assert distance(np.array([[58.0, 30.0]]), path) == pytest.approx([2.0])


@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=50), st.floats(-20.0, 20.0), st.sets(st.integers(0, 49)))
def test_unwrapped_has_no_jumps_and_is_the_same_angle(steps: list[float], begin: float, unknown: set[int]) -> None:
    true = np.degrees(begin + np.cumsum(steps))
    psi = np.angle(np.exp(1j * np.radians(true)))
    psi[[i for i in unknown if i < len(psi)]] = math.nan
    found = unwrapped_deg(psi)
    assert np.array_equal(np.isnan(found), np.isnan(psi))
    known = np.isfinite(psi)
    assert wrapped_deg(np.radians(found) - psi)[known] == pytest.approx(0.0, abs=1e-6)
    if known.all():
        assert np.diff(found) == pytest.approx(np.diff(true), abs=1e-6)
    if known.any():
        assert -45.0 - 1e-9 <= np.median(found[known]) <= 315.0 + 1e-9


@pytest.mark.parametrize(("degrees", "shown"), [(-90.0, 270.0), (-10.0, -10.0), (359.0, -1.0), (180.0, 180.0)])
def test_a_course_is_written_as_a_compass_has_it_except_about_north(degrees: float, shown: float) -> None:
    assert unwrapped_deg(np.radians([degrees] * 3)) == pytest.approx(shown)
