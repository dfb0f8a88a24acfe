"""Headings are judged by the vehicle in force: as it was learned, and no more surely than it is known."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.model_check import ModelCheck
from firmware_py.estimation.integrity.motion_model import MotionModel
from firmware_py.estimation.integrity.steady_turn import steady_turn_std
from firmware_py.vehicle.linear_models import SteeringCoefficients, steering_coefficients
from firmware_py.vehicle.turning import steady_turn, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

from .voyage import AT_U, DEG, VEHICLE

N, U = 492.0 / 60.0, 1.8
TRUE = steering_coefficients(VEHICLE)
STD = [0.7 * abs(x) for x in TRUE]
KNOWN = [0.04 * abs(x) for x in TRUE]
CIRCLES = {"Y_v": 0.5, "Y_r": 0.5, "Y_dr": 1.5, "N_v": 1.5, "N_r": 0.5, "N_dr": 1.5}
"""A file whose hull does not hold its course by itself."""
SLOW = {"Y_v": 0.3, "Y_r": 1.7, "Y_dr": 1.7, "N_v": 1.7, "N_r": 0.3, "N_dr": 1.7}
"""One whose hull hardly does: its turns take far longer than the true one's."""


def wrong(factors: dict[str, float]) -> Vehicle:
    c = VEHICLE.coefficients
    return replace(VEHICLE, coefficients=replace(c, **{n: f * getattr(c, n) for n, f in factors.items()}))


def track(t: float) -> float:
    """Return the rudder that turns to and fro by 25 deg every 14 s."""
    return 6.0 * DEG * (1.0 if t % 28.0 < 14.0 else -1.0) if t % 14.0 < 6.0 else 0.0


def swim(check: ModelCheck, seconds: float, hull: MotionModel | None = None, drift: float = 0.0) -> bool:
    """Let the true hull steer for a while, as `check` sees it; return whether its heading was accused."""
    if hull is None:
        hull = MotionModel(VEHICLE)
        hull.memory.u = U
    check.hear_speed(AT_U, 0.0, 0.0)
    accused = False
    for k in range(round(seconds * 10)):
        fins = [0.0, 0.0, track(0.1 * k), track(0.1 * k)]
        hull.step(0.1, N, 0.0, *hull.deflections(fins))
        check.hear_rate(hull.memory.r + drift * DEG)
        check.step(0.1, N, 0.0, fins, True, True, True)
        accused = accused or check.heading_drifts
    return accused


def doubted(factors: dict[str, float]) -> ModelCheck:
    check = ModelCheck(IntegrityParams(), wrong(factors))
    check.doubt([abs(f) * s for f, s in zip(factors.values(), STD, strict=True)])
    return check


@pytest.mark.parametrize("factors", [CIRCLES, SLOW], ids=["unstable", "slow"])
def test_a_file_that_is_wrong_accuses_no_sound_heading(factors: dict[str, float]) -> None:
    assert not swim(doubted(factors), 180.0)


@pytest.mark.parametrize("factors", [CIRCLES, SLOW], ids=["unstable", "slow"])
def test_what_was_learned_tells_a_heading_that_lies_and_accuses_no_other(factors: dict[str, float]) -> None:
    check, hull = doubted(factors), MotionModel(VEHICLE)
    hull.memory.u = U
    assert not swim(check, 28.0, hull)
    check.follow(TRUE, KNOWN)
    assert not swim(check, 84.0, hull)
    assert swim(check, 60.0, hull, drift=1.0)


def test_a_vehicle_that_does_not_know_itself_tells_a_heading_that_lies_if_its_file_is_right() -> None:
    check = doubted(dict.fromkeys(TRUE._fields, 1.0))
    assert not swim(check, 28.0)
    assert swim(check, 80.0, drift=1.0)


def test_values_that_are_known_less_well_are_not_followed() -> None:
    check = doubted(dict.fromkeys(TRUE._fields, 1.0))
    before = check.freeze()
    check.follow(SteeringCoefficients(*[2.0 * x for x in TRUE]), [2.0 * abs(x) for x in TRUE])
    assert check.freeze() == before


def test_memory_keeps_the_vehicle_that_was_followed() -> None:
    check, other = doubted(SLOW), doubted(SLOW)
    check.follow(TRUE, KNOWN)
    swim(check, 30.0)
    other.thaw(check.freeze())
    for one in (check, other):
        swim(one, 10.0)
    assert check.freeze() == other.freeze()


def test_a_steady_turn_is_as_unsure_as_its_coefficients() -> None:
    """G has N_dr Y_v - Y_dr N_v above the line, of which the first is 87 %."""
    hull, aside = MotionModel(VEHICLE), steady_turn(yaw_axis(VEHICLE, TRUE))
    hull.memory.u = U
    for _ in range(600):
        hull.step(0.1, N, 0.0, 0.0, 0.2 * DEG)
    assert hull.memory.r == pytest.approx(aside * hull.memory.u * 0.2 * DEG, rel=0.02)
    rudder = [0.0, 0.0, 0.0, 0.0, 0.0, 0.1 * abs(TRUE.N_dr)]
    assert steady_turn_std(VEHICLE, TRUE, rudder) == pytest.approx(0.087, abs=0.005)
    assert steady_turn_std(VEHICLE, TRUE, [0.0] * 6) == 0.0
    assert steady_turn_std(wrong(CIRCLES), steering_coefficients(wrong(CIRCLES)), STD) == math.inf
