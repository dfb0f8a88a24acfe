"""When a learned coefficient counts as excited, consistent and valid, and that none of it flickers."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.estimation.coefficient_validity import (
    CAREFUL,
    ENTER,
    STAY,
    UNSURE,
    CoefficientValidity,
    Validity,
    ValidityParams,
    band,
)
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.params import ParamError
from tests.estimation.cases import TEN, VEHICLE

DT = 0.01
NAMES = (*TEN, "N_dot", "C_dy")
MODEL = ObserverModel(VEHICLE, (*NAMES, "Z_w"))  # the last is considered only
SCALE = np.abs(MODEL.believed[: len(NAMES)])
CRUISE = (1.83, 0.0, 0.0, 0.0, 0.0, 0.0)
FINE = np.ones(9)
SILENT = np.full(9, math.nan)
CERTAIN, BETWEEN, DOUBTFUL = 0.05, 0.15, 0.3


def health(**changes: float) -> CoefficientValidity:
    return CoefficientValidity(ValidityParams(**changes), MODEL, len(NAMES))


def forces(nu: tuple[float, ...] = CRUISE, delta_s: float = 0.0, delta_r: float = 0.0) -> np.ndarray:
    """What each coefficient multiplies, as the model has it after a step."""
    assert MODEL.advance(MODEL.state(nu, (0.0, 0.0, 0.0)), np.array([delta_s, delta_r, 0.0, 8.33]), 1e-9)
    return MODEL.linearisation.regressors.copy()


def hasty(**changes: float) -> CoefficientValidity:
    """Makes up its mind within a second."""
    return health(**{"excitation_time": 0.1, "nis_time": 0.3, "settle": 0.05, **changes})


def step(
    judge: CoefficientValidity, share: float = CERTAIN, y: np.ndarray | None = None, nis: np.ndarray = FINE, **more
) -> Validity:
    return judged(judge, share * SCALE, BUSY if y is None else y, nis, **more)


def judged(judge: CoefficientValidity, *heard: np.ndarray, **more) -> Validity:
    judge.update(DT, *heard, **more)
    return judge.verdict


def last(judge: CoefficientValidity, seconds: float, share: float = CERTAIN, **more) -> Validity:
    for _ in range(round(seconds / DT)):
        verdict = step(judge, share, **more)
    return verdict


BUSY = forces((1.83, 0.3, 0.2, 0.0, 0.15, 0.15), 0.2, 0.2)
QUIET = forces()
M_DS = NAMES.index("M_ds")
M_DS_FORCE = forces(delta_s=0.1)[MODEL.arrays.terms.regressor[M_DS]] / 0.1
M_DS_MADE = abs(MODEL.arrays.inverse_mass[4, 4] * SCALE[M_DS] * M_DS_FORCE)
"""The acceleration by a rad of delta_s, rad/s^2."""


def test_what_is_certain_excited_and_consistent_becomes_valid_when_the_filter_has_settled() -> None:
    judge = health(settle=5.0)
    flags = [step(judge) for _ in range(3000)]
    assert not any(any(verdict.valid) for verdict in flags[:498])
    assert all(flags[-1].excited)
    assert all(flags[-1].valid)
    assert flags[-1].nis == pytest.approx((1.0, 1.0, 1.0))


def test_a_share_is_of_the_believed_size_whatever_its_sign() -> None:
    judge = health()
    last(judge, 30.0, DOUBTFUL)
    share = np.full(len(NAMES), BETWEEN)
    share[3] = 0.0999
    verdict = judged(judge, share * SCALE, BUSY, FINE)
    assert [i for i, valid in enumerate(verdict.valid) if valid] == [3]


@given(st.lists(st.tuples(st.floats(0.02, 0.4), st.integers(1, 20)), max_size=60))
def test_validity_changes_only_from_threshold_to_threshold(course: list[tuple[float, int]]) -> None:
    judge = hasty()
    last(judge, 1.0, DOUBTFUL)
    was = False
    for share, ticks in course:
        for _ in range(ticks):
            now = step(judge, share).valid[0]
            assert now == (share <= 0.1 or (was and share <= 0.2))
            was = now


@given(st.integers(0, 2**32 - 1))
def test_certainty_that_wavers_between_the_thresholds_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for first, valid in ((CERTAIN, True), (DOUBTFUL, False)):
        judge = hasty()
        last(judge, 1.0, DOUBTFUL)
        assert step(judge, first).valid[0] == valid
        assert {step(judge, share).valid[0] for share in rng.uniform(0.101, 0.199, 100)} == {valid}


@given(st.lists(st.tuples(st.booleans(), st.floats(0.02, 0.4), st.floats(0.2, 4.0), st.booleans()), max_size=60))
def test_nothing_becomes_valid_without_excitation_or_consistency(course) -> None:
    judge = hasty()
    was = [False] * len(NAMES)
    for busy, share, nis, reset in course:
        for i in range(10):
            if reset and i == 0:
                judge.reset()
            verdict = step(judge, share, BUSY if busy else QUIET, nis * FINE)
            for before, now, excited in zip(was, verdict.valid, verdict.excited, strict=True):
                assert excited or before or not now
            if any(verdict.valid):
                assert all(math.isnan(mean) or 0.3 < mean < 2.2 for mean in verdict.nis)
            was = list(verdict.valid)


def test_what_was_valid_stays_so_when_the_vehicle_flies_straight_again() -> None:
    judge = health()
    last(judge, 30.0)
    verdict = last(judge, 120.0, BETWEEN, y=QUIET)
    assert not any(verdict.excited)
    assert all(verdict.valid)


def test_a_reset_takes_all_validity_and_gives_none_before_it_has_settled() -> None:
    judge = health(settle=8.0)
    last(judge, 30.0)
    judge.reset()
    assert not any(judge.verdict.valid)
    assert not any(step(judge).valid)
    assert not any(last(judge, 7.9).valid)
    assert all(last(judge, 20.0).valid)


@pytest.mark.parametrize("sensor", [0, 1, 2])
@pytest.mark.parametrize("factor", [0.0, 2.0])
def test_one_inconsistent_sensor_takes_all_validity(sensor: int, factor: float) -> None:
    judge = health()
    last(judge, 30.0)
    nis = FINE.copy()
    nis[3 * sensor : 3 * sensor + 3] = factor
    verdict = last(judge, 10.0, nis=nis)
    assert not any(verdict.valid)
    assert verdict.nis[sensor] == pytest.approx(1.0 + (factor - 1.0) * -math.expm1(-1.0), rel=0.06)


@pytest.mark.parametrize("sensor", [0, 1, 2])
def test_innovations_surprise_where_they_are_greater_and_not_where_they_are_less(sensor: int) -> None:
    for factor, surprised in ((0.05, False), (1.0, False), (2.0, True)):
        judge, nis = health(), FINE.copy()
        last(judge, 30.0)
        nis[3 * sensor : 3 * sensor + 3] = factor
        last(judge, 10.0, nis=nis)
        assert judge.trusted == (factor == 1.0)
        assert judge.surprised == surprised


def test_the_slack_lets_variances_be_known_no_better() -> None:
    for slack, valid in ((0.0, False), (0.2, True)):
        assert all(last(health(nis_slack=slack), 30.0, nis=1.15 * FINE).valid) == valid
        assert all(last(health(nis_slack=slack), 30.0, nis=0.87 / CAREFUL * FINE).valid) == valid


def test_innovations_that_are_chance_are_consistent_and_twice_as_much_is_seen_at_once() -> None:
    """DVL at 5 Hz, gyros and attitude at 100 Hz, each innovation of its own variance."""
    rng = np.random.default_rng(5)
    judge, ticks = health(nis_slack=0.0), 20 * 60 * 100
    drawn = rng.chisquare(1.0, (ticks, 9))
    drawn[np.arange(ticks) % 20 != 0, :3] = math.nan
    valid = np.array([step(judge, nis=row).valid[0] for row in drawn])
    begins = np.flatnonzero(np.diff(valid.astype(int)) == 1)
    assert valid[3000:].mean() > 0.98
    assert len(begins) <= 4
    assert not all(step(judge, nis=row).valid[0] for row in 2.0 * drawn[:300])


def test_a_sensor_that_falls_silent_is_unknown_and_does_not_count() -> None:
    judge = health()
    last(judge, 30.0)
    nis = FINE.copy()
    nis[:3] = 3.0
    step(judge, nis=nis)
    nis[:3] = math.nan
    verdict = last(judge, 60.0, nis=nis)
    assert math.isnan(verdict.nis[0])
    assert verdict.nis[1:] == pytest.approx((1.0, 1.0))
    assert all(verdict.valid)
    assert not any(last(judge, 60.0, nis=SILENT).valid)


def test_an_outlier_is_forgotten_with_the_window() -> None:
    judge = health(nis_time=1.0)
    last(judge, 10.0)
    for wild in (1e300, math.inf):
        step(judge, nis=np.full(9, wild))
        assert all(last(judge, 15.0).valid)


@pytest.mark.parametrize(
    ("name", "nu", "fin", "row"),
    [
        ("M_q", (1.83, 0, 0, 0, 0.1, 0), {}, 4),
        ("M_ds", CRUISE, {"delta_s": 0.1}, 4),
        ("Z_q", (1.83, 0, 0, 0, 0.1, 0), {}, 2),
        ("Y_v", (1.83, 0.2, 0, 0, 0, 0), {}, 1),
        ("N_dr", CRUISE, {"delta_r": 0.1}, 5),
    ],
)
def test_excitation_is_the_acceleration_that_the_coefficient_makes(name: str, nu, fin, row: int) -> None:
    """Taken from the equations of motion: what changes when the coefficient is not there."""
    inputs = np.array([fin.get("delta_s", 0.0), fin.get("delta_r", 0.0), 0.0, 8.33])
    x = MODEL.state(nu, (0.0, 0.0, 0.0))
    there = MODEL.rates(x, inputs)[row]
    x[MODEL.place(name)] = 0.0
    made = abs(there - MODEL.rates(x, inputs)[row])
    key = "rate_gain" if row >= 3 else "speed_gain"
    for seen, excited in ((0.99 * made, True), (1.01 * made, False)):
        verdict = last(health(**{key: seen}), 100.0, y=forces(nu, **fin))
        assert verdict.excited[NAMES.index(name)] == excited


def test_it_is_told_whenever_what_is_excited_or_informative_changes() -> None:
    judge, was = hasty(), ((False,) * len(NAMES),) * 2
    changes = 0
    for k in range(1200):
        share = UNSURE if k % 400 < 300 else 0.001
        told = judge.update(DT, share * SCALE, BUSY if k % 300 < 150 else QUIET, FINE)
        now = judge.verdict.excited, tuple(judge.informative.tolist())
        assert told == (now != was)
        was, changes = now, changes + told
    assert changes >= 6


@pytest.mark.parametrize("share", [2.0 * UNSURE, UNSURE, 0.5 * UNSURE, 0.1 * UNSURE])
def test_what_is_known_better_is_taught_only_by_as_much_greater_accelerations(share: float) -> None:
    """In closed loop fins move by the noise of the sensors: little of it tells nothing, and teaches what is wrong."""
    least = max(1.0, UNSURE / share)
    for amplitude, informative in ((0.99 * least, False), (1.01 * least, True)):
        judge = health(rate_gain=M_DS_MADE)
        verdict = last(judge, 100.0, share, y=forces(delta_s=amplitude))
        assert judge.informative[M_DS] == informative
        assert verdict.excited[M_DS] == (amplitude > 1.0)


def test_what_is_valid_needs_only_excitation_and_a_reset_leaves_what_is_informative() -> None:
    judge = hasty(speed_gain=0.05, rate_gain=1.0)
    last(judge, 2.0, CERTAIN)
    sure = 0.01
    verdict = last(judge, 2.0, sure)
    weak = [i for i, told in enumerate(judge.informative) if verdict.excited[i] and not told]
    assert weak
    judge.reset()
    before = judge.informative.copy()
    assert not any(judge.verdict.valid)
    verdict = last(judge, 3.0, sure)
    assert all(verdict.valid[i] for i in weak)
    assert list(judge.informative) == list(before)


def test_until_the_filter_has_settled_nothing_adds_to_excitation_and_what_was_excited_stays_so() -> None:
    judge = health(settle=8.0)
    assert not any(last(judge, 7.9).excited)
    excited = last(judge, 20.0).excited
    assert all(excited)
    judge.reset()
    assert last(judge, 7.9, y=QUIET).excited == excited
    assert not any(last(judge, 150.0, y=QUIET).excited)


def test_each_motion_excites_its_own_coefficients() -> None:
    for y, expected in (
        (QUIET, set()),
        (forces(delta_s=0.2), {"M_ds", "Z_ds"}),
        (forces(delta_r=0.2), {"N_dr", "Y_dr"}),
        (forces((1.83, 0, 0, 0, 0, 0.15)), {"N_r", "Y_r", "C_dy"}),
    ):
        verdict = last(health(), 30.0, y=y)
        found = {name for name, excited in zip(NAMES, verdict.excited, strict=True) if excited}
        assert found - {"N_dot"} == expected  # what is accelerated depends on all forces


def test_excitation_is_an_rms_with_hysteresis() -> None:
    """A fin that swings by A has the RMS A / sqrt(2); what begins at that stays down to half of it."""

    def swing(judge: CoefficientValidity, amplitude: float) -> Validity:
        for k in range(10_000):
            y = forces(delta_s=amplitude * math.sin(0.5 * math.pi * k * DT))
            verdict = judged(judge, SCALE, y, FINE)
        return verdict

    judge = health(rate_gain=M_DS_MADE)
    for amplitude, excited in ((1.3, False), (1.5, True), (0.8, True), (0.6, False), (1.3, False)):
        assert swing(judge, amplitude).excited[M_DS] == excited


@given(st.lists(st.sampled_from([math.nan, math.inf, -math.inf, 1e200, 0.0]), min_size=1, max_size=20))
def test_numbers_that_are_none_excite_nothing_make_nothing_valid_and_leave_nothing_behind(odd: list[float]) -> None:
    judge = hasty(settle=0.0)
    last(judge, 2.0)
    for value in odd:
        wild = judged(judge, np.full(len(NAMES), math.nan), np.full(len(BUSY), value), np.full(9, value))
        assert not any(wild.valid)
    assert all(map(math.isfinite, itertools.chain(judge.freeze().level, *judge.freeze().window)))
    last(judge, 3.0, y=QUIET)
    verdict = last(judge, 3.0)
    assert all(verdict.valid)
    assert all(verdict.excited)


@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_it_goes_on_where_it_was_frozen(seed: int, at: int) -> None:
    rng = np.random.default_rng(seed)
    rows = [
        (rng.uniform(0.0, 0.3) * SCALE, BUSY if rng.random() < 0.7 else QUIET, rng.chisquare(1.0, 9)) for _ in range(80)
    ]
    one, other = hasty(), hasty()
    for k, row in enumerate(rows):
        if k == at:
            other.thaw(one.freeze())
        if k == 40:
            one.reset()
            other.reset()
        changed = one.update(DT, *row)
        assert k < at or (other.update(DT, *row), other.verdict) == (changed, one.verdict)
    assert one.freeze() == other.freeze()


@pytest.mark.parametrize(
    ("freedom", "low", "high"),
    [(30, 16.791, 46.979), (60, 40.482, 83.298), (100, 74.222, 129.561)],  # tables of chi-square: 2.5 % and 97.5 %
)
def test_the_band_is_that_of_the_tables(freedom: float, low: float, high: float) -> None:
    assert np.array(band(freedom, ENTER)) * freedom == pytest.approx((low, high), rel=2e-3)


@pytest.mark.parametrize("freedom", [60, 300, 6000])
def test_the_wide_band_holds_all_but_one_in_a_thousand(freedom: int) -> None:
    drawn = np.random.default_rng(1).chisquare(freedom, 400_000) / freedom
    low, high = band(freedom, STAY)
    assert np.mean((drawn < low) | (drawn > high)) == pytest.approx(1e-3, rel=0.2)


def test_thresholds_the_wrong_way_round_are_refused() -> None:
    with pytest.raises(ParamError, match="invalid_std must be greater than valid_std"):
        ValidityParams(valid_std=0.2, invalid_std=0.2)
