"""What is wrong after a kill: also what is not a number."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sternplane.kill.judgement import Off, left_down, worst_of, wrong

T = np.arange(0.0, 60.0, 1.0)


@pytest.mark.parametrize(
    ("lost", "sigmas", "said"),
    [
        (1.0, 3.0, []),
        (1.1, 0.0, ["more of the log is lost"]),
        (0.0, 3.1, ["confidently lost"]),
        (math.nan, math.nan, ["confidently lost", "more of the log is lost"]),
    ],
)
def test_what_is_beyond_its_bound_or_not_a_number_is_wrong(lost: float, sigmas: float, said: list[str]) -> None:
    assert wrong(lost=lost, sigmas=sigmas) == said


@pytest.mark.parametrize("place", [0, 1, 2])
def test_an_estimate_that_is_not_a_number_is_the_worst_wherever_it_stands(place: int) -> None:
    found = [Off(0.5, 1.0, 2.0), Off(2.0, 1.0, 0.5)]
    assert worst_of(found) == Off(2.0, 1.0, 0.5)
    found.insert(place, Off(math.nan, math.nan, 2.0))
    assert math.isnan(worst_of(found).sigmas)
    assert wrong(lost=0.0, sigmas=worst_of(found).sigmas) == ["confidently lost"]


@pytest.mark.parametrize(
    ("armed", "begun", "end", "moved", "wrongly"),
    [
        (True, 6.0, 0.2, True, False),
        (True, 6.0, 0.2, False, True),
        (True, 6.0, 5.0, True, True),
        (True, math.nan, math.nan, True, True),
        (False, 0.1, 0.1, False, False),
        (True, 0.1, 3.0, True, True),
    ],
)
def test_a_vehicle_must_come_up_from_under_water_and_rest_at_the_surface(
    armed: bool, begun: float, end: float, moved: bool, wrongly: bool
) -> None:
    z = np.where(T < 30.0, begun, end)
    assert bool(left_down(armed, T, z, moved)) is wrongly
