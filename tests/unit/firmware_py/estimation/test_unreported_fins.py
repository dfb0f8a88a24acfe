"""Fins that report nothing: what is learned by them is right, or it is not called valid."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
import pytest

from firmware_py.estimation.coefficient_estimator import CoefficientEstimator
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.records.estimate import Learned
from firmware_py.records.health import NO_DOUBTS, AxisDoubt
from firmware_py.records.sensing import never
from tests.estimation.cases import TRUTH
from tests.estimation.flights import DT, Moment, flown, learner, moments

FLIGHT = moments(flown())
STAYS = 25.0
"""A plane stays from then on, s."""


def mute(stays: float = 0.0, lag: float = 0.16, play: float = math.radians(0.05)) -> Iterator[Moment]:
    """The planes report nothing: they go where they go by a servo of such a lag and half such a play.

    From STAYS on one of them stays at an angle; of both that makes what the plant felt if both are told twice as much.
    """
    angles = np.array([moment.applied.fins[0] for moment in FLIGHT])
    servo = angles + play * np.sign(np.gradient(angles))
    told = servo + lag * np.gradient(servo, DT)
    for moment, command in zip(FLIGHT, told.tolist(), strict=True):
        if stays and moment.t > STAYS:
            command = 2.0 * command - stays
        fins = (never(math.nan), never(math.nan), *moment.frame.fins[2:])
        applied = dataclasses.replace(moment.applied, fins=(command, command, *moment.applied.fins[2:]))
        yield moment._replace(frame=dataclasses.replace(moment.frame, fins=fins), applied=applied)


def wrong(learned: Learned) -> set[str]:
    """What is called valid and is off by more than 4 sigma."""
    each = zip(TEN, learned.value, learned.std, learned.valid, strict=True)
    return {name for name, x, std, ok in each if ok and abs(x - getattr(TRUTH.coefficients, name)) > 4.0 * std}


def learns(course: Iterator[Moment]) -> list[Learned]:
    vehicle = learner(boost_std=0.4)
    return [vehicle.update(*moment) for moment in course]


def test_a_servo_that_is_slower_than_thought_and_has_play_makes_nothing_valid_that_is_wrong() -> None:
    course = learns(mute())
    assert all(course[-1].valid[TEN.index(name)] for name in ("M_q", "M_ds"))
    assert sum(len(wrong(learned)) for learned in course[::10]) <= 0.01 * sum(sum(one.valid) for one in course[::10])


def test_what_is_learned_by_fins_that_report_is_as_sure_as_it_was() -> None:
    i = TEN.index("M_ds")
    reporting, silent = learns(iter(FLIGHT))[-1], learns(mute(lag=0.12, play=0.0))[-1]
    assert reporting.std[i] < silent.std[i] < 10.0 * reporting.std[i]
    assert reporting == [vehicle.update(*moment) for vehicle in [learner(boost_std=0.4)] for moment in FLIGHT][-1]


@pytest.mark.parametrize("angle", [8.0, -8.0])
def test_a_plane_that_stays_does_not_make_the_planes_weak(angle: float) -> None:
    """The gyros contradict the filter, and what was learned before holds; of the rudders as well as without."""
    course = learns(mute(math.radians(angle)))
    after = course[round((STAYS + 2.0) / DT) :: 10]
    before = course[round((STAYS - 1.0) / DT)]
    for name in ("M_ds", "M_q"):
        i = TEN.index(name)
        assert not any(learned.valid[i] for learned in after[:60])
        assert all(abs(one.value[i] - before.value[i]) < 4.0 * before.std[i] for one in after[:60])
    assert not any(wrong(learned) for learned in after[:60])
    assert after[60].valid[TEN.index("N_dr")]
    i = TEN.index("N_dr")
    assert max(one.std[i] for one in after[:20]) > 1.5 * before.std[i]  # it could have been the rudders


def test_what_was_learned_since_something_spoke_for_a_fin_that_stays_is_taken_back() -> None:
    """The motion names it at last, and says since when."""
    named, since = STAYS + 4.0, (AxisDoubt(5.0), AxisDoubt())
    vehicle = learner()
    i, course = TEN.index("M_ds"), list(mute(math.radians(3.0)))
    said = [vehicle.update(*moment, since if moment.t >= named else NO_DOUBTS) for moment in course]
    before, after = said[round((named - 11.0) / DT)], said[round((named + 0.2) / DT) :]
    assert vehicle.held == (True, False)
    assert all(one.value[i] == after[0].value[i] and not one.valid[i] for one in after[:500])
    assert abs(after[0].value[i] - before.value[i]) < 2.0 * before.std[i]


def test_memory_is_whole() -> None:
    course = list(mute(math.radians(8.0)))
    once, again = learner(boost_std=0.4), learner(boost_std=0.4)
    half = round((STAYS + 4.0) / DT)
    for moment in course[:half]:
        once.update(*moment)
    assert once.held == (True, False)
    again.thaw(once.freeze())
    assert goes_on(again, course[half:]) == goes_on(once, course[half:])


def goes_on(vehicle: CoefficientEstimator, course: list[Moment]) -> list[str]:
    return [repr(vehicle.update(*moment)) for moment in course[:1100:100]]
