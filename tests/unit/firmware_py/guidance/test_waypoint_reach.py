"""A waypoint is reached in three dimensions, or given up, and an event says so."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.records.command import Reference
from firmware_py.records.fence import NO_FENCE, Disc, Fence
from firmware_py.records.mission import Mission, Waypoint
from firmware_py.records.order import NO_ORDER, Mode, Order
from tests.unit.firmware_py.guidance.test_guidance import Kinematic

PARAMS = GuidanceParams()
SIGHT = PARAMS.line_of_sight


class Diver(Kinematic):
    """Notes where each waypoint was passed; `floats` cannot dive."""

    def __init__(self, *points: Waypoint, fence: Fence = NO_FENCE, floats: bool = False) -> None:
        super().__init__(Guidance(PARAMS, Mission(points), fence=fence), u=1.8)
        self.points, self.floats = points, floats
        self.passed: list[tuple[float, float, float]] = []
        """For each: time, s, horizontal distance and how much too deep, m."""
        self.sides: list[float] = []
        self.run(Mode.MANUAL, 0.1)

    def step(self, mode: Mode, order: Order = NO_ORDER) -> Reference:
        x, y, z = self.x, self.y, self.z
        reference = super().step(mode, order)
        self.sides.append(self.y)
        if self.floats:
            self.z = 0.0
        while len(self.passed) < reference.item:
            point = self.points[len(self.passed)]
            self.passed.append((0.05 * self.k, math.hypot(x - point.x, y - point.y), z - point.z))
        return reference

    def fly(self, seconds: float) -> Diver:
        for _ in range(round(20 * seconds)):
            self.step(Mode.MISSION)
            if self.guidance.finished:
                break
        return self


def test_legs_too_short_to_dive_on_are_not_completed_at_the_surface() -> None:
    points = [Waypoint(1.7 * i, 0.0, 4.0, 1.8) for i in range(1, 4)]
    vehicle = Diver(*points).fly(600.0)
    assert vehicle.guidance.finished
    assert [abs(deep) <= SIGHT.depth_acceptance for _, _, deep in vehicle.passed] == [True] * 3
    assert max(off for _, off, _ in vehicle.passed) <= SIGHT.acceptance + 1.7 + 0.2
    assert vehicle.events == [f"waypoint {i} of 3 passed" for i in (1, 2, 3)]


@pytest.mark.parametrize("depth", [9.0, 20.0, 29.0])
def test_a_waypoint_below_a_short_leg_is_passed_at_its_depth_on_a_circle_through_it(depth: float) -> None:
    vehicle = Diver(Waypoint(30.0, 0.0, depth, 1.8), Waypoint(200.0, 0.0, depth, 1.8)).fly(800.0)
    (t, off, deep), _ = vehicle.passed
    assert abs(deep) <= SIGHT.depth_acceptance
    assert off <= SIGHT.acceptance + 0.2
    assert t > 100.0  # after a turn of 30 m radius
    assert vehicle.guidance.finished


def test_a_leg_that_leaves_time_to_dive_is_flown_straight() -> None:
    vehicle = Diver(Waypoint(110.0, 0.0, 5.0, 1.8), Waypoint(220.0, 0.0, 10.0, 1.8)).fly(300.0)
    assert vehicle.guidance.finished
    assert max(map(abs, vehicle.sides)) < 0.1
    assert all(t < 130.0 for t, _, _ in vehicle.passed)


def test_a_depth_that_is_never_reached_is_given_up_in_time_and_said() -> None:
    vehicle = Diver(Waypoint(100.0, 0.0, 4.0, 1.8), Waypoint(400.0, 0.0, 1.0, 1.8), floats=True).fly(900.0)
    assert vehicle.events == ["waypoint 1 of 2 given up 4.0 m too shallow", "waypoint 2 of 2 passed"]
    (given_up, _, _), _ = vehicle.passed
    reached = 100.0 / 1.8
    assert given_up == pytest.approx(reached + SIGHT.depth_time, abs=5.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_circle_is_on_the_side_within_the_fence(side: float) -> None:
    wall = Fence(without=(Disc(30.0, side * 50.0, 20.0),))
    vehicle = Diver(Waypoint(30.0, 0.0, 20.0, 1.8), fence=wall).fly(300.0)
    assert vehicle.guidance.finished
    assert max(side * y for y in vehicle.sides) < 10.0
    assert min(side * y for y in vehicle.sides) < -40.0


def test_who_was_on_the_circle_goes_on_after_a_thaw_as_without() -> None:
    points = Waypoint(30.0, 0.0, 20.0, 1.8), Waypoint(200.0, 0.0, 20.0, 1.8)
    one, other = Diver(*points), Diver(*points)
    one.fly(50.0)
    other.guidance.thaw(one.guidance.freeze())
    for name in ("x", "y", "z", "psi", "u", "k", "passed"):
        setattr(other, name, getattr(one, name))
    after, again = (vehicle.run(Mode.MISSION, 100.0) for vehicle in (one, other))
    assert after == again
    assert any(a.item != b.item for a, b in pairwise(after))


def test_leaving_the_mission_ends_the_circle() -> None:
    vehicle = Diver(Waypoint(30.0, 0.0, 20.0, 1.8))
    vehicle.fly(25.0)
    assert vehicle.guidance.freeze().route.spiral is not None
    assert math.isnan(vehicle.step(Mode.MISSION).cross_track)  # a circle is no leg on which no way could be made
    vehicle.run(Mode.HOLD, 60.0)
    vehicle.fly(1.0)
    assert vehicle.guidance.freeze().route.spiral is None
    assert vehicle.fly(150.0).guidance.finished
