"""A current that changes is no reason for wrong coefficients, nor for none."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
import pytest

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.doubted_water import FRONT_TIME, FRONT_WALK, DoubtedWater
from firmware_py.estimation.doubts import Doubts
from firmware_py.estimation.model.state import CURRENT_EAST, CURRENT_NORTH
from firmware_py.records.estimate import Learned
from tests.estimation.cases import VEHICLE
from tests.estimation.flights import flown, learner, moments, said

BEGINS, SECONDS = 25.0, 60.0
TRUE = np.array([getattr(VEHICLE.coefficients, name) for name in TEN])
FRONTS = ((-0.5, 3.0), (-0.3, 10.0), (0.3, 30.0))
"""By so much, m/s, in so long, s."""


@functools.cache
def front(change: float, lasts: float, north: bool) -> Callable[[float], tuple[float, float, float]]:
    def current(t: float) -> tuple[float, float, float]:
        now = change * min(1.0, max(0.0, (t - BEGINS) / lasts))
        return (now, 0.0, 0.0) if north else (0.0, now, 0.0)

    return current


@functools.cache
def learned(change: float, lasts: float, north: bool) -> list[Learned]:
    """What is said each second of a flight in which the current changes."""
    return said(learner(), moments(flown(SECONDS, current=front(change, lasts, north))))[99::100]


def sigmas(one: Learned) -> np.ndarray:
    """How far the valid values are from the truth, in their sigmas."""
    return (np.abs(np.array(one.value) - TRUE) / np.array(one.std))[np.array(one.valid)]


@pytest.mark.parametrize("north", [True, False])
@pytest.mark.parametrize(("change", "lasts"), FRONTS)
def test_the_current_is_followed_and_coefficients_are_valid_again(change: float, lasts: float, north: bool) -> None:
    last = learned(change, lasts, north)[-1]
    there = change if north else 0.0, 0.0 if north else change
    for found, std, true in zip(last.current, last.current_std, there, strict=True):
        assert abs(found - true) < max(0.03, 2.0 * std)
    assert max(last.current_std) < 0.1
    assert sum(last.valid) >= 4


def test_one_valid_value_of_a_hundred_at_most_is_beyond_four_sigma() -> None:
    far = np.concatenate([sigmas(one) for way in FRONTS for north in (True, False) for one in learned(*way, north)]) > 4
    assert far.size > 1000
    assert far.mean() <= 0.01


@pytest.fixture
def ekf() -> CoefficientEkf:
    return CoefficientEkf(VEHICLE, CoefficientParams())


def walk(ekf: CoefficientEkf) -> float:
    """How the current walks in all filters alike, m/s by sqrt(s)."""
    (noise,) = {filters.tuning.Q_final[i] for filters in ekf.banks for i in (CURRENT_NORTH, CURRENT_EAST)}
    return float(noise) ** 0.5


def doubts(ekf: CoefficientEkf) -> DoubtedWater:
    water = DoubtedWater(ekf)
    ekf.iterated[:] = True
    water.update(1.0, True, False, 0.0)
    assert walk(ekf) == 0.0
    return water


@pytest.mark.parametrize("sign", ["burst", "innovations", "rejected", "eddies"])
def test_each_sign_lets_the_current_change_for_a_while(ekf: CoefficientEkf, sign: str) -> None:
    water = doubts(ekf)
    if sign == "burst":
        ekf.bursts += 1
    elif sign == "rejected":
        ekf.iterated[:] = False
    for t in np.arange(2.0, 2.0 + FRONT_TIME, 0.1):
        surprised = sign == "innovations"
        water.update(t, not surprised, surprised, 0.06 if sign == "eddies" else 0.0)
        assert walk(ekf) == pytest.approx(FRONT_WALK)
    water.update(2.0 + FRONT_TIME, not surprised, surprised, 0.06 if sign == "eddies" else 0.0)
    assert walk(ekf) == 0.0


def test_innovations_that_are_less_than_they_should_be_are_no_sign(ekf: CoefficientEkf) -> None:
    """So they are whenever another coefficient begins to learn, with the noise of a start-up."""
    water = doubts(ekf)
    water.update(2.0, False, False, 0.0)
    assert walk(ekf) == 0.0


def test_eddies_that_were_there_before_are_no_sign(ekf: CoefficientEkf) -> None:
    water = DoubtedWater(ekf)
    for confirmed, turbulence in ((False, 0.0), (False, 0.1), (True, 0.05), (True, 0.01), (True, 0.1)):
        ekf.iterated[:] = confirmed
        water.update(2.0, True, False, turbulence)
        assert walk(ekf) == 0.0


def test_what_acts_through_the_flow_is_not_learned_while_nobody_knows_its_speed(ekf: CoefficientEkf) -> None:
    doubt = Doubts(ekf, VEHICLE)
    assert not any(map(doubt.holds, TEN))
    ekf.iterated[:] = True
    doubt.water.update(1.0, True, False, 0.0)
    ekf.bursts += 1
    doubt.water.update(2.0, True, False, 0.0)
    assert [name for name in TEN if not doubt.holds(name)] == ["M_ds", "N_dr", "Z_ds", "Y_dr"]
    doubt.water.update(2.0 + FRONT_TIME, True, False, 0.0)
    assert not any(map(doubt.holds, TEN))


def test_it_goes_on_where_it_was(ekf: CoefficientEkf) -> None:
    water = doubts(ekf)
    ekf.bursts += 1
    water.update(2.0, True, False, 0.0)
    other = CoefficientEkf(VEHICLE, CoefficientParams())
    other.thaw(ekf.freeze())
    again = DoubtedWater(other)
    again.thaw(water.freeze())
    assert walk(other) == pytest.approx(FRONT_WALK)
    again.update(2.0 + FRONT_TIME, True, False, 0.0)
    assert walk(other) == 0.0
