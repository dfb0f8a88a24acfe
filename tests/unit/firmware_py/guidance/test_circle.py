"""The circle around a place, seen from anywhere, and guidance that goes there, around it, and away."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.guidance.circle import Circle, circle_through, tangent
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.line_of_sight import LineOfSightParams
from firmware_py.marine import Eta, Nu, wrap
from firmware_py.records.command import ModeState
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import NO_ORDER, Mode, Order, Setpoint
from firmware_py.tick import Tick

NAN = math.nan
DT_NS = 100_000_000
EMPTY = Mission()
PARAMS = GuidanceParams(line_of_sight=LineOfSightParams(pivot=0.0))
place = st.floats(-500.0, 500.0)


@given(place, place, st.floats(-math.pi, math.pi), st.floats(5.0, 100.0), st.sampled_from([1.0, -1.0]))
def test_a_circle_beside_the_vehicle_has_the_vehicle_on_it_and_its_course(x, y, psi, radius, side) -> None:
    circle = circle_through(x, y, psi, side * radius)
    way, ahead = tangent(circle, x, y, 0.0)
    assert way.across == pytest.approx(0.0, abs=1e-6)
    assert wrap(way.course - psi) == pytest.approx(0.0, abs=1e-6)
    assert ahead == 0.0
    off = math.atan2(circle.y - y, circle.x - x)
    assert wrap(off - psi) == pytest.approx(side * 0.5 * math.pi, abs=1e-6)  # the centre is to that side


@given(place, place, st.floats(5.0, 100.0), st.sampled_from([1.0, -1.0]), st.floats(0.0, 10.0))
def test_across_is_the_distance_from_the_circle_and_the_turn_ahead_is_bounded(x, y, radius, side, lag) -> None:
    way, ahead = tangent(Circle(0.0, 0.0, side * radius), x, y, lag)
    assert abs(way.across) == pytest.approx(abs(math.hypot(x, y) - radius))
    assert 0.0 <= side * ahead <= lag / radius
    if math.hypot(x, y) > 2.0 * radius:
        assert ahead == 0.0
        assert side * way.across < 0.0  # outside: port of a circle to starboard


class KinematicVehicle:
    """Goes exactly as the reference says."""

    def __init__(self, mission: Mission = EMPTY, x: float = 0.0, y: float = 0.0, u: float = 1.8) -> None:
        self.guidance = Guidance(PARAMS, mission)
        self.x, self.y, self.z, self.psi, self.u = x, y, 5.0, 0.0, u
        self.k = 0
        self.path: list[tuple[float, float]] = []

    def run(self, mode: Mode, seconds: float, order: Order = NO_ORDER):
        for _ in range(round(seconds * 10)):
            eta, nu = Eta(self.x, self.y, self.z, 0.0, 0.0, self.psi), Nu(self.u, 0.0, 0.0, 0.0, 0.0, 0.0)
            state = StateEstimate(eta, nu, 1.0, 0.1, 0.1, 30.0, True, True, True, False)
            reference = self.guidance.update(Tick(self.k, DT_NS), ModeState(mode, False, 0), order, state)
            order = NO_ORDER
            self.k += 1
            self.psi, self.z, self.u = reference.psi_d, reference.z_d, reference.u_d
            self.x += 0.1 * self.u * math.cos(self.psi)
            self.y += 0.1 * self.u * math.sin(self.psi)
            self.path.append((self.x, self.y))
        return reference

    def distances(self, x: float, y: float, seconds: float) -> list[float]:
        return [math.hypot(a - x, b - y) for a, b in self.path[-round(seconds * 10) :]]


RADIUS = 1.25 * 1.8 / PARAMS.turn_rate_max


def go(x: float = NAN, y: float = NAN, z: float = NAN, psi: float = NAN, u: float = NAN) -> Order:
    return Order(setpoint=Setpoint(z, psi, u, x, y))


@pytest.mark.parametrize(("x", "y"), [(150.0, 60.0), (-100.0, -100.0), (5.0, 0.0), (0.0, 0.0), (0.0, -32.0)])
def test_guided_ends_on_the_circle_around_its_place_wherever_that_is(x: float, y: float) -> None:
    vehicle = KinematicVehicle()
    vehicle.run(Mode.HOLD, 1.0)
    vehicle.run(Mode.GUIDED, 300.0, go(x, y, 9.0))
    assert vehicle.z == pytest.approx(9.0, abs=0.01)
    distances = vehicle.distances(x, y, 120.0)
    assert max(distances) - min(distances) < 0.5
    assert distances[-1] == pytest.approx(RADIUS, abs=2.0)


def test_a_heading_leaves_the_place_and_another_place_the_heading() -> None:
    vehicle = KinematicVehicle()
    vehicle.run(Mode.GUIDED, 100.0, go(100.0, 0.0))
    vehicle.run(Mode.GUIDED, 60.0, go(psi=2.0))
    assert wrap(vehicle.psi) == pytest.approx(2.0, abs=1e-3)
    vehicle.run(Mode.GUIDED, 300.0, go(-50.0, 50.0))
    assert vehicle.distances(-50.0, 50.0, 10.0)[-1] == pytest.approx(RADIUS, abs=2.0)


def test_guided_without_a_word_and_loiter_circle_where_they_are_even_from_rest() -> None:
    for mode in (Mode.GUIDED, Mode.LOITER):
        vehicle = KinematicVehicle(u=0.0)
        vehicle.run(Mode.DISARMED, 1.0)
        vehicle.run(mode, 400.0)
        assert vehicle.u == pytest.approx(1.8)
        assert max(math.hypot(x, y) for x, y in vehicle.path) < 2.0 * RADIUS + 3.0


def test_loiter_takes_depth_and_speed_and_no_place_or_heading() -> None:
    vehicle = KinematicVehicle()
    vehicle.run(Mode.LOITER, 100.0)
    vehicle.run(Mode.LOITER, 100.0, go(500.0, 500.0, 8.0, 1.0, 1.2))
    assert (vehicle.z, vehicle.u) == (pytest.approx(8.0, abs=0.01), pytest.approx(1.2))
    assert max(math.hypot(x, y) for x, y in vehicle.path) < 2.0 * RADIUS + 3.0


def test_a_faster_circle_is_a_wider_one() -> None:
    vehicle = KinematicVehicle()
    vehicle.run(Mode.GUIDED, 200.0, go(0.0, 30.0))
    vehicle.run(Mode.GUIDED, 300.0, go(u=2.5))
    assert vehicle.distances(0.0, 30.0, 10.0)[-1] == pytest.approx(1.25 * 2.5 / PARAMS.turn_rate_max, abs=2.5)


def test_a_pause_leaves_the_mission_where_it_was() -> None:
    vehicle = KinematicVehicle(Mission((Waypoint(150.0, 0.0, 5.0, 0.0), Waypoint(300.0, 0.0, 5.0, 0.0))))
    vehicle.run(Mode.MISSION, 120.0)
    assert vehicle.guidance.freeze().route.next == 1
    vehicle.run(Mode.LOITER, 60.0)
    assert vehicle.guidance.freeze().route.next == 1
    vehicle.run(Mode.MISSION, 200.0)
    assert vehicle.guidance.finished


def test_a_speed_ordered_in_a_mission_holds_for_its_legs_until_it_is_taken_back_or_the_vehicle_disarmed() -> None:
    vehicle = KinematicVehicle(Mission((Waypoint(900.0, 0.0, 5.0, 1.5), Waypoint(2000.0, 0.0, 5.0, 1.5))))
    assert vehicle.run(Mode.MISSION, 30.0).u_d == pytest.approx(1.5)
    assert vehicle.run(Mode.MISSION, 30.0, go(u=1.0)).u_d == pytest.approx(1.0)
    assert vehicle.run(Mode.MISSION, 30.0, go(u=0.0)).u_d == pytest.approx(1.5)
    vehicle.run(Mode.MISSION, 10.0, go(u=1.0))
    vehicle.run(Mode.DISARMED, 1.0)
    assert vehicle.run(Mode.MISSION, 60.0).u_d == pytest.approx(1.5)


def test_what_it_remembers_goes_on_in_another() -> None:
    vehicle, twin = KinematicVehicle(), KinematicVehicle()
    vehicle.run(Mode.GUIDED, 50.0, go(80.0, 20.0, 7.0))
    twin.guidance.thaw(vehicle.guidance.freeze())
    twin.x, twin.y, twin.z, twin.psi, twin.u, twin.k = (
        vehicle.x,
        vehicle.y,
        vehicle.z,
        vehicle.psi,
        vehicle.u,
        vehicle.k,
    )
    assert [twin.run(Mode.GUIDED, 0.1) for _ in range(50)] == [vehicle.run(Mode.GUIDED, 0.1) for _ in range(50)]
