"""What fin angles add up to: the angles that the coefficients multiply."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.vehicle.fins import Fin, FinStation, deflection_rows, effectiveness

PLUS = (0.0, 0.0, 90.0, 90.0)
CROSS = (45.0, 135.0, 45.0, 135.0)


def layout(*hinges: float, bow: int = 0) -> tuple[Fin, ...]:
    stern = [Fin(f"stern {i}", math.radians(hinge)) for i, hinge in enumerate(hinges)]
    return (*stern, *(Fin(f"bow {i}", 0.0, FinStation.BOW) for i in range(bow)))


def added(fins: tuple[Fin, ...], angles: list[float]) -> list[float]:
    return (np.array(deflection_rows(fins)) @ angles).tolist()


def test_a_pair_that_turns_together_counts_as_one_plane_and_one_that_turns_apart_as_none() -> None:
    fins = layout(*PLUS, bow=2)
    assert added(fins, [0.1, 0.1, 0.2, 0.2, 0.0, 0.0]) == pytest.approx([0.1, 0.2, 0.0])
    assert added(fins, [0.1, -0.1, 0.2, -0.2, 0.0, 0.0]) == [0.0, 0.0, 0.0]


def test_bow_planes_are_added_up_for_their_coefficient_is_of_one_and_count_as_nothing_else() -> None:
    assert added(layout(*PLUS, bow=2), [0.0, 0.0, 0.0, 0.0, 0.1, 0.15]) == pytest.approx([0.0, 0.0, 0.25])


@given(st.lists(st.floats(-0.4, 0.4), min_size=4, max_size=4))
def test_an_x_does_by_its_components_what_a_plus_does(angles: list[float]) -> None:
    a, b, c, d = angles
    half = 0.5 * math.sqrt(0.5)
    expected = [half * (a - b + c - d), half * (a + b + c + d), 0.0]
    assert added(layout(*CROSS), angles) == pytest.approx(expected, abs=1e-12)


@given(st.lists(st.floats(-180.0, 180.0), min_size=2, max_size=6), st.integers(0, 2), st.floats(-1.0, 1.0))
def test_with_the_bow_planes_worth_they_are_what_the_allocator_reckons_with(
    hinges: list[float], bow: int, worth: float
) -> None:
    fins = layout(0.0, 90.0, *hinges, bow=bow)
    s, r, b = (np.array(row) for row in deflection_rows(fins))
    known = effectiveness(fins, worth)
    np.testing.assert_allclose(s + worth * b, known.s, rtol=0, atol=1e-12)
    np.testing.assert_allclose(r, known.r, rtol=0, atol=1e-12)


def test_a_level_plane_is_no_rudder_at_all() -> None:
    assert deflection_rows(layout(0.0, 180.0, 90.0))[1][:2] == (0.0, 0.0)
