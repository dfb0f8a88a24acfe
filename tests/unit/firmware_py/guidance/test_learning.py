"""Learning manoeuvres in a mission: on the spot, inside their limits, and over when they should be."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.estimation.identifiability import reported
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.manoeuvre import NO_EXCITATION, ManoeuvreGuidance, ManoeuvreParams
from firmware_py.marine import Eta, Nu
from firmware_py.records.command import ModeState, Reference
from firmware_py.records.estimate import NOTHING_LEARNED, StateEstimate
from firmware_py.records.event import Cause
from firmware_py.records.event_text import texts
from firmware_py.records.mission import Manoeuvre, ManoeuvreKind, Mission, Waypoint
from firmware_py.records.order import NO_ORDER, Mode, Order, Setpoint
from firmware_py.tick import Tick

NAN = math.nan
PRBS = Manoeuvre(ManoeuvreKind.PRBS, duration=10.0, clock=0.5)
BASE = Setpoint(50.0, 0.0, 1.8)
PARAMS = ManoeuvreParams()


def state(
    z: float = 50.0,
    theta: float = 0.0,
    q: float = 0.0,
    altitude: float = NAN,
    x: float = 0.0,
    y: float = 0.0,
    psi: float = 0.0,
    u: float = 1.8,
) -> StateEstimate:
    return StateEstimate(
        Eta(x, y, z, 0, theta, psi), Nu(u, 0, 0, 0, q, 0), 1.0, 0.1, 0.01, altitude, True, True, True, False
    )


def flown(learning: ManoeuvreGuidance, at: StateEstimate, ticks: int, manoeuvre: Manoeuvre = PRBS) -> list[str]:
    events: list[str] = []
    for _ in range(ticks):
        learning.update(manoeuvre, BASE, at, 0.1)
        events += texts(learning.events)
    return events


def test_a_manoeuvre_lasts_as_long_as_it_says_and_says_when_it_begins_and_ends() -> None:
    learning = ManoeuvreGuidance(PARAMS)
    assert flown(learning, state(), 99) == ["prbs begins: 10 s about 50.0 m"]
    assert learning.begun
    assert flown(learning, state(), 1) == ["prbs done: 10 s, and 0.0 s of waiting"]
    assert not learning.begun


def test_the_laws_hold_softly_meanwhile_and_the_fins_have_the_angles_asked_for() -> None:
    learning = ManoeuvreGuidance(PARAMS)
    manoeuvre = dataclasses.replace(PRBS, delta_s=0.2, delta_r=0.1)
    asked = [learning.update(manoeuvre, BASE, state(), 0.1) for _ in range(100)]
    assert {abs(d.delta_s) for d in asked} == {0.2}
    assert {abs(d.delta_r) for d in asked} == {0.1}
    assert {d.grip for d in asked} == {PARAMS.grip}
    still = dataclasses.replace(PRBS, delta_s=0.0)
    assert not any(learning.update(still, BASE, state(), 0.1).delta_s for _ in range(100))


@pytest.mark.parametrize(
    ("off", "inside", "words"),
    [
        (state(z=55.5), state(z=52.0), "waits: depth 55.5 m, soon 55.5 m, limits 45.0 and 55.0 m"),
        (state(z=44.5), state(z=48.0), "waits: depth 44.5 m"),
        (state(z=53.0, theta=-0.3), state(z=52.0, theta=0.2), "waits: depth 53.0 m, soon 55.7 m"),
        (state(theta=0.45), state(theta=0.2), "waits: pitch 26 deg, soon 26 deg, limit 25 deg"),
        (state(theta=-0.3, q=-0.1), state(theta=-0.2), "waits: pitch -17 deg, soon -29 deg"),
        (state(altitude=6.5), state(altitude=10.0), "waits: altitude 6.5 m, soon 6.5 m, limit 7.0 m"),
    ],
)
def test_it_waits_with_the_laws_alone_where_a_limit_is_near_and_goes_on_well_inside(
    off: StateEstimate, inside: StateEstimate, words: str
) -> None:
    learning = ManoeuvreGuidance(PARAMS, depth_max=80.0, altitude_min=2.0)
    flown(learning, state(), 40)
    assert learning.update(PRBS, BASE, off, 0.1) == NO_EXCITATION
    assert words in texts(learning.events)[0]
    assert flown(learning, off, 20) == []
    assert learning.update(PRBS, BASE, inside, 0.1) != NO_EXCITATION
    assert texts(learning.events) == ["prbs goes on"]
    assert flown(learning, state(), 59) == ["prbs done: 10 s, and 2.1 s of waiting"]  # not shortened by the wait


def test_between_going_on_and_waiting_is_room_so_that_it_does_not_chatter() -> None:
    learning = ManoeuvreGuidance(PARAMS)
    between = state(z=50.0 + 0.75 * PARAMS.depth_band)
    assert flown(learning, between, 10) == ["prbs begins: 10 s about 50.0 m"]
    learning.update(PRBS, BASE, state(z=56.0), 0.1)
    assert learning.update(PRBS, BASE, between, 0.1) == NO_EXCITATION


@pytest.mark.parametrize(
    ("base", "z", "waits"), [(50.0, 46.0, False), (77.0, 76.0, True), (7.0, 4.5, True), (77.0, 74.5, False)]
)
def test_it_keeps_off_the_surface_and_the_supervisors_depth(base: float, z: float, waits: bool) -> None:
    learning = ManoeuvreGuidance(PARAMS, depth_max=80.0)
    assert (learning.update(PRBS, BASE._replace(z_d=base), state(z=z), 0.1) == NO_EXCITATION) == waits


def test_where_it_can_never_go_on_it_gives_up() -> None:
    learning = ManoeuvreGuidance(PARAMS)
    events = flown(learning, state(z=60.0), round(PARAMS.patience / 0.1))
    assert [event.split(":")[0] for event in events] == ["prbs begins", "prbs waits", "prbs given up after 0.0 s"]
    assert not learning.begun


@given(st.lists(st.tuples(st.floats(-8, 8), st.floats(-0.6, 0.6), st.floats(0, 20)), max_size=60))
def test_no_fin_is_moved_beyond_a_limit_whatever_the_vehicle_does(way: list[tuple[float, float, float]]) -> None:
    learning = ManoeuvreGuidance(PARAMS, depth_max=60.0, altitude_min=2.0)
    for off, theta, altitude in way:
        if learning.update(PRBS, BASE, state(z=50.0 + off, theta=theta, altitude=altitude), 0.1) != NO_EXCITATION:
            assert abs(off) <= PARAMS.depth_band
            assert abs(theta) <= PARAMS.pitch_max
            assert altitude >= 2.0 + PARAMS.altitude_margin


class KinematicVehicle:
    """A vehicle that goes where its reference points, at once; ticks of 100 ms."""

    def __init__(self, *items: Waypoint | Manoeuvre) -> None:
        self.guidance = Guidance(GuidanceParams(), Mission(items))
        self.x = self.y = self.psi = 0.0
        self.z, self.k = 50.0, 0
        self.events: list[str] = []
        self.learned = NOTHING_LEARNED

    def run(self, mode: Mode, seconds: float, order: Order = NO_ORDER) -> list[Reference]:
        flown = []
        for _ in range(round(10.0 * seconds)):
            at = dataclasses.replace(state(z=self.z, x=self.x, y=self.y, psi=self.psi), learned=self.learned)
            last = self.guidance.update(Tick(self.k, 100_000_000), ModeState(mode, False, 0), order, at)
            self.events += texts(self.guidance.events)
            self.k += 1
            self.psi, self.z = last.psi_d, last.z_d
            self.x += 0.18 * math.cos(self.psi)
            self.y += 0.18 * math.sin(self.psi)
            flown.append(last)
        return flown


HERE, THERE = Waypoint(60.0, 0.0, 52.0, 1.8), Waypoint(60.0, 120.0, 50.0, 1.8)


def test_a_mission_flies_its_items_in_their_order() -> None:
    vehicle = KinematicVehicle(PRBS, HERE, PRBS, THERE, dataclasses.replace(PRBS, duration=5.0))
    vehicle.run(Mode.MANUAL, 0.1)
    while not vehicle.guidance.finished:
        vehicle.run(Mode.MISSION, 0.1)
        assert vehicle.k < 3000
    assert [event.split(":")[0] for event in vehicle.events] == [
        *("prbs begins", "prbs done", "waypoint 1 of 2 passed", "prbs begins", "prbs done"),
        *("waypoint 2 of 2 passed", "prbs begins", "prbs done"),
    ]


def test_it_is_flown_on_the_spot_and_the_next_leg_starts_where_it_ends() -> None:
    vehicle = KinematicVehicle(HERE, PRBS, THERE)
    vehicle.run(Mode.MANUAL, 0.1)
    while "waypoint 1 of 2 passed" not in vehicle.events:
        (last,) = vehicle.run(Mode.MISSION, 0.1)
    assert vehicle.x > 54.0  # it does not cut the corner before a manoeuvre
    learning = vehicle.run(Mode.MISSION, 10.0)
    assert all(math.isnan(r.cross_track) for r in learning)
    assert all(r.grip == PARAMS.grip for r in learning)
    assert {r.waypoint for r in learning} == {1}
    assert learning[-1].psi_d == pytest.approx(last.psi_d, abs=0.01)
    assert f"prbs begins: 10 s about {learning[-1].z_d:.1f} m" in vehicle.events
    (after,) = vehicle.run(Mode.MISSION, 0.1)
    assert (after.delta_s, after.delta_r, after.grip) == NO_EXCITATION
    assert after.cross_track == pytest.approx(0.0, abs=0.2)


def test_the_speed_is_the_items_own_or_the_cruising_speed() -> None:
    for asked, flown in ((0.0, 1.8), (1.2, 1.2)):
        vehicle = KinematicVehicle(dataclasses.replace(PRBS, duration=60.0, speed=asked))
        vehicle.run(Mode.MANUAL, 0.1)
        assert vehicle.run(Mode.MISSION, 59.0)[-1].u_d == pytest.approx(flown)


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.SURFACE, Mode.MANUAL, Mode.DISARMED])
def test_any_other_mode_ends_it_at_once_and_the_mission_begins_it_anew(mode: Mode) -> None:
    vehicle = KinematicVehicle(PRBS)
    vehicle.run(Mode.MANUAL, 0.1)
    assert vehicle.run(Mode.MISSION, 4.0)[-1].grip == PARAMS.grip
    for reference in vehicle.run(mode, 2.0):
        assert (reference.delta_s, reference.delta_r, reference.grip) == NO_EXCITATION
    vehicle.z = 50.0
    assert len(vehicle.run(Mode.MISSION, 9.9)) == 99
    assert not vehicle.guidance.finished
    vehicle.run(Mode.MISSION, 0.1)
    assert vehicle.guidance.finished


def test_a_state_that_is_not_finite_stops_the_fins() -> None:
    vehicle = KinematicVehicle(PRBS)
    vehicle.run(Mode.MISSION, 4.0)
    lost = state(x=NAN)
    reference = vehicle.guidance.update(Tick(99, 100_000_000), ModeState(Mode.MISSION, False, 0), NO_ORDER, lost)
    assert (reference.delta_s, reference.delta_r, reference.grip) == NO_EXCITATION


@given(st.integers(1, 140))
def test_thawed_in_the_middle_it_goes_on_as_the_frozen_one(ticks: int) -> None:
    items = (HERE._replace(x=10.0), PRBS, THERE)
    vehicle, twin = KinematicVehicle(*items), KinematicVehicle(*items)
    vehicle.run(Mode.MISSION, 0.1 * ticks)
    twin.guidance.thaw(vehicle.guidance.freeze())
    twin.x, twin.y, twin.z, twin.psi, twin.k = vehicle.x, vehicle.y, vehicle.z, vehicle.psi, vehicle.k
    assert repr(vehicle.run(Mode.MISSION, 5.0)) == repr(twin.run(Mode.MISSION, 5.0))


KNOWN = dataclasses.replace(
    NOTHING_LEARNED,
    report=(reported(Cause.LEARNED, (1.0, 2.0, 1.0, 0.02), ["Y_r"]), reported(Cause.NEVER_EXCITED, (), ["N_r"])),
)
TAUGHT = "prbs: learned 1 of 2, 1 valid, 1 sigma up to 2 % (Y_r); not identifiable: N_r (never excited)"


def under_way(*items: Waypoint | Manoeuvre) -> KinematicVehicle:
    """In the fourth second of a manoeuvre."""
    vehicle = KinematicVehicle(*items)
    vehicle.learned = KNOWN
    vehicle.run(Mode.MANUAL, 0.1)
    vehicle.run(Mode.MISSION, 4.0)
    assert TAUGHT not in vehicle.events
    return vehicle


def test_what_it_taught_is_said_once_as_its_time_is_over() -> None:
    vehicle = under_way(PRBS, THERE)
    vehicle.run(Mode.MISSION, 6.0)
    assert vehicle.events[-2:] == ["prbs done: 10 s, and 0.0 s of waiting", TAUGHT]
    vehicle.run(Mode.MISSION, 5.0)
    assert vehicle.events.count(TAUGHT) == 1


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.SURFACE, Mode.MANUAL, Mode.DISARMED])
def test_what_it_taught_is_said_when_another_mode_ends_it(mode: Mode) -> None:
    vehicle = under_way(PRBS)
    vehicle.run(mode, 0.1)
    assert vehicle.events[-1] == TAUGHT
    vehicle.run(mode, 2.0)
    assert vehicle.events.count(TAUGHT) == 1


def test_what_it_taught_is_said_when_it_is_skipped() -> None:
    vehicle = under_way(PRBS, THERE)
    vehicle.run(Mode.MISSION, 0.1, Order(jump=1))
    assert vehicle.events[-1] == TAUGHT


@pytest.mark.parametrize("times", [1, 2])
def test_what_it_taught_is_said_when_the_mission_is_another_one_however_often_in_a_tick(times: int) -> None:
    vehicle = under_way(PRBS)
    for _ in range(times):  # a new mission, and a parameter of guidance
        other = Guidance(GuidanceParams(), Mission((THERE,)))
        other.thaw(vehicle.guidance.freeze())
        other.restart()
        vehicle.guidance = other
    vehicle.run(Mode.MISSION, 1.0)
    assert vehicle.events.count(TAUGHT) == 1


def test_what_it_taught_is_said_when_it_gives_up() -> None:
    vehicle = under_way(PRBS)
    vehicle.z = 60.0
    for _ in range(round(10.0 * PARAMS.patience)):
        vehicle.run(Mode.MISSION, 0.1)
        vehicle.z = 60.0
    assert vehicle.events[-2].startswith("prbs given up after 4.0 s")
    assert vehicle.events[-1] == TAUGHT


def test_of_a_vehicle_that_does_not_learn_nothing_is_said() -> None:
    vehicle = KinematicVehicle(PRBS)
    vehicle.run(Mode.MANUAL, 0.1)
    vehicle.run(Mode.MISSION, 12.0)
    assert [event.split(":")[0] for event in vehicle.events] == ["prbs begins", "prbs done"]
