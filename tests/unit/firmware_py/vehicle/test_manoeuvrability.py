"""What is left of the vehicle's turning and diving, against brute force and against the plant."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from firmware_py.control.adoption import Adoption
from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.records.health import SOUND_FIN, FinEvidence, FinHealth
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel, reach
from firmware_py.vehicle.vehicle import Vehicle
from tests.unit.firmware_py.allocation.test_allocation import LAYOUTS, VEHICLE

FILE = Adoption(AdoptionParams(), ((0.1, 0.2), (0.3, 0.4)), (), VEHICLE).last
HALF = FinHealth(0.5, source=FinEvidence.MOTION)
HARD_OVER = math.radians(23.0)


def stuck(angle: float) -> FinHealth:
    return FinHealth(1.0, angle, FinEvidence.FEEDBACK)


def plus(**fins: FinHealth) -> tuple[FinHealth, ...]:
    return tuple(fins.get(name, SOUND_FIN) for name in ("port", "starboard", "upper", "lower"))


@pytest.mark.parametrize("vehicle", LAYOUTS.values(), ids=LAYOUTS.keys())
@pytest.mark.parametrize("angle", [None, 0.0, 0.2, -0.4])
def test_reach_is_the_most_that_any_fin_angles_make_with_the_other_axis_in_balance(
    vehicle: Vehicle, angle: float | None
) -> None:
    s, r = vehicle.effectiveness.s, vehicle.effectiveness.r
    limits = [fin.delta_max for fin in vehicle.fins]
    left = [SOUND_FIN] * len(s)
    if angle is not None:
        left[0] = stuck(angle)
    grid = [np.linspace(-1.0, 1.0, 41 if len(s) < 4 else 13) * most for most in limits[: min(len(s), 4)]]
    if angle is not None:
        grid[0] = np.array([angle])
    angles = np.array(list(itertools.product(*grid)))
    rows = np.array([s, r])[:, : angles.shape[1]]  # bow planes stay amidships here: less is reached, never more
    made = angles @ rows.T
    level = made[np.abs(made[:, 1]) < 1e-9]
    down, up = reach(s, r, limits, left)
    if len(level):
        assert up >= level[:, 0].max() - 1e-9
        assert down >= -level[:, 0].min() - 1e-9
        if angles.shape[1] == len(s) == 4 and angle in (None, 0.0):
            assert (down, up) == pytest.approx((-level[:, 0].min(), level[:, 0].max()))


def test_a_stuck_plane_leaves_less_to_one_side_and_more_to_the_other() -> None:
    s, r = VEHICLE.effectiveness.s, VEHICLE.effectiveness.r
    up, down = reach(s, r, [HARD_OVER] * 4, plus(port=stuck(math.radians(10.0))))
    assert np.degrees((up, down)) == pytest.approx((6.5, 16.5))


def test_rudders_that_are_both_stuck_leave_the_planes_what_they_do() -> None:
    s, r = VEHICLE.effectiveness.s, VEHICLE.effectiveness.r
    left = plus(upper=stuck(HARD_OVER), lower=stuck(HARD_OVER))
    assert np.degrees(reach(s, r, [HARD_OVER] * 4, left)) == pytest.approx((23.0, 23.0))
    assert reach(r, s, [HARD_OVER] * 4, left)[0] == 0.0


def test_a_sound_vehicle_is_limited_by_nothing_that_it_is_asked_for_today() -> None:
    able = ManoeuvrabilityModel(VEHICLE).of(FILE, ())
    assert (able.turn_left, able.up_left, able.dive_left) == (1.0, 1.0, 1.0)
    assert able.turn_radius < 20.0  # guidance.turn_radius
    assert able.slope > math.asin(0.5 / 1.8)  # guidance.climb_max at the cruising speed
    assert able.speed < 0.5  # control.u_min
    assert able.lost_height(0.3) == 0.0


def test_a_hull_that_does_not_hold_its_course_does_not_turn_as_asked_without_rudders() -> None:
    unstable = dataclasses.replace(VEHICLE, coefficients=dataclasses.replace(VEHICLE.coefficients, N_v=-0.1))
    model = ManoeuvrabilityModel(unstable)
    assert model.of(None, ()).turn == math.inf
    lost = FinHealth(0.0)
    able = model.of(None, plus(upper=lost, lower=lost))
    assert (able.turn, able.turn_left, able.turn_radius) == (0.0, 0.0, math.inf)


def test_half_an_axis_halves_what_is_left_whether_laws_know_of_it_or_not() -> None:
    model = ManoeuvrabilityModel(VEHICLE)
    whole = model.of(FILE, ())
    half = model.of(FILE, plus(port=HALF, starboard=HALF))
    assert half.up == pytest.approx(0.5 * whole.up)
    assert (half.up_left, half.turn_left) == pytest.approx((0.5, 1.0))
    assert half.speed == pytest.approx(math.sqrt(2.0) * whole.speed)
    assert half.pull_up(0.3) > whole.pull_up(0.3)
    assert half.lost_height(0.3) == pytest.approx(half.pull_up(0.3) - whole.pull_up(0.3))
    learned = dataclasses.replace(
        FILE, diving=(FILE.diving[0], 0.5 * FILE.diving[1]), held_diving=FILE.diving, held_steering=FILE.steering
    )
    assert model.of(learned, plus(port=HALF, starboard=HALF)).up == pytest.approx(half.up)  # not a quarter
    assert model.of(learned, ()).up == pytest.approx(half.up)


def test_a_vehicle_that_cannot_pull_up_or_turn_says_so() -> None:
    model = ManoeuvrabilityModel(VEHICLE)
    hard_over = model.of(FILE, plus(port=stuck(HARD_OVER), upper=stuck(-HARD_OVER)))
    assert (hard_over.up, hard_over.dive_left, hard_over.turn_left) == (0.0, 0.0, 0.0)
    assert hard_over.turn_radius == math.inf
    assert hard_over.lost_height(0.1) == 10.0
    assert hard_over.lost_height(-0.1) == 0.0
    assert math.isinf(hard_over.pull_up(0.1))
    assert hard_over.slope == 0.0
    assert hard_over.speed == 10.0
