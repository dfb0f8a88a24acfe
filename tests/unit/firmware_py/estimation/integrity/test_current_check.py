"""Pings against the filter's speed through the water: what is a current's change, and what only a DVL's fault."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from firmware_py.estimation.integrity.current_check import CurrentCheck
from firmware_py.estimation.navigation.velocity import Current, FilterVelocity, HullVelocity
from firmware_py.records.health import SourceFault
from firmware_py.records.sensing import Dvl, Heard
from tests.unit.firmware_py.estimation.integrity.voyage import VEHICLE

WALK, NORTH, EAST, T = 0.003, 0.1, 0.05, 0.2
DRAG = 0.0091
"""Of NPS AUV II, over its mass, 1/m."""
HULL = HullVelocity(1.75, 0.0, Current(NORTH, EAST, 0.004, 0.0))
"""Of a file that is not quite right: the vehicle makes 1.8 m/s."""
Told = list[tuple[float, SourceFault]]


def still(_: float) -> float:
    return 0.0


def fly(
    seconds: float,
    *,
    lie: Callable[[float], float] = still,
    sideways: Callable[[float], float] = still,
    water: Callable[[float], float] = still,
    stirred: Callable[[float], float] = still,
    thrust: Callable[[float], float] = lambda _: 1.8,
    filter_off: Callable[[float], float] = still,
    lost: Callable[[float], bool] = lambda _: False,
    heard: Callable[[float], bool] = lambda _: True,
    braked: Callable[[float], float] = still,
    afloat: float = 0.0,
    turbulence: float = 0.0,
    check: CurrentCheck | None = None,
) -> Told:
    """Fly to the north at 1.8 m/s and back; what the check says at each change of its mind.

    `water` is added to the current to the north and moves the hull by its drag, `stirred` moves it at once; `lie` and
    `sideways` are added to u and v of the pings. The filter does not know the speed that the propeller drives for,
    `thrust`, and is off by `filter_off`; the hull's model is `braked` by its fins, and off
    by as much as `afloat` where the bow is out of the water.
    """
    check, noise, told = check or CurrentCheck(WALK, VEHICLE), np.random.default_rng(1), []
    through, fault = 1.8, SourceFault.NONE
    before = water(0.0)
    for k in range(1, round(seconds / T) + 1):
        t = k * T
        psi = math.pi if t % 400.0 > 200.0 else 0.0
        c = math.cos(psi)
        through += T * DRAG * (thrust(t) ** 2 - through * through) - (water(t) - before) * c  # the hull has its inertia
        before = water(t)
        u, v = through + (NORTH + water(t) + stirred(t)) * c + lie(t), EAST * c + sideways(t)
        ping = Dvl(u + noise.normal(0.0, 0.01), v + noise.normal(0.0, 0.01), 0.0, 0.01, 20.0)
        known = 1.8 + filter_off(t) + NORTH * c
        current = Current(NORTH, EAST, 0.004, t)
        told_by = FilterVelocity(t - T, known, EAST * c, 0.0, 0.004, current, (0, 0), turbulence)
        check.hear(None if lost(t) else told_by, t)
        check.hull = HULL._replace(current=current, low=braked(t), high=afloat, aside=afloat)
        if not heard(t):
            continue
        now = check.judge(Heard(ping, t, True, True), psi, 0.0, fault is SourceFault.NONE)
        if now is not fault:
            told.append((t, now))
        fault = now
    return told


def test_a_dvl_that_steps_is_named_within_a_second_and_stays_so_until_it_is_back() -> None:
    told = fly(240.0, lie=lambda t: 0.5 if 90.0 <= t < 200.0 else 0.0)
    (begin, fault), (end, back) = told
    assert fault is SourceFault.STEP
    assert 90.0 <= begin <= 91.0
    assert back is SourceFault.NONE
    assert 200.0 <= end <= 204.0


@pytest.mark.parametrize(("rate", "within", "fault"), [
    (0.1, 4.0, SourceFault.DRIFT),
    (-0.1, 4.0, SourceFault.DRIFT),
    (0.02, 12.0, SourceFault.CURRENT),
    (0.01, 25.0, SourceFault.CURRENT),
])  # fmt: skip
def test_a_dvl_that_creeps_is_named_whether_the_filter_goes_along_or_is_lost(
    rate: float, within: float, fault: SourceFault
) -> None:
    for lost in (still, lambda t: t > 91.0):
        told = fly(140.0, lie=lambda t: max(0.0, t - 90.0) * rate, lost=lambda t, lost=lost: bool(lost(t)))
        assert told[0][1] is fault
        assert 90.0 < told[0][0] <= 90.0 + within


def test_a_dvl_that_creeps_sideways_is_named() -> None:
    told = fly(120.0, sideways=lambda t: max(0.0, t - 90.0) * 0.03)
    assert told[0][1] is SourceFault.CURRENT
    assert 90.0 < told[0][0] < 100.0


def test_a_current_that_steps_makes_a_sound_dvl_suspect_for_a_minute_and_no_longer() -> None:
    told = fly(600.0, water=lambda t: 0.5 if t >= 90.0 else 0.0)
    assert [fault for _, fault in told] == [SourceFault.CURRENT, SourceFault.NONE]
    assert told[1][0] - told[0][0] == pytest.approx(60.0, abs=0.3)


def test_a_current_from_ahead_that_steps_slows_down_as_lost_thrust_does_and_accuses_nobody() -> None:
    assert fly(600.0, water=lambda t: -0.5 if t >= 90.0 else 0.0) == []


def test_a_dvl_that_creeps_on_after_its_minute_is_named_again() -> None:
    told = fly(180.0, lie=lambda t: max(0.0, t - 90.0) * 0.02)
    assert [fault for _, fault in told] == [SourceFault.CURRENT, SourceFault.NONE, SourceFault.CURRENT]
    assert told[2][0] - told[1][0] < 15.0


@pytest.mark.parametrize("seed", range(5))
def test_a_current_that_walks_and_eddies_accuse_nobody(seed: int) -> None:
    random = np.random.default_rng(seed)
    walk = np.cumsum(random.normal(0.0, WALK * math.sqrt(T), 9000))
    eddies, x = np.zeros(9000), 0.0
    for k in range(9000):
        x += -T / 10.0 * x + random.normal(0.0, 0.1 * math.sqrt(2.0 * T / 10.0))
        eddies[k] = x
    assert fly(1800.0, stirred=lambda t: walk[round(t / T) - 1]) == []
    assert fly(1800.0, stirred=lambda t: eddies[round(t / T) - 1], turbulence=0.1) == []


def test_thrust_that_is_lost_and_a_filter_that_changes_its_mind_are_no_fault_of_the_dvl() -> None:
    assert fly(200.0, thrust=lambda t: 1.8 if t < 90.0 else 0.0) == []
    assert fly(200.0, filter_off=lambda t: 0.3 if t > 90.0 else 0.0) == []


def test_the_hull_is_put_right_by_a_filter_that_was_never_lost_after_pings_that_were() -> None:
    """The bottom is out of reach for 20 s; the filter knows the speed through the water all the time."""
    check = CurrentCheck(WALK, VEHICLE)
    assert fly(110.0, heard=lambda t: not 10.0 < t < 30.0, check=check) == []
    hull = check.corrected(HULL, SourceFault.NONE)
    assert hull is not None
    assert hull.u == pytest.approx(1.8, abs=0.005)


def test_a_filter_that_was_lost_puts_no_hull_right_for_two_minutes() -> None:
    check = CurrentCheck(WALK, VEHICLE)
    fly(110.0, lost=lambda t: 10.0 < t < 30.0, filter_off=lambda t: 0.3 if t >= 30.0 else 0.0, check=check)
    hull = check.corrected(HULL, SourceFault.NONE)
    assert hull is not None
    assert 1.75 < hull.u < 1.8


def test_what_a_filter_shows_after_two_minutes_takes_the_place_of_what_it_showed_before() -> None:
    """The vehicle is another one since: ten seconds tell by how much, or its sound DVL seems to be off."""
    check = CurrentCheck(WALK, VEHICLE)
    slower = {"lost": lambda t: 10.0 < t < 30.0 or t > 160.0, "thrust": lambda t: 1.8 if t < 30.0 else 1.6}
    fly(160.0, filter_off=lambda t: 0.0 if t < 30.0 else -0.2, check=check, **slower)
    hull = check.corrected(HULL, SourceFault.NONE)
    assert hull is not None
    assert hull.u == pytest.approx(1.6, abs=0.02)


def test_it_goes_on_from_a_memory_as_if_nothing_had_been() -> None:
    one, other = CurrentCheck(WALK, VEHICLE), CurrentCheck(WALK, VEHICLE)
    fly(95.0, lie=lambda t: 0.05 * max(0.0, t - 90.0), check=one)
    other.thaw(one.freeze())
    assert fly(30.0, check=one) == fly(30.0, check=other)
    assert one.freeze() == other.freeze()
    assert one.freeze() is not one.memory


def test_fins_at_their_stops_that_make_no_drag_are_no_current() -> None:
    def faster(t: float) -> float:
        return min(max(0.0, t - 90.0) * 0.02, 0.3)

    def lost(t: float) -> bool:
        return t > 91.0

    assert fly(200.0, lie=faster, lost=lost)[0][1] is SourceFault.CURRENT
    assert fly(200.0, lie=faster, lost=lost, braked=lambda t: 1.1 * faster(t)) == []
    turned = fly(200.0, lie=faster, lost=lost, braked=lambda t: 1.1 * faster(t) if t < 180.0 else 0.0)
    assert turned[0][1] is not SourceFault.NONE  # what is excused is not learned
    assert 180.0 <= turned[0][0] <= 185.0
    slower = fly(120.0, lie=lambda t: -0.1 * max(0.0, t - 90.0), lost=lost, braked=lambda _: 0.3)
    assert slower[0][1] is SourceFault.DRIFT  # drag that is there makes nothing slower than the model


@pytest.mark.parametrize(("step", "fault"), [(0.5, SourceFault.STEP), (-0.3, None), (-0.8, SourceFault.DRIFT)])
def test_at_the_surface_water_may_stop_a_hull_at_once_and_not_push_it(step: float, fault: SourceFault | None) -> None:
    told = fly(120.0, lie=lambda t: step if t >= 95.0 else 0.0, lost=lambda t: t > 91.0, afloat=0.45)
    assert [what for _, what in told] == ([fault] if fault else [])


@pytest.mark.parametrize(
    ("lie", "water", "fault", "doubt"),
    [
        (0.0, -2.5, SourceFault.DRIFT, 2.5),  # faster than a current of 1 m/s more would slow the hull down
        (0.0, 0.5, SourceFault.CURRENT, 0.5),
        (-2.5, 0.0, SourceFault.STEP, 2.5),  # no water is so quick, but a front is
        (4.0, 0.0, SourceFault.STEP, 0.0),  # this is none
    ],
)
def test_what_a_dvl_that_may_be_right_says_of_the_current_is_doubted(
    lie: float, water: float, fault: SourceFault, doubt: float
) -> None:
    check = CurrentCheck(WALK, VEHICLE)
    told = fly(140.0, lie=lambda t: lie if t > 90.0 else 0.0, water=lambda t: water if t > 90.0 else 0.0, check=check)
    assert [what for _, what in told] == [fault]
    doubted, good = check.corrected(HULL, fault), check.corrected(HULL, SourceFault.NONE)
    assert doubted is not None
    assert doubted.doubt == pytest.approx(doubt, abs=0.1 if not water else 0.6 * doubt)  # drag takes the hull along
    assert good is not None
    assert good.doubt == 0.0
