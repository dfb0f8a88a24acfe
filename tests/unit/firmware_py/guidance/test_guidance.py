from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.line_of_sight import LineOfSight, LineOfSightParams, is_passed, leg
from firmware_py.guidance.reference_model import Shape
from firmware_py.marine import Eta, Nu, wrap
from firmware_py.params import dump, load
from firmware_py.records.command import ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event_text import texts
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import NO_ORDER, Mode, Order, Setpoint
from firmware_py.tick import Tick

NAN = math.nan
CONFIG = Path(__file__).resolve().parents[4] / "configs" / "npsauv2"
SQUARE = Mission((Waypoint(60, 0, 5, 1.5), Waypoint(60, 80, 8, 1.0), Waypoint(-20, 80, 8, NAN)))


def state(x: float = 0.0, y: float = 0.0, z: float = 5.0, psi: float = 0.0, u: float = 1.8, v: float = 0.0):
    return StateEstimate(Eta(x, y, z, 0, 0, psi), Nu(u, v, 0, 0, 0, 0), 1.0, 0.1, 0.01, 50.0, True, True, True, False)


class Kinematic:
    """A vehicle that goes where its reference points, at once, in a current; ticks of 50 ms."""

    def __init__(self, guidance: Guidance, current: tuple[float, float] = (0.0, 0.0), **at: float) -> None:
        self.guidance, self.current, self.k = guidance, current, 0
        self.x, self.y, self.z, self.psi, self.u = (at.get(name, 0.0) for name in ("x", "y", "z", "psi", "u"))
        self.events: list[str] = []

    @property
    def state(self) -> StateEstimate:
        north, east = self.current
        c, s = math.cos(self.psi), math.sin(self.psi)
        over_ground = self.u + c * north + s * east, c * east - s * north
        return state(self.x, self.y, self.z, self.psi, *over_ground)

    def step(self, mode: Mode, order: Order = NO_ORDER) -> Reference:
        reference = self.guidance.update(Tick(self.k, 50_000_000), ModeState(mode, False, 0), order, self.state)
        self.events += texts(self.guidance.events)
        self.k += 1
        self.u += 0.05 * (reference.u_d - self.u)
        self.psi, self.z = reference.psi_d, reference.z_d
        self.x += 0.05 * (self.u * math.cos(self.psi) + self.current[0])
        self.y += 0.05 * (self.u * math.sin(self.psi) + self.current[1])
        return reference

    def run(self, mode: Mode, seconds: float, order: Order = NO_ORDER) -> list[Reference]:
        return [self.step(mode, order)] + [self.step(mode) for _ in range(round(seconds * 20) - 1)]


def test_disarmed_and_manual_follow_the_vehicle() -> None:
    vehicle = Guidance(GuidanceParams(), SQUARE)
    for mode, u_d in ((Mode.DISARMED, 1.2), (Mode.MANUAL, 1.2)):
        at = state(z=7.0, psi=-2.0, u=1.2)
        reference = vehicle.update(Tick(0, 10_000_000), ModeState(mode, False, 0), NO_ORDER, at)
        assert (reference.z_d, reference.psi_d, reference.u_d) == pytest.approx((7.0, -2.0, u_d))
        assert (reference.z_d_dot, reference.psi_d_dot) == (0.0, 0.0)
        assert math.isnan(reference.cross_track)


def test_hold_captures_where_the_vehicle_is_and_setpoints_move_it() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=4.0, psi=1.0, u=1.5)
    vehicle.run(Mode.MANUAL, 1.0)
    held = vehicle.run(Mode.HOLD, 20.0)
    assert all((r.z_d, r.psi_d, r.u_d) == pytest.approx((4.0, 1.0, held[0].u_d)) for r in held)
    last = vehicle.run(Mode.HOLD, 60.0, Order(setpoint=Setpoint(6.0, NAN, NAN)))[-1]
    assert (last.z_d, last.psi_d) == pytest.approx((6.0, 1.0), abs=1e-3)
    last = vehicle.run(Mode.HOLD, 60.0, Order(setpoint=Setpoint(NAN, -1.0, 1.0)))[-1]
    assert (last.z_d, last.psi_d, last.u_d) == pytest.approx((6.0, -1.0, 1.0), abs=1e-3)


def test_a_vehicle_armed_at_rest_asks_for_nothing() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=0.3, psi=0.7)
    vehicle.run(Mode.DISARMED, 1.0)
    for reference in vehicle.run(Mode.HOLD, 30.0):
        assert reference.u_d == 0.0
        assert (reference.z_d, reference.psi_d) == pytest.approx((0.3, 0.7))


def test_references_stand_still_while_the_vehicle_does() -> None:
    guidance = Guidance(GuidanceParams(), SQUARE)
    hold = ModeState(Mode.HOLD, False, 0)
    at = state(z=1.0, u=0.0)
    for k in range(500):
        order = Order(setpoint=Setpoint(9.0, 2.0, 1.5)) if k == 0 else NO_ORDER
        reference = guidance.update(Tick(k, 10_000_000), hold, order, at)
        assert (reference.z_d_dot, reference.psi_d_dot) == (0.0, 0.0)
    assert reference.u_d == pytest.approx(0.25)  # 5 s at 0.05 m/s^2


def test_setpoints_are_bounded_and_nonsense_is_ignored() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=2.0, u=1.5)
    vehicle.run(Mode.MANUAL, 0.1)
    last = vehicle.run(Mode.HOLD, 90.0, Order(setpoint=Setpoint(-3.0, math.inf, 99.0)))[-1]
    assert last.z_d == pytest.approx(0.0, abs=1e-3)
    assert last.psi_d == pytest.approx(0.0)
    assert last.u_d == pytest.approx(2.5)


@given(st.floats(0.3, 2.5), st.floats(0, 30), st.floats(-math.pi, math.pi))
def test_no_reference_is_steeper_or_tighter_than_the_vehicle(u: float, z: float, psi: float) -> None:
    params = GuidanceParams()
    guidance = Guidance(params, SQUARE)
    order, hold = Order(setpoint=Setpoint(z, psi, NAN)), ModeState(Mode.HOLD, False, 0)
    for k in range(200):
        reference = guidance.update(Tick(k, 50_000_000), hold, order, state(u=u))
        assert abs(reference.z_d_dot) <= min(0.5, u * math.sin(math.radians(20.0))) + 1e-9
        assert abs(reference.psi_d_dot) <= min(math.radians(4.0), u / 20.0) + 1e-9


def test_surfacing_is_powered_bounded_and_keeps_the_heading() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=6.0, psi=0.5)
    vehicle.run(Mode.DISARMED, 0.1)
    way = vehicle.run(Mode.SURFACE, 120.0)
    assert way[-1].u_d == pytest.approx(1.5)
    assert way[-1].z_d == pytest.approx(0.0, abs=1e-3)
    assert min(r.z_d_dot for r in way) >= -0.5
    assert all(r.psi_d == pytest.approx(0.5) for r in way)


def test_mission_flies_its_legs_from_where_it_was_entered() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), y=-3.0, z=2.0, u=1.5)
    vehicle.run(Mode.MANUAL, 0.1)
    first = vehicle.step(Mode.MISSION)
    assert first.cross_track == pytest.approx(0.0)
    assert first.waypoint == 0
    half = vehicle.run(Mode.MISSION, 20.0)[-1]
    assert 2.0 < half.z_d < 5.0  # on its way down along the leg
    assert half.u_d == pytest.approx(1.5)
    while not vehicle.guidance.finished:
        last = vehicle.step(Mode.MISSION)
        assert vehicle.k < 20 * 400
    assert vehicle.events == [f"waypoint {i} of 3 passed" for i in (1, 2, 3)]
    assert last.waypoint == 3
    assert math.hypot(vehicle.x + 20, vehicle.y - 80) < 6.0
    assert last.z_d == pytest.approx(8.0, abs=1e-2)
    assert last.u_d == pytest.approx(1.8)  # the leg that gives no speed is flown at cruising speed
    course = vehicle.run(Mode.MISSION, 20.0)[-1].psi_d
    assert wrap(course - math.pi) == pytest.approx(0.0, abs=0.05)  # goes on along the last leg
    vehicle.run(Mode.DISARMED, 0.1)
    assert not vehicle.guidance.finished
    assert vehicle.step(Mode.MISSION).waypoint == 0


def test_mission_resumes_its_leg_from_the_place_of_return() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=5.0, u=1.5)
    vehicle.run(Mode.MISSION, 60.0)
    assert vehicle.step(Mode.MISSION).waypoint == 1
    vehicle.run(Mode.HOLD, 10.0, Order(setpoint=Setpoint(NAN, 2.5, NAN)))
    back = vehicle.step(Mode.MISSION)
    assert back.waypoint == 1
    assert back.cross_track == pytest.approx(0.0, abs=1e-6)


def test_a_mission_without_items_is_over_at_once_and_flies_straight_on_until_it_surfaces() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), Mission()), psi=0.3, u=1.0)
    vehicle.run(Mode.MANUAL, 0.1)
    assert vehicle.run(Mode.MISSION, 5.0)[-1].psi_d == pytest.approx(0.3)
    assert vehicle.guidance.finished


@pytest.mark.parametrize("course", [0.0, 1.0, 3.1, -2.0])
@pytest.mark.parametrize("side", [-40.0, -4.0, 4.0, 40.0])
@pytest.mark.parametrize("shape", Shape)
def test_line_of_sight_converges_from_any_side_in_any_direction(course: float, side: float, shape: Shape) -> None:
    c, s = math.cos(course), math.sin(course)
    mission = Mission((Waypoint(0, 0, 5, 1.8), Waypoint(1000 * c, 1000 * s, 5, 1.8)))
    vehicle = Kinematic(Guidance(GuidanceParams(shape=shape), mission), x=0.5 * c, y=0.5 * s, z=5.0, psi=course, u=1.8)
    vehicle.step(Mode.MANUAL)
    vehicle.step(Mode.MISSION)
    vehicle.x, vehicle.y = -side * s, side * c
    way = [r.cross_track for r in vehicle.run(Mode.MISSION, 150.0)]
    assert way[0] == pytest.approx(side, rel=0.05)
    assert abs(way[-1]) < 0.05
    assert max(-math.copysign(1.0, side) * e for e in way) < 0.02 * abs(side) + 0.02  # hardly any overshoot


@pytest.mark.parametrize("drift", [-0.2, 0.2])
def test_a_current_across_the_leg_leaves_no_offset(drift: float) -> None:
    mission = Mission((Waypoint(1000, 0, 5, 1.8),))
    vehicle = Kinematic(Guidance(GuidanceParams(), mission), (0.0, drift), z=5.0, u=1.8)
    way = [r.cross_track for r in vehicle.run(Mode.MISSION, 150.0)]
    assert max(map(abs, way)) < 3.5  # what it drifts while it gathers way
    assert abs(way[-1]) < 0.01
    without = GuidanceParams(line_of_sight=LineOfSightParams(crab_time=0.0, lead=0.0))
    vehicle = Kinematic(Guidance(without, mission), (0.0, drift), z=5.0, u=1.8)
    assert abs(vehicle.run(Mode.MISSION, 150.0)[-1].cross_track) > 1.0


def test_crab_angle_is_not_learned_at_low_speed_or_without_a_velocity() -> None:
    way = leg(Waypoint(0, 0, 0, 1), Waypoint(100, 0, 0, 1), 0.0, 0.0)
    params = LineOfSightParams(lead=0.0)
    for at in (state(u=0.1, v=0.3), dataclasses.replace(state(v=0.3), velocity_ok=False)):
        sight = LineOfSight(params)
        assert [sight.update(way, at, 1.0) for _ in range(50)][-1] == 0.0
    sight = LineOfSight(params)
    learned = [sight.update(way, state(u=0.4, v=-4.0), 1.0) for _ in range(100)][-1]
    assert learned == pytest.approx(math.radians(45.0), rel=1e-3)


@given(st.floats(-3, 3), st.floats(1, 200), st.floats(-300, 300), st.floats(-100, 100))
def test_leg_geometry_is_that_of_a_turned_frame(course: float, length: float, along: float, across: float) -> None:
    c, s = math.cos(course), math.sin(course)
    way = leg(
        Waypoint(3, 4, 0, 1),
        Waypoint(3 + length * c, 4 + length * s, 0, 1),
        *(3 + along * c - across * s, 4 + along * s + across * c),
    )
    assert (way.along, way.across) == pytest.approx((along, across), abs=1e-6)
    assert way.distance == pytest.approx(math.hypot(length - along, across), abs=1e-6)
    if length > 5.1 and abs(way.distance - 5.0) > 0.01 and abs(along - length) > 0.01:
        assert is_passed(way, 5.0, 5.0) == (way.distance < 5.0 or along > length)


def test_waypoints_too_near_each_other_to_fly_are_passed_together() -> None:
    mission = Mission((Waypoint(50, 0, 5, 1.8), Waypoint(50, 1, 5, 1.8), Waypoint(150, 1, 5, 1.8)))
    vehicle = Kinematic(Guidance(GuidanceParams(), mission), z=5.0, u=1.8)
    vehicle.run(Mode.MISSION, 25.5)
    before = vehicle.step(Mode.MISSION)
    while before.waypoint == 0:
        before = vehicle.step(Mode.MISSION)
    assert before.waypoint == 2
    assert before.cross_track == pytest.approx(-1.0, abs=0.05)


def test_a_state_that_is_not_finite_leaves_the_last_reference_standing() -> None:
    vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=5.0, u=1.5)
    last = vehicle.run(Mode.MISSION, 5.0)[-1]
    frozen = vehicle.guidance.freeze()
    bad = state(x=NAN)
    assert vehicle.guidance.update(Tick(999, 50_000_000), ModeState(Mode.MISSION, False, 0), NO_ORDER, bad) == last
    assert vehicle.guidance.freeze() == frozen


@given(st.lists(st.sampled_from([Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.SURFACE, Mode.DISARMED]), max_size=6))
def test_thawed_guidance_goes_on_as_the_frozen_one(modes: list[Mode]) -> None:
    params = GuidanceParams()
    vehicle = Kinematic(Guidance(params, SQUARE), z=3.0, u=1.2)
    for mode in modes:
        vehicle.run(mode, 2.0)
    other = Guidance(params, SQUARE)
    other.thaw(vehicle.guidance.freeze())
    twin = Kinematic(other, x=vehicle.x, y=vehicle.y, z=vehicle.z, psi=vehicle.psi, u=vehicle.u)
    for mode in (Mode.MISSION, Mode.HOLD):
        for _ in range(40):
            a, b = vehicle.step(mode), twin.step(mode)
            assert repr(a) == repr(b)  # NaN and all
    assert other.finished == vehicle.guidance.finished


def test_parameters_survive_the_file() -> None:
    assert load(GuidanceParams, dump(GuidanceParams()), "again") == GuidanceParams()
    table = tomllib.loads((CONFIG / "autopilot.toml").read_text())
    assert load(GuidanceParams, table["guidance"], "guidance") == GuidanceParams()


@pytest.mark.parametrize("turn", [20.0, 60.0, 100.0, -60.0])
def test_a_corner_is_rounded_before_it_and_not_overshot(turn: float) -> None:
    course = math.radians(turn)
    corner = Waypoint(150.0, 0.0, 5.0, 1.8)
    mission = Mission((corner, Waypoint(150.0 + 200.0 * math.cos(course), 200.0 * math.sin(course), 5.0, 1.8)))
    vehicle = Kinematic(Guidance(GuidanceParams(), mission), z=5.0, u=1.8)
    way = [r.cross_track for r in vehicle.run(Mode.MISSION, 190.0) if r.waypoint == 1]
    beyond = [math.copysign(1.0, -turn) * across for across in way]
    assert beyond[0] < 0.0  # the turn begins before the corner
    assert max(beyond) < 0.1  # and ends on the leg: turning at the corner would carry it 25 m beyond at 90 deg
    assert abs(way[-1]) < 0.01


def test_holding_from_disarmed_asks_for_no_speed_and_from_manual_for_the_one_it_has() -> None:
    for before, u_d in ((Mode.DISARMED, 0.0), (Mode.MANUAL, 1.2)):
        vehicle = Kinematic(Guidance(GuidanceParams(), SQUARE), z=3.0, u=1.2)
        vehicle.run(before, 0.1)
        asked = [reference.u_d for reference in vehicle.run(Mode.HOLD, 60.0)]
        assert asked[0] == pytest.approx(1.2, abs=0.01)  # without a bump
        assert asked[-1] == pytest.approx(u_d, abs=1e-9)


def test_surfacing_without_a_depth_aims_above_the_surface() -> None:
    guidance = Guidance(GuidanceParams(), SQUARE)
    surface = ModeState(Mode.SURFACE, False, 0)
    for depth_ok in (True, False):
        for k in range(8000):
            at = dataclasses.replace(state(z=1.0, u=1.5), depth_ok=depth_ok)
            reference = guidance.update(Tick(k, 10_000_000), surface, NO_ORDER, at)
        assert reference.z_d == pytest.approx(0.0 if depth_ok else -10.0, abs=0.01)
