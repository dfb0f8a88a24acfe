"""A pass that explains the flight worse than the running bank takes over nothing, and confirms nothing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.iteration.acceptance import EVIDENCE_LOST, Evidence

from .cases import VEHICLE
from .test_iterated_filter import NOW, SENSOR_STD, SOON, bits, given_to, started

FAR = 100.0 * EVIDENCE_LOST
NEVER = dataclasses.replace(SOON, iteration_times=())


def run(ekf: CoefficientEkf, given: tuple[np.ndarray, np.ndarray], begin: float, end: float) -> None:
    rows = slice(round(begin / NOW.h), round(end / NOW.h))
    inputs, z = given
    ekf.run(NOW.h, inputs[rows], z[rows], SENSOR_STD**2)


@pytest.mark.parametrize(
    ("passed", "running", "lost", "enough"),
    [
        ((0.0, -90.0), (-500.0, 49.0), 0.0, True),
        ((0.0, -90.0), (-500.0, 51.0), 0.0, False),
        ((0.0, -90.0), (-500.0, 151.0), -102.0, True),
    ],
)
def test_the_best_filters_are_compared_and_what_resets_took_counts(passed, running, lost, enough) -> None:
    evidence = Evidence(60.0)
    evidence.lost = lost
    assert EVIDENCE_LOST == 50.0
    assert evidence.enough(np.array(passed), np.array(running)) is enough


def test_what_was_lost_fades_as_the_log_likelihoods_do() -> None:
    evidence = Evidence(60.0)
    evidence.lost = -100.0
    for _ in range(10):
        evidence.fade(6.0)
    assert evidence.lost == pytest.approx(-100.0 / math.e)


def worse(ekf: CoefficientEkf, by: float) -> None:
    """Lets every pass from here on explain the flight worse."""
    x, P, log_likelihood = ekf.iteration._start
    ekf.iteration._start = (x, P, log_likelihood - by)


def go_on(ekf: CoefficientEkf, given: tuple[np.ndarray, np.ndarray], at: float, until) -> float:
    """Runs on from `at`, s, until that holds, or to the end; where it came to."""
    while not until() and at < NOW.duration - 0.05:
        run(ekf, given, at, at + 0.1)
        at += 0.1
    return at


def test_a_pass_that_ends_far_from_the_measurements_is_rejected() -> None:
    x, *given = given_to(1)
    ekf, alone = started(x), started(x, NEVER)
    worse(ekf, FAR)
    at = go_on(ekf, given, 0.0, lambda: ekf.iteration.rejected)
    run(alone, given, 0.0, at)
    assert ekf.iteration.rejected == 1
    assert ekf.iteration.accepted == 0
    assert not ekf.iterated.any()
    assert bits(ekf) == bits(alone)


def test_a_rejected_pass_takes_back_what_an_earlier_one_confirmed_and_it_is_tried_from_the_first_stage() -> None:
    x, *given = given_to(2)
    ekf = started(x, dataclasses.replace(SOON, iteration_times=(1.0, 4.0, 12.0)))
    at = go_on(ekf, given, 0.0, lambda: ekf.iteration.accepted)
    assert ekf.iterated.all()
    worse(ekf, FAR)
    at = go_on(ekf, given, at, lambda: ekf.iteration.rejected)
    assert not ekf.iterated.any()
    assert ekf.iteration._stage == 0
    worse(ekf, -FAR)
    ekf.iteration._bank.log_likelihood[:] += FAR
    go_on(ekf, given, at, lambda: ekf.iteration.accepted == 2)
    assert ekf.iteration.accepted == 2
    assert ekf.iterated.all()


def test_what_no_pass_confirmed_is_recorded_anew_with_all_the_doubt_of_the_beginning() -> None:
    x, *given = given_to(3)
    ekf = started(x, dataclasses.replace(SOON, iteration_times=(1.0, 4.0)))
    worse(ekf, FAR)
    at = go_on(ekf, given, 0.0, lambda: ekf.iteration._start[2][0] > 0.0)
    assert ekf.iteration.rejected
    assert ekf.iteration.running
    assert ekf.iteration.used < 0.2 / NOW.h
    doubt, first = ekf.iteration._start[1][0], ekf.model.first
    np.testing.assert_allclose(np.sqrt(np.diag(doubt))[first:], ekf.prior[first:])
    go_on(ekf, given, at, lambda: ekf.iteration.accepted)
    assert ekf.iterated.all()
    told = ekf.estimate()
    off = (told.values - np.array([getattr(VEHICLE.coefficients, name) for name in ekf.names])) / told.std
    assert off @ off / 10.0 < 3.0
