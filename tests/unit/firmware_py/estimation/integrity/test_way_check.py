"""A DVL against fixes at the surface: what it is off by, whatever the current, and how long that is remembered."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.estimation.integrity.way_arbitration import Wrong
from firmware_py.estimation.integrity.way_check import WayCheck
from firmware_py.estimation.navigation.velocity import Current, HullVelocity
from firmware_py.marine import Origin, local_to_geodetic
from firmware_py.records.sensing import Dvl, Fix

STD, U = 2.5, 1.2
ORIGIN = Origin(0.9, 0.2)
NOWHERE = Current(0.0, 0.0, math.inf, -math.inf)
HULL = HullVelocity(U, 0.0, NOWHERE)


def drive(
    check: WayCheck,
    seconds: int,
    *,
    current: tuple[float, float] = (0.0, 0.0),
    lie: float = 0.0,
    walk: float = 0.0,
    off: float = 0.0,
    turning: float = 0.02,
    speed: float = U,
    compass: float = 0.0,
    rate: int = 1,
    std: float = STD,
    seed: int = 0,
    begin: int = 0,
    since: float = 0.0,
    aside: float = 0.0,
    dvl: bool = True,
    silent: bool = False,
    wrong: Wrong = Wrong.DVL,
) -> float:
    """Drive at the surface and hear `rate` fixes a second; when `wrong` was told first, s, infinite if never.

    The DVL's u is off by `lie`; not `dvl`: there is none. Fixes have the sigma `std`, m, walk to the north at `walk`
    and to the east at `aside`, m/s, from `since`, s, on, and are off by `off`, m; `silent`: there were none before. The
    vehicle does `speed`, m/s, through the water and turns at `turning`, rad/s; the heading is off by `compass`, rad.
    """
    noise, first = np.random.default_rng([seed, begin]), math.inf
    north, east = begin * (speed + current[0]), begin * current[1]
    for k in range(begin * 20, (begin + seconds) * 20):
        t = k / 20.0
        if k % (20 // rate) == 0:
            walked = max(0.0, t - since)
            fix_n, fix_e = north + walk * walked + off, east + aside * walked
            fix_n, fix_e = fix_n + noise.normal(0.0, std), fix_e + noise.normal(0.0, std)
            fix = Fix(*local_to_geodetic(ORIGIN, fix_n, fix_e), std)
            if check.hear(fix, t, silent=silent and k == begin * 20).wrong is wrong:
                first = min(first, t)
        psi = turning * t
        s, c = math.sin(psi), math.cos(psi)
        ping = speed + current[0] * c + current[1] * s, current[1] * c - current[0] * s
        north, east = north + (ping[0] * c - ping[1] * s) / 20.0, east + (ping[0] * s + ping[1] * c) / 20.0
        told = (ping[0] + lie, ping[1]) if dvl else None
        check.carry(0.05, psi + compass, 0.0, told, HullVelocity(speed, 0.0, NOWHERE))
    return first


def wrong_under_water(check: WayCheck, psi: float, current: tuple[float, float], lie: float) -> bool:
    s, c = math.sin(psi), math.cos(psi)
    ping = Dvl(U + lie + current[0] * c + current[1] * s, current[1] * c - current[0] * s, 0.0, 0.01, 20.0)
    return check.still_wrong(ping, psi, HULL)


@pytest.mark.parametrize("lie", [-1.5, -0.8, 0.8, 1.5])
@pytest.mark.parametrize("seed", range(4))
def test_a_dvl_that_is_off_is_wrong_before_anything_believes_it(lie: float, seed: int) -> None:
    at = drive(WayCheck(), 30, lie=lie, current=(0.1, -0.2), seed=seed)
    assert at <= (15.0 if abs(lie) > 1.0 else 25.0)


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.integers(0, 10**6))
def test_no_current_makes_a_sound_one_wrong(north: float, east: float, seed: int) -> None:
    check = WayCheck()
    assert drive(check, 40, current=(north, east), seed=seed) == math.inf
    assert (check.memory.lies, check.memory.doubt) == (0.0, 0.0)  # nor a sound receiver


@pytest.mark.parametrize("current", [(0.0, 0.0), (0.3, 0.2), (-0.3, 0.0)])
@pytest.mark.parametrize("seed", range(4))
def test_a_receiver_that_stands_still_is_wrong_where_propeller_and_dvl_drive_on(
    current: tuple[float, float], seed: int
) -> None:
    still = {
        "walk": -U - current[0],
        "aside": -current[1],
        "current": current,
        "turning": 0.0,
        "std": 1.0,
        "seed": seed,
    }
    assert drive(WayCheck(), 40, **still, wrong=Wrong.FIXES) <= 20.0
    assert drive(WayCheck(), 40, **still, wrong=Wrong.DVL) == math.inf


def on_the_way(seed: int, current: tuple[float, float]) -> WayCheck:
    """Return one that has heard 40 s of sound fixes."""
    check = WayCheck()
    drive(check, 40, current=current, turning=0.0, std=1.0, seed=seed)
    return check


@pytest.mark.parametrize("seed", range(6))
def test_of_two_that_agreed_the_one_whose_current_changes_is_wrong(seed: int) -> None:
    """Fixes that walk as fast as the water sets the vehicle back look like still water, and the DVL like a lie."""
    current = (-0.6, 0.0)
    walking = {"walk": 0.6, "since": 40.0, "begin": 40, "current": current, "turning": 0.0, "std": 1.0, "seed": seed}
    assert drive(on_the_way(seed, current), 40, **walking, wrong=Wrong.DVL) == math.inf
    assert drive(on_the_way(seed, current), 40, **walking, wrong=Wrong.FIXES) <= 70.0
    lying = {"lie": 0.6, "begin": 40, "current": current, "turning": 0.0, "std": 1.0, "seed": seed}
    assert drive(on_the_way(seed, current), 40, **lying, wrong=Wrong.FIXES) == math.inf
    assert drive(on_the_way(seed, current), 40, **lying, wrong=Wrong.DVL) <= 70.0


def test_a_receiver_that_was_wrong_stays_so_where_nothing_would_show_it_until_it_was_silent() -> None:
    check = WayCheck()
    assert drive(check, 40, walk=-U, turning=0.0, std=1.0, wrong=Wrong.FIXES) < 20.0
    assert drive(check, 60, begin=40, walk=-0.1, speed=0.1, turning=0.0, std=1.0) == math.inf
    assert check.memory.lies > 0.0  # at rest all receivers stand still
    drive(check, 5, begin=120, turning=0.0, std=1.0, silent=True)
    assert check.memory.lies == 0.0


def test_a_receiver_that_follows_again_is_believed_again() -> None:
    check = WayCheck()
    drive(check, 40, walk=-U, turning=0.0, std=1.0)
    drive(check, 40, begin=40, off=-40.0 * U, turning=0.0, std=1.0)
    assert check.memory.lies == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_where_nothing_tells_which_is_wrong_the_position_is_doubted_by_as_much_as_they_go_apart(seed: int) -> None:
    check, across = WayCheck(), {"aside": 0.6, "turning": 0.0, "std": 1.0, "seed": seed}
    assert drive(check, 60, **across, wrong=Wrong.DVL) == math.inf
    assert check.memory.lies == 0.0
    assert 0.3 * 36.0 < check.memory.doubt < 36.0
    drive(check, 20, begin=100, turning=0.0, std=1.0, seed=seed)  # other fixes, which agree
    assert check.memory.doubt == 0.0


@pytest.mark.parametrize(
    ("speed", "walk", "doubts"),
    [(1.8, -1.8, True), (1.0, -1.0, True), (1.8, 1.5, True), (1.8, -1.0, False), (1.0, 0.6, False)],
)
def test_without_dvl_nobody_is_convicted_but_a_current_that_hardly_can_be_is_doubted(
    speed: float, walk: float, doubts: bool
) -> None:
    check = WayCheck()
    fixes = {"walk": walk, "speed": speed, "turning": 0.0, "std": 1.0, "dvl": False}
    assert drive(check, 60, **fixes, wrong=Wrong.DVL) == math.inf
    assert check.memory.lies == 0.0
    assert (check.memory.doubt > 0.7 * abs(walk) * 60.0) is doubts
    assert (check.memory.doubt > 0.0) is doubts


@pytest.mark.parametrize("seed", range(4))
def test_fixes_that_walk_off_convict_no_dvl(seed: int) -> None:
    assert drive(WayCheck(), 40, walk=1.5, current=(0.1, 0.1), seed=seed) == math.inf


@pytest.mark.parametrize("current", [(0.6, 0.0), (0.5, 0.1)])
@pytest.mark.parametrize("seed", range(8))
def test_fixes_that_walk_off_against_a_current_convict_a_dvl_until_it_has_turned(
    current: tuple[float, float], seed: int
) -> None:
    check = WayCheck()
    drive(check, 24, walk=-0.6, current=current, turning=0.0, std=2.0, seed=seed)
    assert not any(wrong_under_water(check, psi, current, 0.0) for psi in (-1.6, 1.6, 3.0))


def test_some_such_fixes_do_convict_it() -> None:
    told = [drive(WayCheck(), 24, walk=-0.6, current=(0.6, 0.0), turning=0.0, std=2.0, seed=seed) for seed in range(8)]
    assert min(told) < 24.0


@pytest.mark.parametrize("jump", [3.0, 4.0, 6.0])
@pytest.mark.parametrize("at", [3, 5, 8])
def test_an_exact_receiver_that_jumps_convicts_no_dvl(jump: float, at: int) -> None:
    check, current = WayCheck(), (0.6, 0.0)
    assert drive(check, at, current=current, std=0.3, turning=0.0) == math.inf
    assert drive(check, 30, current=current, std=0.3, turning=0.0, begin=at, off=-jump) == math.inf


@pytest.mark.parametrize("turning", [0.2, 0.3, 0.4])
def test_circling_clears_no_dvl(turning: float) -> None:
    check = WayCheck()
    assert drive(check, 40, lie=0.8, turning=0.0) < 40.0
    lie = check.memory.lie
    drive(check, 60, lie=0.8, turning=turning, begin=40)
    assert check.memory.lie == pytest.approx(lie, abs=0.3)


@pytest.mark.parametrize("psi", [0.0, 1.6, 3.1])
@pytest.mark.parametrize("lie", [-0.5, 0.5])
@pytest.mark.parametrize("hull", [-0.15, 0.15])
def test_no_doubt_about_the_hull_clears_a_dvl_that_lies_on(psi: float, lie: float, hull: float) -> None:
    check = WayCheck()
    assert drive(check, 30, lie=lie, turning=0.0) < 30.0
    assert wrong_under_water(check, psi, (hull * math.cos(psi), hull * math.sin(psi)), lie)


@pytest.mark.parametrize("psi", [1.6, 3.1])
def test_a_hull_that_dives_faster_than_its_model_at_the_surface_clears_a_dvl_that_was_put_right(psi: float) -> None:
    check = WayCheck()
    assert drive(check, 30, lie=0.5, turning=0.0) < 30.0
    assert not wrong_under_water(check, psi, (0.3, 0.0), 0.0)


def test_under_water_it_is_wrong_on_every_heading_until_it_tells_of_the_current_that_the_fixes_told() -> None:
    check, current = WayCheck(), (0.2, -0.1)
    assert drive(check, 30, lie=-1.0, current=current) < 30.0
    check.carry(0.05, 0.0, 0.0, None, HULL)  # fixes and pings end
    for psi in np.linspace(-3.0, 3.0, 7).tolist():
        assert wrong_under_water(check, psi, current, -1.0)
        assert not wrong_under_water(check, psi, current, 0.0)
    assert check.still_wrong(Dvl(0.0, 0.0, 0.0, 0.01, 20.0), 0.0, None)
    check.clear()
    assert not wrong_under_water(check, 0.0, current, -1.0)


def test_at_the_surface_again_nothing_speaks_against_one_that_was_put_right() -> None:
    check = WayCheck()
    assert drive(check, 30, lie=1.0) < 30.0
    assert drive(check, 60, begin=200) == math.inf
    assert not wrong_under_water(check, 0.0, (0.0, 0.0), 0.0)


def test_thawed_it_goes_on_as_the_frozen_one() -> None:
    check, other = WayCheck(), WayCheck()
    drive(check, 9, lie=1.0)
    other.thaw(check.freeze())
    drive(check, 20, lie=1.0, begin=9)
    drive(other, 20, lie=1.0, begin=9)
    assert check.memory == other.memory


@pytest.mark.parametrize("current", [0.3, 0.6, 0.8])
@pytest.mark.parametrize("jump", [6.0, 9.0])
def test_fixes_that_jump_against_the_current_cost_a_sound_dvl_half_a_minute(current: float, jump: float) -> None:
    check, told = WayCheck(), []
    for t in range(0, 100, 2):
        told.append(drive(check, 2, current=(current, 0.0), begin=t, off=-jump if 30 <= t < 50 else 0.0, turning=0.0))
    assert all(at == math.inf or at < 80.0 for at in told)
    assert check.memory.lie == 0.0


@pytest.mark.parametrize("side", [-1.2, -0.8, -0.5, -0.3, 0.3, 0.5, 0.8, 1.2])
@pytest.mark.parametrize("compass", [8.0, 15.0, 20.0, 30.0])
@pytest.mark.parametrize("speed", [1.2, 1.8])
def test_a_compass_that_is_off_across_a_current_convicts_no_dvl(compass: float, side: float, speed: float) -> None:
    error = math.radians(compass)
    check = WayCheck()
    assert drive(check, 60, current=(0.0, side), speed=speed, turning=0.0, compass=error) == math.inf
    assert check.memory.lies == 0.0  # and no receiver


def test_a_receiver_that_tells_ten_fixes_a_second_tells_as_much() -> None:
    assert drive(WayCheck(), 30, lie=-1.0, rate=10) <= 20.0
