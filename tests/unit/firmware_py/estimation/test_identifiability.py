"""What was not learned, as it is said: each coefficient and each combination by its name, whatever comes."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from firmware_py.estimation.coefficient_estimator import CoefficientEstimator
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.coefficient_validity import ValidityParams
from firmware_py.estimation.identifiability import LearnedState, directions, identifiability, report
from firmware_py.estimation.learning_params import LearningParams
from firmware_py.records.estimate import Learned
from firmware_py.records.event_text import texts
from tests.estimation.flights import flown, learner, moments, said

NAMES = ("N_r", "N_v", "Y_r", "Y_v")
BELIEVED = np.array([-0.016, -0.007, 0.03, -0.1])
PRIOR = 0.7 * np.abs(BELIEVED)


def sentence(known: LearnedState) -> str:
    """The report, as it is told at a manoeuvre's end."""
    (text,) = texts(report(known))
    return text.removeprefix("manoeuvre: ")


def told(learned: Learned) -> str:
    (text,) = texts(learned.report)
    return text.removeprefix("manoeuvre: ")


def known(std: tuple[float, ...] = (0.01,) * 4, correlated: float = 0.0, **changes: object) -> LearnedState:
    """`std` as shares of what is believed; the last two are correlated."""
    deviations = np.array(std) * np.abs(BELIEVED)
    covariance = np.diag(deviations**2)
    covariance[2, 3] = covariance[3, 2] = correlated * deviations[2] * deviations[3]
    every = np.ones(4, dtype=np.bool_)
    return LearnedState(NAMES, covariance, PRIOR, np.abs(BELIEVED), every, every, every)._replace(**changes)


def flags(*which: str) -> np.ndarray:
    return np.array([name in which for name in NAMES])


def test_a_direction_reads_as_one_says_it() -> None:
    a = np.array([0.3, 0.9, -0.3])
    a /= np.linalg.norm(a)
    worst = directions(1e-6 * np.eye(3) + 4.0 * np.outer(a, a), ("Y_dr", "Y_r", "Y_v"), (1.0, 1.0, 1.0))[0]
    assert worst.words == "0.3 Y_dr + 0.9 Y_r - 0.3 Y_v"
    assert worst.sigma == pytest.approx(2.0)


def test_all_learned_is_said_with_the_worst_of_them() -> None:
    assert sentence(known((0.01, 0.012, 0.03, 0.02))) == "learned all 4, 1 sigma up to 3 % (Y_r)"


def test_what_was_never_excited_is_named() -> None:
    moved = flags("N_r", "Y_r")
    told = sentence(known((0.04, 0.7, 0.01, 0.7), valid=flags("Y_r"), excited=moved, ever=moved))
    assert told == ("learned 2 of 4, 1 valid, 1 sigma up to 4 % (N_r); not identifiable: N_v, Y_v (never excited)")


def test_what_was_excited_and_yet_not_learned_is_not_said_to_have_been_at_rest() -> None:
    moved = flags("N_r", "N_v", "Y_r")
    told = sentence(known((0.01, 0.69, 0.01, 0.7), valid=flags("N_r", "Y_r"), excited=moved, ever=moved))
    assert told.endswith("; not identifiable: Y_v (never excited) and N_v")


@pytest.mark.parametrize(("correlated", "words"), [(0.9999, "0.7 Y_r + 0.7 Y_v"), (-0.9999, "-0.7 Y_r + 0.7 Y_v")])
def test_a_sum_that_nothing_tells_is_named_by_its_direction(correlated: float, words: str) -> None:
    """Either coefficient looks learned by a third; only the other diagonal was."""
    told = sentence(known((0.01, 0.01, 0.5, 0.5), correlated, valid=flags("N_r", "N_v")))
    assert told.startswith("learned 2 of 4, 2 valid, 1 sigma up to 1 % (")
    assert told.removeprefix("learned 2 of 4, 2 valid, 1 sigma up to 1 % (N_r); not identifiable: ") in (
        words,
        words.replace("-0.7 Y_r + 0.7 Y_v", "0.7 Y_r - 0.7 Y_v"),
    )


def test_what_is_known_from_before_and_at_rest_now_is_not_passed_over() -> None:
    told = sentence(known(excited=flags("Y_r", "Y_v")))
    assert told == "learned 4 of 4, 4 valid, 1 sigma up to 1 % (N_r); not excited at the end: N_r, N_v"


def test_an_inconsistent_filter_has_not_learned_all() -> None:
    assert sentence(known(valid=flags())) == "learned 4 of 4, 0 valid, 1 sigma up to 1 % (N_r)"


@pytest.mark.parametrize("poison", [np.nan, np.inf, -1.0])
def test_a_covariance_that_is_none_is_said_to_be_none(poison: float) -> None:
    bad = known().covariance.copy()
    bad[1, 1] = poison
    assert sentence(known()._replace(covariance=bad)) == "learned 0 of 4: the filter's numbers are not finite"


number = st.one_of(st.floats(-10.0, 10.0), st.floats(), st.sampled_from([0.0, 1e-320, 1e300, -1e300]))


@given(st.lists(number, min_size=10, max_size=10), st.lists(st.booleans(), min_size=12, max_size=12))
@example([0.0, 9.79875758637326e194, 0.0, 7.154009031347334e118, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0], [False] * 12)
def test_whatever_the_covariance_a_sentence_comes_of_it_without_a_number_that_is_none(
    numbers: list[float], flag: list[bool]
) -> None:
    covariance = np.zeros((4, 4))
    covariance[np.tril_indices(4)] = numbers
    covariance += np.tril(covariance, -1).T
    valid, excited, ever = np.array(flag).reshape(3, 4)
    told = sentence(LearnedState(NAMES, covariance, PRIOR, np.abs(BELIEVED), valid, excited, ever))
    assert re.match(r"learned (all 4|[0-4] of 4)\b", told)
    assert not re.search(r"\b(nan|inf)\b", told)


@given(st.integers(0, 2**32 - 1), st.integers(0, 4))
def test_as_many_directions_are_lost_as_nothing_was_measured_in(seed: int, measured: int) -> None:
    """So many precise measurements of random combinations leave the rest of the space as it was."""
    H = np.random.default_rng(seed).normal(size=(measured, 4))
    assume(measured == 0 or np.linalg.svd(H, compute_uv=False)[-1] > 0.05)  # combinations that differ
    H /= PRIOR
    information = np.diag(1.0 / PRIOR**2) + 1e6 * H.T @ H
    weak = identifiability(np.linalg.inv(information), NAMES, PRIOR)
    lost = len(weak.alone) + len(weak.mixed)
    assert lost <= 4 - measured  # a coefficient that lies in them almost by itself takes the rest of a sum with it
    assert (lost == 0) == (measured == 4)
    assert set(weak.alone) <= set(weak.unknown)


def shipped() -> CoefficientEstimator:
    """With the thresholds of excitation that the vehicle sails with."""
    return learner(health=ValidityParams(speed_gain=0.003, rate_gain=math.radians(0.03)))


@pytest.mark.parametrize(
    ("delta_s", "delta_r", "lost"),
    [
        (0.3, 0.0, "N_r, N_dr, N_v, Y_dr, Y_r, Y_v"),
        (0.0, 0.3, "M_q, M_ds, Z_ds, Z_q"),
        (0.0, 0.0, ", ".join(TEN)),
    ],
    ids=["rudder locked", "stern planes locked", "both locked"],
)
def test_what_only_a_locked_plane_tells_is_named(delta_s: float, delta_r: float, lost: str) -> None:
    last = told(said(shipped(), moments(flown(20.0, delta_s, delta_r)))[-1])
    assert last.startswith(f"learned {10 - lost.count(',') - 1} of 10, ")
    assert last.endswith(f"; not identifiable: {lost} (never excited)")


def test_where_both_planes_move_enough_all_is_learned_and_said_once_a_second() -> None:
    flight = moments(flown(40.0, 0.3, 0.3))
    words = [told(learned) for learned in said(shipped(), flight)]
    assert words[0] == "learned 0 of 10: learning has not begun"
    assert words[-1].startswith("learned all 10, 1 sigma up to ")
    changed = [k for k in range(1, len(words)) if words[k] != words[k - 1]]
    assert len(changed) > 20
    assert all(flight[k].tick.k % 100 == 0 for k in changed)


def test_of_a_vehicle_that_is_too_slow_to_learn_nothing_is_claimed() -> None:
    words = {told(learned) for learned in said(learner(LearningParams(speed_min=5.0)), moments(flown()))}
    assert words == {"learned 0 of 10: learning has not begun"}


def test_the_words_go_on_where_they_were_frozen() -> None:
    flight = moments(flown(20.0, 0.3, 0.0))
    one, other = shipped(), shipped()
    said(one, flight[:1234])
    other.thaw(one.freeze())
    words = [told(learned) for learned in said(one, flight[1234:])]
    assert words == [told(learned) for learned in said(other, flight[1234:])]
    assert "(never excited)" in words[-1]
