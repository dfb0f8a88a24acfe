"""The histogram of lateness, against numbers counted by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sternplane.logs import lateness_histogram

STEP = 10_000_000


def test_numbers_counted_by_hand() -> None:
    late = lateness_histogram.of_cycles([2_500, 55_000, 60_000, 69_999, 70_000, 12_000_000], STEP)
    bars = {low: n for low, n in zip(late.edges_us, late.counts, strict=False) if n}
    assert bars == {2.0: 1, 50.0: 3, 70.0: 1, 10_000.0: 1}
    assert (late.edges_us[0], late.edges_us[-1]) == (2.0, 15_000.0)
    assert (late.median_us, late.p99_us, late.max_us, late.slips) == (60.0, 12_000.0, 12_000.0, 1)


def test_percentiles_are_lateness_that_occurred() -> None:
    late = lateness_histogram.of_cycles(np.arange(1, 2001) * 1000, STEP)
    assert (late.median_us, late.p99_us, late.p999_us, late.max_us) == (1000.0, 1980.0, 1998.0, 2000.0)


def test_exactly_a_step_is_no_slip() -> None:
    assert lateness_histogram.of_cycles([STEP, STEP + 1, 0], STEP).slips == 1


def test_a_punctual_cycle_has_a_bar_too() -> None:
    late = lateness_histogram.of_cycles([0, 0, 999], STEP)
    assert (late.edges_us, late.counts) == ([0.0, 1.0], [3])


def test_an_hour_late_has_a_bar_too() -> None:
    late = lateness_histogram.of_cycles([5_000, 3_600_000_000_000], STEP)
    assert (late.counts[0], late.counts[-1], sum(late.counts)) == (1, 1, 2)
    assert late.edges_us[-1] > late.max_us == 3.6e9


@given(st.lists(st.integers(0, 2**62), min_size=1))
def test_every_cycle_is_in_one_bar(values: list[int]) -> None:
    late = lateness_histogram.of_cycles(values, STEP)
    assert sum(late.counts) == len(values)
    assert late.counts[0] > 0 < late.counts[-1]
    assert len(late.edges_us) == len(late.counts) + 1
    assert late.edges_us == sorted(set(late.edges_us))
    assert late.median_us <= late.p99_us <= late.p999_us <= late.max_us == max(values) / 1e3


@pytest.mark.parametrize(
    ("us", "words"),
    [
        (0.0, "0 µs"),
        (0.25, "0.25 µs"),
        (58.123, "58.1 µs"),
        (999.0, "999 µs"),
        (1250.0, "1.25 ms"),
        (59_149.0, "59.1 ms"),
        (2e6, "2 s"),
    ],
)
def test_lateness_for_people(us: float, words: str) -> None:
    assert lateness_histogram.with_unit(us) == words
