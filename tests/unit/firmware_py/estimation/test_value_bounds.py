"""A value that was reported as valid bounds what it may become."""

from __future__ import annotations

import math

from firmware_py.estimation.value_bounds import SIGMAS, possible, unbounded


def test_what_was_never_valid_bounds_nothing() -> None:
    bounds = unbounded(2)
    for value in ((1.0, 1.0), (1e9, -1e9)):
        assert bounds.hold(value)
        bounds = bounds.after(value, (1e-3, 1e-3), (False, False))


def test_a_valid_report_bounds_its_own_coefficient_by_five_of_its_sigmas() -> None:
    bounds = unbounded(2).after((1.0, 1.0), (0.1, 0.1), (True, False))
    assert bounds.hold((1.0 + 0.999 * SIGMAS * 0.1, 99.0))
    assert bounds.hold((1.0 - 0.999 * SIGMAS * 0.1, 99.0))
    assert not bounds.hold((1.0 + 1.001 * SIGMAS * 0.1, 1.0))
    assert not bounds.hold((1.0 - 1.001 * SIGMAS * 0.1, 1.0))


def test_the_narrowest_of_all_reports_counts_not_the_last() -> None:
    """A value that creeps, each time within its sigma, has gone too far in the end."""
    bounds, value = unbounded(1), 1.0
    for _ in range(49):
        bounds = bounds.after((value,), (0.1,), (True,))
        assert bounds.hold((value,))
        value += 0.01
    assert bounds.hold((value,))
    assert not bounds.hold((value + 0.02,))
    wide = bounds.after((1.0,), (10.0,), (True,))
    assert not wide.hold((1.6,))


def test_a_value_that_is_no_number_is_not_held() -> None:
    assert not unbounded(1).hold((math.nan,))


def test_what_every_vehicle_has_negative_cannot_be_positive_and_the_rest_can_be_anything_in_its_bounds() -> None:
    names = ("M_q", "N_v", "Y_v", "M_ds")
    bounds = possible(names, (-1.0, -2.0, -3.0, -4.0), (0.5, 2.0, -0.1, 1.0))
    assert bounds.low == (-1.0, -2.0, -3.0, -4.0)
    assert bounds.high == (0.0, 2.0, -0.1, 0.0)
