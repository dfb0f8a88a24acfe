"""What learning manoeuvres do with the fins: sequences that tell stern planes from rudder."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.guidance.excitation import PERIOD, Sides, doublets, opposite, prbs, put_over, sides
from firmware_py.records.mission import Manoeuvre, ManoeuvreKind

REGISTERS = st.integers(1, PERIOD)


def chips(register: int) -> np.ndarray:
    return np.array([prbs(k, 1, register) for k in range(PERIOD)])


@given(REGISTERS)
def test_a_maximal_sequence_is_balanced_and_unlike_itself_at_every_shift(register: int) -> None:
    values = chips(register)
    assert abs(values.sum()) == 1.0
    assert {float(values @ np.roll(values, shift)) for shift in range(1, PERIOD)} == {-1.0}
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate([values, values]))))
    assert runs.max() == 7  # the longest that a register of seven bits gives


@given(REGISTERS, st.integers(1, 400), st.integers(0, 100_000))
def test_each_value_is_held_for_a_clock_and_the_period_returns(register: int, clock: int, k: int) -> None:
    value = prbs(k, clock, register)
    assert value in (1.0, -1.0)
    assert value == prbs(k - k % clock, clock, register)
    assert value == prbs(k + PERIOD * clock, clock, register)


def test_every_register_begins_elsewhere() -> None:
    assert len({tuple(chips(register)) for register in range(1, PERIOD + 1)}) == PERIOD


@given(REGISTERS)
def test_rudder_and_stern_planes_have_nothing_in_common_within_half_a_period(register: int) -> None:
    planes, rudder = chips(register), chips(opposite(register))
    for lag in range(-60, 61):
        assert abs(planes @ np.roll(rudder, lag)) == 1.0


def test_doublets_move_one_at_a_time_there_and_back() -> None:
    flown = np.array([doublets(k, 5) for k in range(60)])
    assert not (flown[:, 0] * flown[:, 1]).any()
    assert not flown.sum(axis=0).any()
    assert np.abs(flown).sum(axis=1) == pytest.approx(1.0)
    assert flown[:20].tolist() == flown[20:40].tolist()


@given(st.sampled_from([1.0, -1.0]), st.floats(-0.5, 0.5), st.floats(0.01, 0.4))
def test_a_zigzag_fin_goes_against_what_has_gone_too_far_and_else_stays(side: float, off: float, limit: float) -> None:
    after = put_over(side, off, limit)
    if abs(off) >= limit:
        assert after * off > 0.0  # a positive angle lowers pitch and heading
    else:
        assert after == side


def test_a_zigzag_swings_between_its_limits_at_a_period_of_each_axis_own() -> None:
    manoeuvre = Manoeuvre(ManoeuvreKind.ZIGZAG, pitch=math.radians(5.0), heading=math.radians(20.0))
    at, pitch, heading, seen = Sides(1.0, 1.0), 0.0, 0.0, []
    for k in range(6000):
        at = sides(manoeuvre, k, 0.01, at, pitch, heading)
        pitch -= 0.01 * 0.02 * at.s
        heading -= 0.01 * 0.05 * at.r
        seen.append((pitch, heading, *at))
    flown = np.array(seen)
    assert np.abs(flown[:, 0]).max() == pytest.approx(math.radians(5.0), abs=5e-4)
    assert np.abs(flown[:, 1]).max() == pytest.approx(math.radians(20.0), abs=1e-3)
    executes = np.count_nonzero(np.diff(flown[:, 2:], axis=0), axis=0)
    assert executes.tolist() == [7, 4]  # ways of 5 and then 10 deg at 0.02 rad/s; of 20 and then 40 at 0.05


@pytest.mark.parametrize("dt", [0.02, 0.01, 0.005])
def test_the_clock_is_time_at_any_rate_of_the_loop(dt: float) -> None:
    manoeuvre = Manoeuvre(ManoeuvreKind.PRBS, clock=1.5, register=77)
    at = [sides(manoeuvre, k, dt, Sides(1.0, 1.0), 0.0, 0.0) for k in range(round(60.0 / dt))]
    assert at[:: round(1.5 / dt)] == [Sides(prbs(i, 1, 77), prbs(i, 1, opposite(77))) for i in range(40)]
