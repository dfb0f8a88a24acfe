"""The procedure of coming up: its stages, what releases the weight, and what tells of the surface."""

from __future__ import annotations

import math
from typing import Any

import pytest

from firmware_py.records.command import AscentStage
from firmware_py.records.event import Cause, Event, EventKind
from firmware_py.records.health import SOUND_FIN, ActuatorFault, FinHealth
from firmware_py.records.sensing import Heard
from firmware_py.safety.ascent import Ascent, AscentMemory
from firmware_py.safety.ascent_params import AscentParams
from firmware_py.safety.ascent_view import AscentView
from firmware_py.safety.plane_jam import PlaneJam, Planes
from firmware_py.safety.safety_params import SafetyParams

DT = 0.1
PARAMS = AscentParams()
POWERED, BLIND, LEVEL = AscentStage.POWERED, AscentStage.BLIND, AscentStage.LEVEL
REVERSE, STOPPED, WAITING, FULL = AscentStage.REVERSE, AscentStage.STOPPED, AscentStage.WAITING, AscentStage.FULL


class Rising:
    """A vehicle in SURFACE whose motion is told; it keeps the events."""

    def __init__(self, weight: bool = True, params: AscentParams = PARAMS, **view: Any) -> None:
        self.ascent = Ascent(SafetyParams(ascent=params), weight, 1.5)
        self.memory = AscentMemory()
        self.events: list[Event] = []
        self.t = 0.0
        self.view: dict[str, Any] = {
            "attitude_ok": True, "depth_ok": True, "speed_ok": True, "z": 10.0, "z_dot": 0.0, "phi": 0.0, "theta": 0.2,
            "u": 1.5, "altitude": math.nan, "fix": False, "jam": PlaneJam.NONE,
        }  # fmt: skip
        self.go(DT, **view)

    def go(self, seconds: float, rate: float = 0.0, **view: Any) -> AscentStage:
        """Let time pass; the depth changes at `rate`, m/s."""
        self.view |= view
        for _ in range(round(seconds / DT)):
            self.view["z"] += rate * DT
            self.view["z_dot"] = rate
            self.t += DT
            self.memory, told = self.ascent.update(self.memory, AscentView(self.t, DT, **self.seen))
            self.events += told
        return self.memory.stage

    @property
    def seen(self) -> dict[str, Any]:
        """The view, in water that stands still unless it is told."""
        return {"through": self.view["u"]} | self.view

    @property
    def causes(self) -> list[Cause]:
        return [event.cause for event in self.events]


def test_way_is_off_where_planes_do_nothing_any_more() -> None:
    """In a current from astern it went on astern through the water until it stood over the ground."""
    vehicle = Rising(through=0.6)
    assert vehicle.go(5.0, 0.3, jam=PlaneJam.DOWN, theta=-0.2) is REVERSE
    assert vehicle.go(1.0, 0.3, u=1.3, through=0.1) is STOPPED


def test_who_climbs_goes_on_and_comes_level_near_the_surface_without_a_word() -> None:
    vehicle = Rising()
    assert vehicle.go(20.0, -0.3) is POWERED
    assert vehicle.memory.pitch == pytest.approx(math.radians(12.0))
    assert vehicle.go(8.7, -0.3) is LEVEL
    assert vehicle.go(3.0, 0.0, theta=0.05) is LEVEL
    assert vehicle.memory.pitch == pytest.approx(math.radians(3.0))
    assert vehicle.go(4.0, 0.4, theta=0.05) is POWERED  # pressed down again, beyond 2.5 m
    assert not vehicle.events
    assert not vehicle.memory.drop


def test_who_is_held_down_near_the_surface_pitches_up_there_and_keeps_its_weight() -> None:
    """An eddy of 0.1 m/s takes what 3 deg gain: a sound vehicle lay 1 to 2 m deep for 45 s, and dropped its weight."""
    vehicle = Rising()
    vehicle.go(29.0, -0.3)
    assert vehicle.go(8.0, 0.04) is LEVEL
    assert vehicle.go(9.0, 0.04) is POWERED
    assert vehicle.go(3.0, -0.1) is POWERED
    assert vehicle.memory.pitch == pytest.approx(math.radians(12.0))
    assert vehicle.go(12.0, -0.1) is LEVEL  # its bow would be out there
    assert vehicle.memory.pitch == pytest.approx(math.radians(3.0))
    assert not vehicle.events


def test_a_dive_ends_first_and_is_not_taken_for_failure() -> None:
    vehicle = Rising(theta=math.radians(-20.0))
    for degrees in range(-20, 13, 1):
        theta = math.radians(degrees)
        vehicle.go(0.3, 1.8 * math.sin(-theta), theta=theta)
    assert vehicle.view["z"] > 11.0
    assert not vehicle.events


def test_deeper_than_it_was_leads_to_reverse_then_rest_then_release() -> None:
    vehicle = Rising(theta=-0.05)
    assert vehicle.go(4.0, 0.5, theta=-0.01) is POWERED
    assert vehicle.go(2.0, 0.5) is REVERSE
    assert vehicle.causes == [Cause.DEEPER]
    assert vehicle.go(5.0, 0.3, u=0.5) is REVERSE
    assert vehicle.go(0.2, 0.1, u=0.1) is STOPPED
    assert vehicle.go(2.5) is STOPPED
    assert not vehicle.memory.drop
    vehicle.go(1.0)
    assert vehicle.memory.drop
    assert vehicle.events[-1].kind is EventKind.WEIGHT_RELEASED
    assert vehicle.events[-1].cause is Cause.NO_CLIMB


def test_off_the_desired_pitch_nose_down_brakes_and_nose_up_only_stops() -> None:
    for theta, stage in ((-0.4, REVERSE), (0.8, STOPPED)):
        vehicle = Rising()
        vehicle.go(5.0, -0.2, theta=0.2)
        assert vehicle.go(0.9, -0.2, theta=theta) is POWERED
        assert vehicle.go(0.3, -0.2, theta=theta) is stage
        assert vehicle.causes == [Cause.PITCH_OFF]
        assert not vehicle.memory.drop


def test_what_rises_from_reverse_is_not_driven_down_again_and_what_rises_at_rest_keeps_its_weight() -> None:
    vehicle = Rising()
    vehicle.go(2.0, 0.3, theta=-0.5)
    assert vehicle.memory.stage is REVERSE
    assert vehicle.go(5.0, -0.2, theta=0.1) is STOPPED
    vehicle.go(20.0, -0.2)
    assert not vehicle.memory.drop
    vehicle.go(6.0, 0.0)
    assert vehicle.memory.drop


@pytest.mark.parametrize(
    ("jam", "rate", "stage", "drop"),
    [(PlaneJam.DOWN, 0.3, REVERSE, True), (PlaneJam.DOWN, -0.3, STOPPED, True), (PlaneJam.UP, -0.3, STOPPED, False)],
)
def test_planes_that_are_known_to_be_stuck_are_answered_at_once(
    jam: PlaneJam, rate: float, stage: AscentStage, drop: bool
) -> None:
    vehicle = Rising()
    vehicle.go(1.0, rate)
    assert vehicle.go(DT, rate, jam=jam) is stage
    assert vehicle.memory.drop is drop
    assert set(vehicle.causes) == {Cause.PLANES_STUCK}
    vehicle.go(100.0, -0.05 if drop else -0.08)
    assert vehicle.memory.stage is STOPPED  # driving would not help
    assert [event.kind for event in vehicle.events].count(EventKind.WEIGHT_RELEASED) == drop
    assert len(vehicle.events) <= 3


def test_below_the_limit_the_weight_goes_if_it_sinks_and_stays_if_it_rises() -> None:
    for rate, drop in ((0.3, True), (-0.3, False)):
        vehicle = Rising(z=30.5, theta=0.0)
        vehicle.go(1.0, 0.3, theta=0.0)
        vehicle.go(3.0, rate, theta=0.0)
        assert vehicle.memory.drop is drop
    assert Rising(z=29.0, altitude=0.9).go(2.0, 0.3, theta=-0.01) is REVERSE


def test_who_gains_nothing_in_its_time_stops_and_releases_and_who_still_does_not_rise_drives_again() -> None:
    vehicle = Rising()
    assert vehicle.go(44.0, -0.01) is POWERED
    assert vehicle.go(2.0, -0.01) is STOPPED
    assert vehicle.memory.drop
    assert vehicle.go(46.0) is POWERED  # the weight is stuck
    assert vehicle.go(46.0) is STOPPED
    assert Cause.NO_CLIMB in vehicle.causes


@pytest.mark.parametrize(("u", "patience"), [(0.0, 90.0), (1.0, 45.0)])
def test_from_rest_it_has_time_to_gather_way(u: float, patience: float) -> None:
    """In water without bottom a sound vehicle made 0.4 m/s after 45 s, and dropped its weight."""
    vehicle = Rising(u=u, theta=0.05)
    vehicle.go(patience - 1.0, u=1.0)
    assert vehicle.memory.stage is POWERED
    vehicle.go(2.0)
    assert (vehicle.memory.stage, vehicle.memory.drop) == (STOPPED, True)


def test_once_it_climbs_the_time_is_as_short_as_ever() -> None:
    vehicle = Rising(u=0.0, theta=0.05)
    vehicle.go(20.0, -0.1, u=1.0)
    vehicle.go(47.0, 0.0)
    assert (vehicle.memory.stage, vehicle.memory.drop) == (STOPPED, True)


def test_without_a_weight_it_says_so_and_drives_again() -> None:
    vehicle = Rising(weight=False)
    assert vehicle.go(46.0) is STOPPED
    assert vehicle.causes == [Cause.NO_DROP_WEIGHT, Cause.NO_CLIMB]
    assert not vehicle.memory.drop
    assert vehicle.go(46.0) is POWERED


def test_without_a_weight_planes_that_are_stuck_still_end_the_way_and_it_is_told_once() -> None:
    vehicle = Rising(weight=False)
    assert vehicle.go(5.0, 0.3, jam=PlaneJam.DOWN, theta=-0.2) is REVERSE
    assert vehicle.go(1.0, 0.1, u=0.05) is STOPPED
    vehicle.go(20.0)
    assert vehicle.causes.count(Cause.NO_DROP_WEIGHT) == 1


@pytest.mark.parametrize("weight", [True, False])
def test_who_stays_below_with_stuck_planes_and_nothing_left_to_release_goes_on_saying_so(weight: bool) -> None:
    vehicle = Rising(weight=weight)
    vehicle.go(5.0, 0.3, jam=PlaneJam.DOWN, theta=-0.2)
    assert vehicle.go(140.0, 0.01, u=0.05) is STOPPED
    assert vehicle.causes.count(Cause.NO_CLIMB) == 3
    vehicle.go(100.0, -0.1)
    assert vehicle.causes.count(Cause.NO_CLIMB) == 3


def test_a_heel_in_a_current_is_borne_for_a_time_and_upside_down_is_not() -> None:
    vehicle = Rising()
    assert vehicle.go(9.0, -0.2, phi=math.radians(78.0)) is POWERED
    assert vehicle.go(1.0, -0.2, phi=0.1) is POWERED
    assert vehicle.go(10.2, -0.2, phi=math.radians(-78.0)) is STOPPED
    assert vehicle.memory.drop
    assert Rising().go(0.2, phi=3.0) is STOPPED


def test_without_attitude_it_goes_blind_and_comes_back() -> None:
    vehicle = Rising(attitude_ok=False)
    assert vehicle.go(7.0, 0.3, theta=-1.0, phi=3.0) is BLIND  # the end of a dive; angles of the past mean nothing
    assert vehicle.go(30.0, -0.2) is BLIND
    assert vehicle.go(DT, -0.2, attitude_ok=True, theta=0.1, phi=0.0) is POWERED
    assert vehicle.go(DT, -0.2, attitude_ok=False) is BLIND
    assert not vehicle.events
    assert vehicle.go(8.0, 0.4) is REVERSE


def test_without_depth_it_comes_level_by_turns_where_the_surface_should_be() -> None:
    vehicle = Rising(depth_ok=False)
    assert vehicle.go(30.0, -0.2) is POWERED
    stages = [vehicle.go(10.0, -0.1) for _ in range(12)]
    assert {POWERED, LEVEL} == set(stages)
    assert vehicle.go(10.0, fix=True) is LEVEL
    assert not vehicle.memory.drop


def test_without_depth_attitude_and_fix_the_weight_goes_in_the_end() -> None:
    vehicle = Rising(depth_ok=False, attitude_ok=False)
    assert vehicle.go(167.0) is BLIND
    assert vehicle.go(2.0) is STOPPED
    assert vehicle.memory.drop
    assert vehicle.causes == [Cause.NOT_UP] * 2
    vehicle.go(120.0)
    assert vehicle.causes.count(Cause.NOT_TOLD) == 4


def test_a_carried_depth_that_ran_away_neither_holds_the_clock_nor_the_turns_up() -> None:
    vehicle = Rising(depth_ok=False, z=190.0)
    stages = {vehicle.go(5.0, 0.5) for _ in range(52)}
    assert LEVEL in stages
    assert not vehicle.memory.drop
    vehicle.go(20.0)
    assert vehicle.memory.drop
    assert Cause.NOT_UP in vehicle.causes


def test_without_depth_an_altitude_that_falls_is_sinking() -> None:
    vehicle = Rising(depth_ok=False, altitude=20.0)
    vehicle.go(10.0, -0.3, altitude=23.0)
    assert vehicle.go(2.0, -0.3, altitude=21.1) is POWERED
    assert vehicle.go(0.5, -0.3, altitude=20.9) is REVERSE
    assert vehicle.causes == [Cause.DEEPER]
    vehicle.go(1.0, -0.3, u=0.0)
    vehicle.go(4.0, -0.3)
    assert vehicle.memory.drop
    near = Rising(depth_ok=False, altitude=1.6)
    near.go(10.0, -0.3, altitude=0.9)
    assert near.events[0].cause is Cause.ALTITUDE_LIMIT


@pytest.mark.parametrize("top", [0.6, 0.4])
def test_who_hangs_below_the_surface_releases_the_weight_and_says_so(top: float) -> None:
    """Heavy by a little, or told a depth that is wrong by a little: level it sinks, powered it climbs."""
    vehicle = Rising()
    vehicle.go(30.0, -0.3)
    while not vehicle.memory.drop and vehicle.t < 300.0:
        vehicle.go(10.0, (2.0 - vehicle.view["z"]) / 10.0, theta=0.05)
        vehicle.go(5.0, (2.0 + top - vehicle.view["z"]) / 5.0)
        vehicle.go(10.0, (top - vehicle.view["z"]) / 10.0, theta=0.2)
    assert vehicle.memory.drop
    released = [event.cause for event in vehicle.events if event.kind is EventKind.WEIGHT_RELEASED]
    assert released == [Cause.NO_CLIMB if top > 0.5 else Cause.NOT_UP]
    assert vehicle.t < 200.0
    told = len(vehicle.events)
    vehicle.go(95.0, 0.0, z=1.0)
    assert vehicle.causes[told:].count(Cause.NOT_TOLD) >= 3


def test_near_the_surface_and_not_told_the_weight_goes_unless_two_other_witnesses_see_it_up() -> None:
    for altitude, drop in ((29.6, False), (22.0, True), (math.nan, True)):
        vehicle = Rising(altitude=20.0)
        vehicle.go(32.0, -0.3, altitude=altitude)  # the height that velocity and pitch make is 9.6 m ...
        vehicle.memory = vehicle.memory._replace(climbed=5.0)  # ... if they are right
        vehicle.go(130.0, 0.0, theta=0.05)
        assert vehicle.memory.drop is drop
        assert Cause.NOT_TOLD in vehicle.causes


def test_near_the_surface_it_waits_and_goes_on_saying_so() -> None:
    vehicle = Rising(z=0.3, theta=0.05)
    assert vehicle.go(58.0) is LEVEL
    assert vehicle.go(100.0) is WAITING
    assert vehicle.causes == [Cause.NOT_TOLD] * 4
    assert not vehicle.memory.drop
    vehicle.go(8.0, 0.1)
    assert not vehicle.memory.drop  # it may dip
    vehicle.go(5.0)
    assert vehicle.causes[-1] is Cause.NOT_UP


def test_who_is_pressed_down_from_the_surface_brakes() -> None:
    vehicle = Rising(z=0.3, theta=0.05)
    vehicle.go(20.0)
    assert vehicle.go(6.0, 0.4, theta=-0.05) is REVERSE
    assert vehicle.causes == [Cause.DEEPER]


@pytest.mark.parametrize(("z", "seconds", "told"), [(0.7, 29.0, False), (0.7, 31.0, True), (1.1, 40.0, False)])
def test_a_pressure_that_is_off_by_a_little_does_not_keep_a_fix_that_is_held_from_telling(
    z: float, seconds: float, told: bool
) -> None:
    vehicle = Rising()
    vehicle.go(30.0, (z - 10.0) / 30.0)
    vehicle.go(seconds, fix=True)
    assert surfaced(vehicle) is told
    vehicle.go(DT, fix=False)  # a break begins it anew
    vehicle.go(20.0, fix=True)
    assert not surfaced(vehicle)


@pytest.mark.parametrize("depth_ok", [True, False])
def test_who_rests_without_its_weight_and_does_not_rise_floats_if_a_fix_is_held(depth_ok: bool) -> None:
    vehicle = Rising(depth_ok=depth_ok, z=20.0)
    vehicle.go(250.0)
    assert vehicle.memory.drop
    vehicle.memory = vehicle.memory._replace(stage=STOPPED, since=vehicle.t, t_best=vehicle.t)
    told = [vehicle.go(1.0, fix=True) and surfaced(vehicle) for _ in range(40)]
    assert told.index(True) in range(29, 32)
    vehicle.memory = vehicle.memory._replace(z_dot=-0.1)
    assert not surfaced(vehicle)


def surfaced(vehicle: Rising) -> bool:
    v = vehicle.view
    return vehicle.ascent.witness.is_surfaced(vehicle.memory, vehicle.t, v["depth_ok"], v["z"], v["fix"], v["altitude"])


def test_the_weight_stays_released() -> None:
    vehicle = Rising(jam=PlaneJam.DOWN)
    assert vehicle.memory.drop
    vehicle.memory = AscentMemory(drop=True)  # another SURFACE
    vehicle.events.clear()
    vehicle.go(1.0)
    assert vehicle.memory.drop
    assert EventKind.WEIGHT_RELEASED not in {event.kind for event in vehicle.events}


@pytest.mark.parametrize(("u", "seconds"), [(0.05, 6.0), (1.5, 31.0)])
def test_a_weight_that_was_released_before_keeps_no_propeller_astern(u: float, seconds: float) -> None:
    """It was asked for in every tick again, and the vehicle driven down astern, to 98 m."""
    vehicle = Rising()
    vehicle.memory = AscentMemory(drop=True)
    assert vehicle.go(5.0, 0.3, jam=PlaneJam.DOWN, theta=-0.2) is REVERSE
    assert vehicle.go(seconds - 5.0, 0.3, u=u) is STOPPED
    vehicle.go(46.0, 0.0)
    assert vehicle.causes == [Cause.PLANES_STUCK, Cause.NONE, Cause.NO_CLIMB]


def angles(*degrees: float) -> tuple[Heard[float], ...]:
    return tuple(Heard(math.radians(d), 0.0, True, not math.isnan(d)) for d in degrees)


TIMEOUT = 1.0


NONE, JAMMED, LOST, SILENT = ActuatorFault.NONE, ActuatorFault.JAMMED, ActuatorFault.LOST, ActuatorFault.SILENT


@pytest.mark.parametrize(
    ("faults", "at", "jam"),
    [
        ((NONE, NONE, NONE, NONE), (23.0, 23.0, 0.0, 0.0), PlaneJam.NONE),
        ((JAMMED, JAMMED, NONE, NONE), (10.0, 10.0, 0.0, 0.0), PlaneJam.DOWN),
        ((JAMMED, JAMMED, NONE, NONE), (-10.0, -10.0, 0.0, 0.0), PlaneJam.UP),
        ((JAMMED, NONE, NONE, NONE), (10.0, 0.0, 0.0, 0.0), PlaneJam.NONE),  # the other one can do more
        ((ActuatorFault.HARD_OVER, NONE, NONE, NONE), (23.0, 0.0, 0.0, 0.0), PlaneJam.DOWN),
        ((JAMMED, LOST, NONE, NONE), (5.0, 0.0, 0.0, 0.0), PlaneJam.DOWN),
        ((JAMMED, NONE, NONE, NONE), (math.nan, 0.0, 0.0, 0.0), PlaneJam.DOWN),  # not known where
        ((NONE, NONE, JAMMED, JAMMED), (0.0, 0.0, 23.0, 23.0), PlaneJam.NONE),
        ((SILENT, SILENT, NONE, NONE), (23.0, 23.0, 0.0, 0.0), PlaneJam.NONE),
    ],
)
def test_what_stuck_planes_do_beyond_what_the_others_can(
    faults: tuple[ActuatorFault, ...], at: tuple[float, ...], jam: PlaneJam
) -> None:
    planes = Planes((0.5, 0.5, 0.0, 0.0), (math.radians(23.0),) * 4, TIMEOUT)
    assert planes.jam(0.0, faults, angles(*at)) is jam


def test_a_stuck_plane_that_reports_nothing_is_where_its_motion_shows() -> None:
    planes, faults = Planes((0.5, 0.5, 0.0, 0.0), (math.radians(23.0),) * 4, TIMEOUT), (JAMMED, NONE, NONE, NONE)
    at = [FinHealth(1.0, math.radians(angle)) for angle in (10.0, 22.0)]
    jams = [planes.jam(0.0, faults, angles(math.nan, 0.0, 0.0, 0.0), (one, *[SOUND_FIN] * 3)) for one in at]
    assert jams == [PlaneJam.NONE, PlaneJam.DOWN]


@pytest.mark.parametrize(
    ("age", "known", "jam"),
    [
        (TIMEOUT, math.nan, PlaneJam.UP),
        (TIMEOUT + 0.01, math.nan, PlaneJam.DOWN),  # not known where
        (TIMEOUT + 0.01, math.radians(23.0), PlaneJam.DOWN),
        (TIMEOUT + 0.01, math.radians(-23.0), PlaneJam.UP),
    ],
)
def test_where_planes_were_before_they_fell_silent_does_not_tell_where_they_jammed(
    age: float, known: float, jam: PlaneJam
) -> None:
    """They had reported -0.5 deg, jammed at 23 deg half a minute later, and counted as bow up: it went aground."""
    planes = Planes((0.5, 0.5, 0.0, 0.0), (math.radians(23.0),) * 4, TIMEOUT)
    left = (*[FinHealth(1.0, known)] * 2, *[SOUND_FIN] * 2)
    assert planes.jam(age, (JAMMED, JAMMED, NONE, NONE), angles(-0.5, -0.5, 0.0, 0.0), left) is jam


def test_a_stuck_plane_counts_for_no_more_than_it_can_do_where_it_stalls() -> None:
    planes, stuck = Planes((0.5, 0.25, 0.25, 0.25), (math.radians(45.0),) * 4, TIMEOUT), (JAMMED, NONE, NONE, NONE)
    assert planes.jam(0.0, stuck, angles(25.0, 0.0, 0.0, 0.0)) is PlaneJam.NONE
    both = stuck, (JAMMED,) * 4
    far = [planes.jam(0.0, faults, angles(at, -at, 0.0, 0.0)) for at in (45.0, 6e4) for faults in both]
    assert far[:2] == far[2:]
    many = Planes((0.5,) * 4, (math.radians(45.0),) * 4, TIMEOUT)
    assert many.jam(0.0, stuck, angles(6e4, 0.0, 0.0, 0.0)) is PlaneJam.NONE
    unheard, at = angles(math.nan, 0.0, 0.0, 0.0), (FinHealth(1.0, 6e4), *[SOUND_FIN] * 3)
    assert many.jam(0.0, stuck, unheard, at) is PlaneJam.NONE


@pytest.mark.parametrize("depth_rate", [0.0, -0.04])
def test_a_depth_that_stays_does_not_keep_the_weight_where_velocity_and_altitude_say_that_it_sinks(
    depth_rate: float,
) -> None:
    vehicle = Rising(altitude=8.0)
    while vehicle.view["altitude"] > 0.9 and not vehicle.memory.drop:
        vehicle.view["z"] += depth_rate * DT
        vehicle.view |= {"z_dot": 0.8, "altitude": vehicle.view["altitude"] - 0.8 * DT}
        vehicle.t += DT
        view = AscentView(vehicle.t, DT, **vehicle.seen)
        vehicle.memory, told = vehicle.ascent.update(vehicle.memory, view)
        vehicle.events += told
    assert vehicle.causes[0] is Cause.DEEPER
    assert vehicle.memory.stage is REVERSE
    assert vehicle.memory.drop


def test_a_bottom_that_rises_below_a_vehicle_that_climbs_is_no_sinking() -> None:
    vehicle = Rising(altitude=8.0)
    for _ in range(100):
        vehicle.view["altitude"] -= 0.3 * DT
        vehicle.go(DT, -0.2)
    assert vehicle.memory.stage is POWERED
    assert vehicle.causes == []


@pytest.mark.parametrize(
    ("view", "drops"),
    [
        ({"u": 0.4}, True),
        ({"u": 1.5}, False),  # over a slope
        ({"u": 0.4, "fix": True}, False),
        ({"u": 0.4, "speed_ok": False}, False),
    ],
    ids=["without way", "under way", "at the surface", "of no known speed"],
)
def test_a_bottom_that_comes_nearer_to_who_has_no_way_releases_the_weight_whatever_the_depth_says(
    view: dict[str, Any], drops: bool
) -> None:
    """The pressure rises as if it climbed by 0.2 m/s."""
    vehicle = Rising(altitude=12.0, **view)
    for _ in range(150):
        vehicle.view["altitude"] -= 0.2 * DT
        vehicle.go(DT, -0.2)
    assert vehicle.memory.drop is drops
    assert (Cause.DEEPER in vehicle.causes) is drops


def test_who_floats_by_pressure_and_by_the_height_made_may_drift_over_a_bottom_that_rises() -> None:
    vehicle = Rising(altitude=20.0)
    vehicle.go(33.0, -0.3, altitude=29.8)
    vehicle.go(5.0, 0.0, u=0.3, theta=0.05, z=0.1)
    for altitude in (28.0, 26.0, 24.0):
        vehicle.go(2.0, 0.0, altitude=altitude)
    assert not vehicle.memory.drop


def test_astern_and_too_near_to_the_bottom_the_weight_goes() -> None:
    vehicle = Rising(altitude=3.0, too_low=True, rise_slope=0.25, z_dot=0.0)
    assert vehicle.go(1.0) is REVERSE
    assert not vehicle.memory.drop
    vehicle.go(1.0, altitude=1.9)
    assert vehicle.memory.drop
    assert vehicle.memory.stage is REVERSE


def test_who_sinks_without_way_near_the_bottom_is_lifted_at_twice_the_height() -> None:
    for u, drops in ((1.5, False), (0.3, True)):
        vehicle = Rising(altitude=1.8, u=u)
        vehicle.go(4.0, 0.1)
        assert vehicle.memory.drop is drops


def test_who_sinks_with_its_bow_up_is_heavy_and_climbs_under_full_power_to_the_surface() -> None:
    """Propeller astern took the way off, and it sank to the ground with a healthy propeller."""
    vehicle = Rising(theta=0.2)
    assert vehicle.go(3.5, 0.5) is POWERED
    assert vehicle.go(1.5, 0.5) is FULL
    assert vehicle.causes == [Cause.DEEPER]
    assert vehicle.go(45.0, -0.25) is FULL
    assert vehicle.view["z"] < PARAMS.level_depth
    assert vehicle.go(3.0, 0.1, theta=0.02) is FULL
    assert vehicle.memory.pitch == pytest.approx(PARAMS.level_pitch)
    assert not vehicle.memory.drop


@pytest.mark.parametrize("theta", [-0.1, 1.3])
def test_if_full_power_leads_down_or_stands_it_on_end_the_way_is_taken_off_and_the_weight_goes(theta: float) -> None:
    vehicle = Rising(theta=0.2)
    assert vehicle.go(4.3, 0.5) is FULL
    assert vehicle.go(0.5, 0.3, theta=theta) is FULL  # a swing
    assert vehicle.go(1.5, 0.3, theta=theta) is REVERSE
    assert vehicle.go(4.0, 0.1, u=0.0) is STOPPED
    assert vehicle.memory.drop


def test_who_sinks_under_full_power_too_releases_the_weight_and_drives_on() -> None:
    vehicle = Rising(theta=0.2)
    assert vehicle.go(5.0, 0.5) is FULL
    assert vehicle.go(5.0, 0.5) is FULL
    assert vehicle.memory.drop
    assert vehicle.go(60.0, 0.0) is FULL


@pytest.mark.parametrize(("weight", "sinks"), [(True, True), (False, True), (True, False)])
def test_who_sinks_on_at_rest_without_a_weight_drives_again_at_once(weight: bool, sinks: bool) -> None:
    vehicle = Rising(weight=weight, theta=-0.1)
    vehicle.go(6.0, 0.5)
    vehicle.go(1.0, 0.3, u=0.0)
    assert vehicle.memory.stage is STOPPED
    vehicle.go(5.0, 0.3, theta=0.4)
    assert vehicle.memory.asked is weight
    assert (vehicle.go(10.0, 0.3 if sinks else 0.0) is FULL) is sinks


@pytest.mark.parametrize(("weight", "again"), [(True, STOPPED), (False, REVERSE)])
def test_without_attitude_a_propeller_that_goes_astern_in_vain_is_stopped_and_the_weight_goes(
    weight: bool, again: AscentStage
) -> None:
    """Its bow was up: astern drove it down to the ground. Where no weight is released its bow may be down next time."""
    vehicle = Rising(weight=weight, attitude_ok=False, speed_ok=False)
    assert vehicle.go(12.5, 0.5) is REVERSE
    assert vehicle.go(7.0, 0.5) is REVERSE
    assert vehicle.go(2.0, 0.5) is STOPPED
    assert vehicle.memory.asked
    assert vehicle.memory.drop is weight
    vehicle.go(46.0, 0.0)
    assert vehicle.memory.stage is BLIND
    assert vehicle.go(5.0, 0.5) is again


def test_with_the_motion_down_ending_it_goes_astern_until_the_way_is_off() -> None:
    vehicle = Rising(attitude_ok=False, speed_ok=False)
    assert vehicle.go(12.5, 0.5) is REVERSE
    assert vehicle.go(20.0, 0.0) is REVERSE
    assert not vehicle.memory.drop
