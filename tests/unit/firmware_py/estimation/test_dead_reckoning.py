"""The arithmetic of dead reckoning and fixes, by hand; and the pressure's zero among noise."""

from __future__ import annotations

import math
import random

import pytest

from firmware_py.estimation.navigation import dead_reckoning, depth
from firmware_py.marine import Origin, local_to_geodetic
from firmware_py.records.sensing import Fix, Heard

PARAMS = dead_reckoning.PositionParams()
ORIGIN = Origin(0.9, 0.2)


def fix(x: float, y: float, t: float, std: float) -> Heard[Fix]:
    return Heard(Fix(*local_to_geodetic(ORIGIN, x, y), std), t, True, True)


def test_drift_is_made_of_heading_scale_and_bias() -> None:
    # 2 m/s: 1 deg and 0.5 % of it are 0.034907 and 0.010 m/s, root of the squares 0.036311; bias on two axes 0.002828
    assert dead_reckoning.drift_rate(PARAMS, 2.0, True) == pytest.approx(0.039139, abs=1e-6)
    assert dead_reckoning.drift_rate(PARAMS, 0.0, True) == pytest.approx(0.002828, abs=1e-6)
    assert dead_reckoning.drift_rate(PARAMS, 2.0, False) == pytest.approx(2.002853, abs=1e-6)


def test_before_any_fix_sigma_is_the_declared_one() -> None:
    assert dead_reckoning.std(dead_reckoning.start(PARAMS)) == 100.0
    assert dead_reckoning.std(dead_reckoning.PositionMemory(0.0, 0.0, 16.0, 3.0, 0.0)) == 5.0


def test_a_fix_weighs_by_walk_and_drift_against_its_own_sigma() -> None:
    was = dead_reckoning.PositionMemory(0.0, 0.0, 4.0, 3.0, 0.0)  # variance 13, the fix's 2 x 2^2 = 8
    now = dead_reckoning.take_fix(PARAMS, was, fix(2.1, -4.2, 5.0, 2.0), 5.0, ORIGIN, (9.0, 9.0))
    assert (now.x, now.y) == (pytest.approx(1.3, abs=1e-6), pytest.approx(-2.6, abs=1e-6))
    assert dead_reckoning.std(now) == pytest.approx(math.sqrt(13.0 * 8.0 / 21.0))
    assert (now.drift, now.t_fix) == (0.0, 5.0)
    assert dead_reckoning.take_fix(PARAMS, now, fix(0.0, 0.0, 5.0, 2.0), 5.0, ORIGIN, (0.0, 0.0)) == now


def test_a_vehicle_that_was_carried_since_follows_the_first_fix_and_a_wild_fix_is_refused() -> None:
    was = dead_reckoning.PositionMemory(147.0, -20.0, 0.25, 0.0, -math.inf)  # kept from the last flight
    now = dead_reckoning.take_fix(PARAMS, was, fix(0.0, 0.0, 1.0, 2.0), 1.0, ORIGIN, (0.0, 0.0))
    assert math.hypot(now.x, now.y) < 0.1
    assert 2.5 < dead_reckoning.std(now) < math.sqrt(8.0)
    wild = dead_reckoning.take_fix(PARAMS, now, fix(500.0, 0.0, 2.0, 2.0), 2.0, ORIGIN, (0.0, 0.0))
    assert (wild.x, wild.y) == (now.x, now.y)
    back = dead_reckoning.take_fix(PARAMS, wild, fix(0.0, 0.0, 3.0, 2.0), 3.0, ORIGIN, (0.0, 0.0))
    assert math.hypot(back.x, back.y) < 0.1
    assert back.refused == 0


def test_fixes_that_agree_put_right_a_position_that_they_contradict_and_others_do_not() -> None:
    def after(*places: float) -> dead_reckoning.PositionMemory:
        memory = dead_reckoning.PositionMemory(0.0, 0.0, 0.25, 0.0, 0.0)
        for i, north in enumerate(places):
            memory = dead_reckoning.take_fix(PARAMS, memory, fix(north, 0.0, i + 1.0, 2.0), i + 1.0, ORIGIN, (0, 0))
        return memory

    assert after(300.0, 303.0).x == 0.0
    third = after(300.0, 303.0, 299.0)
    assert third.x == pytest.approx(299.0, abs=0.1)
    assert third.jump == pytest.approx(299.0, abs=0.1)
    assert dead_reckoning.std(third) < 3.0
    assert after(300.0, -200.0, 100.0, 500.0, -300.0).x == 0.0  # never two that agree
    assert abs(after(300.0, 303.0, 1.0, 301.0, 300.0).x) < 1.0  # one that fits begins the count anew


def lying_still(speed: float, seed: int) -> list[tuple[float, float]]:
    """How far off, m, and its sigma is a hull that lies still and is believed to make way, after each fix."""
    memory, noise, found = dead_reckoning.PositionMemory(0.0, 0.0, 4.0, 0.0, 0.0), random.Random(seed), []
    for t in range(1, 100):
        grown = memory.drift + 0.4 + memory.astray  # in a second
        measured = fix(noise.gauss(0.0, 2.0), noise.gauss(0.0, 2.0), t, 2.0)
        memory = memory._replace(x=memory.x + speed, drift=grown)
        memory = dead_reckoning.take_fix(PARAMS, memory, measured, t, ORIGIN, (speed, 0.0))
        found.append((math.hypot(memory.x, memory.y), dead_reckoning.std(memory)))
    return found


@pytest.mark.parametrize("seed", range(5))
def test_fixes_that_go_on_moving_it_to_one_side_show_a_wrong_velocity(seed: int) -> None:
    """A hull without blades lay still and was believed under way: 13.6 m off for minutes, at a sigma of 0.8 m."""
    at_first, later = lying_still(1.5, seed)[:10], lying_still(1.5, seed)[10:]
    assert max(off for off, _ in later) < 7.0
    assert max(off / sigma for off, sigma in (*at_first, *later)) < 5.5
    right = lying_still(0.0, seed)
    assert max(sigma for _, sigma in right[10:]) < 1.1  # what is right is worth as much as it was


def test_what_fixes_that_were_wrong_have_moved_it_by_is_taken_back() -> None:
    memory = dead_reckoning.PositionMemory(0.0, 0.0, 1.0, 0.0, 0.0)
    for t in range(1, 41):  # it makes 1 m/s; from 20 s on the receiver stands still
        memory = memory._replace(x=memory.x + 1.0, drift=memory.drift + 0.2)
        memory = dead_reckoning.take_fix(PARAMS, memory, fix(min(t, 20.0), 0.0, t, 2.0), t, ORIGIN, (1.0, 0.0))
    assert 40.0 - memory.x > 3.0 * dead_reckoning.std(memory)
    back = dead_reckoning.take_back(PARAMS, memory, 20.0)
    assert back.x == pytest.approx(40.0, abs=0.5)
    assert abs(40.0 - back.x) < dead_reckoning.std(back) < 10.0
    assert dead_reckoning.take_back(PARAMS, back, 20.0) == back  # once


def test_a_late_fix_is_moved_along_both_axes() -> None:
    was = dead_reckoning.PositionMemory(0.0, 0.0, 1e12, 0.0, 0.0)
    now = dead_reckoning.take_fix(PARAMS, was, fix(10.0, 20.0, 4.5, 0.5), 5.0, ORIGIN, (1.0, -2.0))
    assert (now.x, now.y) == (pytest.approx(10.5, abs=1e-6), pytest.approx(19.0, abs=1e-6))


@pytest.mark.parametrize(("latitude", "longitude"), [(1.6, 0.2), (0.9 + math.tau, 0.2), (0.9, 0.2 + 2 * math.tau)])
def test_no_place_on_earth_is_no_fix(latitude: float, longitude: float) -> None:
    was = dead_reckoning.start(PARAMS)
    assert (
        dead_reckoning.take_fix(PARAMS, was, Heard(Fix(latitude, longitude, 2.0), 1.0, True, True), 1.0, ORIGIN, (0, 0))
        == was
    )


def test_the_zero_is_an_average() -> None:
    params = depth.DepthParams()
    memory = depth.start(params)
    for i in range(200):  # 20 Hz, +-100 Pa about 500 Pa of weather
        reading = Heard(101325.0 + 500.0 + (100.0 if i % 2 else -100.0), i * 0.05, True, True)
        memory = depth.update(params, memory, reading, i * 0.05, 0.05, 0.0, 0.0, armed=False)
    assert memory.zero == pytest.approx(101825.0, abs=5.0)
    assert memory.z == pytest.approx(0.0, abs=0.002)
