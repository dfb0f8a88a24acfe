"""Which velocity navigation takes: the filter's, the DVL's or the hull's; what it says of its error, and adds up to."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest

from firmware_py.estimation.navigation import velocity
from firmware_py.estimation.navigation.current_ahead import current_ahead
from firmware_py.estimation.navigation.dead_reckoning import PositionParams
from firmware_py.estimation.navigation.navigation import Navigation, NavigationParams
from firmware_py.estimation.navigation.velocity import Current, FilterVelocity, HullVelocity, Motion
from firmware_py.estimation.navigation.velocity_params import VelocityParams
from firmware_py.marine import Origin
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate, VelocitySource
from firmware_py.records.sensing import Ahrs, Dvl, Heard, never, silence
from firmware_py.safety.health_events import position_events
from firmware_py.tick import Tick

PARAMS = VelocityParams()
DT, DT_NS = 0.01, 10_000_000
ARMED = Applied((0.0,) * 4, 8.0, True, False)
STRAIGHT = Motion(0.0, 0.0, 0.0, 8.0)
CURRENT = Current(0.1, 0.2, 0.004, 0.0)


def known(t: float, std: float = 0.004, u: float = 1.8, turbulence: float = 0.0) -> FilterVelocity:
    return FilterVelocity(t, u, 0.2, 0.0, std, CURRENT._replace(t=t), (0.0, 0.0), turbulence)


def follow(
    seconds: float,
    *,
    pinged: Callable[[float], bool] = lambda _: True,
    learned: Callable[[float], FilterVelocity | None] = lambda _: None,
    motion: Motion = STRAIGHT,
) -> tuple[velocity.VelocityMemory, float]:
    """Pings of 1.9 m/s at 5 Hz, 0.1 s late, and what the filter knows; return the memory, and the time, s."""
    memory, ping, t = velocity.START, never(Dvl(*[math.nan] * 5)), 0.0
    for k in range(1, round(seconds / DT) + 1):
        t = k * DT
        fresh = k % 20 == 0 and pinged(t)
        ping = Heard(Dvl(1.9, 0.0, 0.0, 0.01, 20.0), t - 0.1, True, True) if fresh else replace(ping, fresh=False)
        memory = velocity.update(PARAMS, memory, ping, t, DT, motion, learned(t))
    return memory, t


def test_the_filter_is_taken_where_it_is_certain_and_pings_are_heard() -> None:
    memory, _ = follow(2.0, learned=lambda t: known(t - 0.2))
    assert (memory.source, memory.u) == (VelocitySource.FILTER, 1.8)
    uncertain, _ = follow(2.0, learned=lambda t: known(t - 0.2, std=0.06))
    assert (uncertain.source, uncertain.u) == (VelocitySource.DVL, 1.9)
    deaf, _ = follow(2.0, pinged=lambda _: False, learned=lambda t: known(t - 0.2))
    assert deaf.source is not VelocitySource.FILTER


def test_it_goes_on_without_dvl_until_it_is_lost_in_its_own_sigma() -> None:
    memory, t = follow(30.0, pinged=lambda t: t < 5.0, learned=lambda t: known(t - 0.2, std=0.004 + 0.004 * t))
    assert (memory.source, memory.u) == (VelocitySource.FILTER, 1.8)
    assert velocity.std(PARAMS, memory, t) > 0.12
    lost, t = follow(60.0, pinged=lambda t: t < 5.0, learned=lambda t: known(t - 0.2, std=0.004 + 0.004 * t))
    assert lost.source is VelocitySource.NONE
    assert velocity.std(PARAMS, lost, t) == PARAMS.lost_std


def test_a_hull_whose_propeller_is_stopped_may_coast_for_minutes() -> None:
    """At the surface over deep water it coasted for 75 s at 1 m/s, and sigma was that of a vehicle at rest."""
    lost, t = follow(35.0, pinged=lambda t: t < 5.0, motion=STRAIGHT._replace(n=0.0))
    assert abs(lost.u) < 0.1
    assert 1.0 < velocity.std(PARAMS, lost, t) < 1.9
    driven, t = follow(35.0, pinged=lambda t: t < 5.0)
    assert velocity.std(PARAMS, driven, t) == PARAMS.lost_std
    later, t = follow(600.0, pinged=lambda t: t < 5.0, motion=STRAIGHT._replace(n=0.0))
    assert velocity.std(PARAMS, later, t) == PARAMS.lost_std


def test_so_may_one_whose_dvl_was_never_heard() -> None:
    memory = velocity.START
    for k in range(1, 9000):
        motion = STRAIGHT if k < 6000 else STRAIGHT._replace(n=0.0)
        memory = velocity.update(PARAMS, memory, never(Dvl(*[math.nan] * 5)), k * DT, DT, motion, None)
    assert abs(memory.u) < 0.1
    assert 1.0 < velocity.std(PARAMS, memory, 90.0) < 1.9


def test_a_filter_that_stopped_is_left_for_the_next_ping() -> None:
    memory, _ = follow(8.0, learned=lambda t: known(t - 0.2) if t < 6.0 else known(5.8))
    assert (memory.source, memory.u) == (VelocitySource.DVL, 1.9)


def test_without_both_the_hull_moves_through_the_current_that_was_known_last() -> None:
    hull = HullVelocity(1.5, 0.05, Current(0.0, 0.0, 0.2, 0.0))
    motion = Motion(0.0, 0.0, math.pi / 2.0, 8.0, hull)  # to the east: the current of 0.1, 0.2 m/s is ahead and aport
    memory, t = follow(60.0, pinged=lambda t: t < 5.0, learned=lambda t: known(t) if t < 5.0 else None, motion=motion)
    assert memory.source is VelocitySource.HULL_MODEL
    assert (memory.u, memory.v) == (pytest.approx(1.7), pytest.approx(-0.05))
    assert PARAMS.hull_std < velocity.std(PARAMS, memory, t) < 1.1 * PARAMS.hull_std
    assert velocity.water(PARAMS, memory, t)[:2] == (0.1, 0.2)


def test_what_is_sure_of_the_current_that_was_known_last_counts_along_the_hull() -> None:
    """Behind a dropped weight no filter follows the hull, and SURFACE took way over the ground for a climb."""

    def ahead(north: float, psi: float, std: float = 0.02, t: float = 0.0) -> float:
        memory = velocity.START._replace(current=Current(north, 0.0, std, 0.0))
        return current_ahead(PARAMS, memory, t, 0.0, psi)

    assert ahead(1.2, 0.0) == pytest.approx(1.0)
    assert ahead(1.2, math.pi) == pytest.approx(-1.0)
    assert ahead(1.2, 0.5 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert ahead(0.15, 0.0) == 0.0
    assert 0.0 < ahead(1.2, 0.0, std=0.2) < ahead(1.2, 0.0)
    assert ahead(1.2, 0.0, t=3600.0) < ahead(1.2, 0.0)
    assert current_ahead(PARAMS, velocity.START, 0.0, 0.0, 0.0) == 0.0


def test_a_current_that_is_too_old_to_go_by_is_neither_added_nor_told() -> None:
    """Subtracted from a velocity that it is not in, it made the speed through the water 0.8 m/s in a hull of 1.8."""
    params = replace(PARAMS, current_walk=0.1)
    hull = HullVelocity(1.5, 0.05, Current(0.0, 0.0, math.inf, -math.inf))
    motion = Motion(0.0, 0.0, 0.0, 8.0, hull)
    memory, t = follow(60.0, pinged=lambda t: t < 5.0, learned=lambda t: known(t) if t < 5.0 else None, motion=motion)
    assert memory.current.std_at(params, t) > params.lost_std
    assert all(math.isnan(x) for x in velocity.water(params, memory, t))


def test_a_filter_that_took_in_the_fault_of_a_dvl_is_not_believed_without_it() -> None:
    """It knew the current for 20 s, pings contradicted it for 8 s, and then it tells of another current."""

    def learned(t: float) -> FilterVelocity | None:
        if t < 20.0:
            return known(t - 0.2)
        other = known(t - 0.2)
        return other._replace(current=Current(0.9, 0.2, 0.004, t)) if t > 28.0 else None

    motion = STRAIGHT._replace(hull=HullVelocity(1.5, 0.0, Current(0.9, 0.2, 0.05, 30.0)))
    heard, t = follow(38.0, learned=learned, motion=motion)
    assert heard.source is VelocitySource.FILTER
    assert velocity.lasting_std(PARAMS, heard, t) == pytest.approx(0.8)  # the current that changed may be a fault
    memory, t = follow(80.0, pinged=lambda t: t < 40.0, learned=learned, motion=motion)
    assert memory.source is VelocitySource.HULL_MODEL
    assert memory.u == pytest.approx(1.6, abs=0.01)  # 1.5 through the current of 0.1 that was known before
    later, _ = follow(260.0, pinged=lambda t: t < 200.0, learned=learned, motion=motion)
    assert later.source is VelocitySource.FILTER


def test_a_filter_that_pings_have_not_reached_yet_is_not_believed_against_them() -> None:
    """Without DVL it was lost. The first ping tells 1.9 m/s; the filter says 1.8 until it has taken that in."""

    def learned(t: float) -> FilterVelocity | None:
        return known(t - 0.2, std=0.03, u=1.8 if t < 20.25 else 1.9) if t > 15.0 else None

    def heard(t: float) -> bool:
        return t < 10.0 or t > 20.0

    first, _ = follow(20.2, pinged=heard, learned=learned)
    assert (first.source, first.u) == (VelocitySource.DVL, 1.9)
    behind, _ = follow(20.25, pinged=heard, learned=lambda t: known(t - 0.2, std=0.03) if t > 15.0 else None)
    assert (behind.source, behind.u) == (VelocitySource.DVL, 1.9)
    later, _ = follow(20.35, pinged=heard, learned=learned)
    assert (later.source, later.u) == (VelocitySource.FILTER, 1.9)


def test_eddies_that_carry_the_vehicle_unseen_are_a_walk_and_no_drift() -> None:
    memory, t = follow(20.0, pinged=lambda t: t < 5.0, learned=lambda t: known(t - 0.2, std=0.05, turbulence=0.05))
    assert velocity.lasting_std(PARAMS, memory, t) < 0.015
    assert memory.turbulence == 0.05


def flown(
    dvl: Callable[[float], float | None],
    learned: Callable[[float], FilterVelocity | None],
    params: NavigationParams | None = None,
) -> list[StateEstimate]:
    navigation, states = Navigation(params or NavigationParams(), Origin(0.9, 0.2)), []
    frame = silence(4)
    for k in range(1, 6001):
        t = k * DT
        u = dvl(t) if k % 20 == 0 else None
        ping = (
            Heard(Dvl(u, 0.0, 0.0, 0.01, 20.0), t - 0.1, True, True)
            if u is not None
            else replace(frame.dvl, fresh=False)
        )
        ahrs = Heard(Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), t, True, True)
        frame = replace(frame, ahrs=ahrs, dvl=ping)
        states.append(navigation.update(Tick(k, DT_NS), frame, ARMED, known=learned(t)))
    return states


def test_the_position_does_not_jump_when_the_dvl_is_lost_and_when_it_is_back() -> None:
    states = flown(lambda t: 1.8 if t < 20.0 or t > 40.0 else None, lambda t: known(t - 0.2, u=1.81))
    x = [state.eta.x for state in states]
    assert max(abs(b - a) for a, b in pairwise(x)) < 0.03
    assert all(state.velocity_ok for state in states[100:])
    assert x[-1] - x[1999] == pytest.approx(1.81 * 20.0 + 1.8 * 20.0, abs=0.1)  # by the filter, and by pings again


def test_the_sigma_of_the_position_grows_faster_without_dvl() -> None:
    states = flown(lambda t: 1.8 if t < 30.0 else None, lambda t: known(t - 0.2))
    before, at, after = (states[i].position_std for i in (5, 2999, -1))
    assert after**2 - at**2 > at**2 - before**2


def test_a_position_that_was_put_right_is_an_event() -> None:
    assert position_events(0.0) == ()
    (event,) = position_events(120.0)
    assert event.numbers == (120.0,)


def test_a_position_by_pings_is_not_off_by_what_the_filter_did_not_know_yet() -> None:
    """The filter is 0.1 m/s off at first, and right after 20 s: the way by its velocity would be 1 m too long."""
    states = flown(lambda _: 1.8, lambda t: known(t - 0.2, u=1.8 + 0.1 * max(0.0, 1.0 - t / 20.0)))
    assert states[-1].velocity_source is VelocitySource.FILTER
    assert states[-1].eta.x - states[99].eta.x == pytest.approx(1.8 * 59.0, abs=0.02)


def test_the_sigma_of_a_position_by_pings_is_the_walk_of_their_noise() -> None:
    """0.01 m/s on each axis, 5 Hz: 0.01 m/s sqrt(0.2 s t); heading, scale and bias of the DVL left out."""
    params = NavigationParams(position=PositionParams(std_start=0.1, heading_std=0.0, scale_std=0.0, bias_std=0.0))
    states = flown(lambda _: 1.8, lambda t: known(t - 0.2), params)
    begin, end = states[999].position_std, states[-1].position_std
    assert math.sqrt(end**2 - begin**2) == pytest.approx(0.01 * math.sqrt(2.0 * 0.2 * 50.0), rel=0.02)
