"""Items of a mission other than waypoints: circles, jumps, legs above the bottom, and how a mission ends."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.guidance.route import Route
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.fence import HOME, NO_FENCE, Fence, Place, Polygon
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Mission, Surface, Waypoint
from firmware_py.records.order import Mode, Order

from .test_guidance import Kinematic

PARAMS = GuidanceParams()


def at(x: float, y: float = 0.0, z: float = 5.0) -> Waypoint:
    return Waypoint(x, y, z, 1.8)


class OverBottom(Kinematic):
    """A vehicle that sees the bottom, whose depth is a function of the place."""

    def __init__(self, guidance: Guidance, bottom: Callable[[float], float], **start: float) -> None:
        super().__init__(guidance, **start)
        self.bottom = bottom

    @property
    def state(self) -> StateEstimate:
        return dataclasses.replace(super().state, altitude=self.bottom(self.x) - self.z)


def kinematic(*items, rally: tuple[Place, ...] = (), fence: Fence = NO_FENCE, **start: float) -> Kinematic:
    guidance = Guidance(PARAMS, Mission(items), rally=rally, fence=fence)
    return Kinematic(guidance, **{"z": 5.0, "u": 1.8, **start})


def flown(vehicle: Kinematic, seconds: float) -> list[int]:
    """The items that were flown, in their order, until the mission was over."""
    items = [vehicle.step(Mode.MISSION).item]
    for _ in range(round(20 * seconds)):
        if vehicle.guidance.finished:
            return [item for item, _ in itertools.groupby(items)]
        items.append(vehicle.step(Mode.MISSION).item)
    raise AssertionError(f"not over after {seconds} s: {items[-1]}")


@pytest.mark.parametrize(("radius", "turns"), [(40.0, 1.5), (-50.0, 1.0), (0.0, 2.0), (5.0, 1.0)])
def test_a_circle_is_gone_around_as_often_as_it_says(radius: float, turns: float) -> None:
    vehicle = kinematic(Loiter(150.0, 30.0, 8.0, 1.8, False, radius, turns, 0.0), at(400.0))
    bearings, distances = [], []
    while (reference := vehicle.step(Mode.MISSION)).item == 0:
        x, y = vehicle.x - 150.0, vehicle.y - 30.0
        bearings.append(math.atan2(y, x))
        distances.append(math.hypot(x, y))
        assert vehicle.k < 20_000
    around = sum(
        (b - a + math.pi) % math.tau - math.pi
        for a, b, r in zip(bearings, bearings[1:], distances, strict=False)
        if r < 1.3 * max(abs(radius), 35.0)
    )
    assert around == pytest.approx(math.copysign(math.tau * turns, radius), abs=1.0)
    widest = 1.25 * 1.8 / PARAMS.turn_rate_max  # a tighter circle cannot be flown
    assert distances[-1] == pytest.approx(max(abs(radius) or PARAMS.loiter_radius, widest), abs=1.5)
    assert vehicle.z == pytest.approx(8.0, abs=0.05)
    assert reference.item == 1
    assert "loiter done at item 1" in vehicle.events


def test_a_circle_ends_after_its_time_and_one_without_an_end_does_not() -> None:
    timed = kinematic(Loiter(0.0, 0.0, 5.0, 1.8, False, 40.0, 0.0, 100.0))
    seconds = 0.05 * len([timed.step(Mode.MISSION) for _ in iter(lambda: timed.guidance.finished, True)])
    assert 100.0 < seconds < 140.0  # it has to get onto the circle first
    endless = kinematic(Loiter(0.0, 0.0, 5.0, 1.8, False, 40.0, 0.0, 0.0))
    endless.run(Mode.MISSION, 600.0)
    assert not endless.guidance.finished


def test_a_jump_is_made_as_often_as_it_says_and_again_in_an_outer_loop() -> None:
    inner = (at(60.0), at(60.0, 80.0), Jump(0, 2), at(-60.0))
    assert flown(kinematic(*inner), 900.0) == [0, 1, 0, 1, 0, 1, 3, 4]
    assert flown(kinematic(*inner, Jump(1, 1)), 1500.0) == [0, 1, 0, 1, 0, 1, 3, 1, 0, 1, 0, 1, 3, 5]


def test_jumps_that_lead_nowhere_end_the_mission() -> None:
    vehicle = kinematic(at(30.0), Jump(2, -1), Jump(1, -1))
    assert flown(vehicle, 60.0) == [0, 3]
    assert Route(Mission((Jump(0, -1),))).finished


@given(st.lists(st.one_of(
    st.builds(Jump, st.integers(0, 6), st.integers(-1, 2)), st.just(at(1e4)), st.just(Surface()),
    st.just(Surface(rally=True)),
), min_size=1, max_size=7), st.booleans())  # fmt: skip
def test_whatever_jumps_where_the_next_item_is_one_that_can_be_flown(items: list, rally: bool) -> None:
    items = [item._replace(to=item.to % len(items)) if isinstance(item, Jump) else item for item in items]
    route = Route(Mission(tuple(items)), (Place(5.0, 5.0),) if rally else ())
    for _ in range(30):
        assert route.finished or isinstance(route.current, Waypoint) or items[route.item] == Surface(rally=True)
        route.leave(0.0, 0.0, 5.0)
    for i in range(len(items)):
        route.jump(i, 0.0, 0.0, 5.0)
        assert route.finished or isinstance(route.current, Waypoint)
    other = Route(Mission(tuple(items)), (Place(5.0, 5.0),) if rally else ())
    other.thaw(route.freeze())
    assert (other.item, other.current) == (route.item, route.current)


def test_an_order_jumps_to_an_item_at_once_or_when_the_mission_is_taken_up() -> None:
    vehicle = kinematic(at(100.0), at(200.0), at(300.0))
    vehicle.run(Mode.MISSION, 5.0)
    assert vehicle.step(Mode.MISSION, Order(jump=2)).item == 2
    assert vehicle.step(Mode.HOLD, Order(jump=1)).item == 1
    assert vehicle.run(Mode.MISSION, 1.0)[-1].item == 1
    assert vehicle.step(Mode.MISSION, Order(jump=7)).item == 1  # there is none
    assert vehicle.run(Mode.DISARMED, 1.0)[-1].item == 0  # disarming starts it anew
    assert vehicle.step(Mode.DISARMED, Order(jump=2)).item == 2  # and what is set then holds
    assert vehicle.run(Mode.MISSION, 1.0)[-1].item == 2


def test_a_leg_above_the_bottom_follows_its_slope_within_the_limits() -> None:
    guidance = Guidance(PARAMS, Mission((Waypoint(600.0, 0.0, 6.0, 1.8, above=True),)), 30.0, 2.0)
    vehicle = OverBottom(guidance, lambda x: 18.0 + 0.08 * x, z=12.0, u=1.8)
    vehicle.run(Mode.MANUAL, 0.1)
    references = [vehicle.step(Mode.MISSION) for _ in iter(lambda: vehicle.x > 500.0, True)]
    slope = [(x, r.z_d) for x, r in zip(itertools.accumulate([0.09] * len(references)), references, strict=True)]
    on_it = [(x, z) for x, z in slope if 60.0 < x < 180.0]
    lag = 3.0 * PARAMS.depth_way * 0.08
    assert max(abs(18.0 + 0.08 * x - 6.0 - z) for x, z in on_it) == pytest.approx(lag, abs=0.05)
    assert max(z for _, z in slope) == pytest.approx(29.0, abs=0.05)  # a metre off depth_max, however deep the bottom


def test_above_the_bottom_is_never_nearer_than_the_floor_and_a_bottom_unseen_changes_nothing() -> None:
    low = Mission((Waypoint(600.0, 0.0, 0.5, 1.8, above=True),))
    vehicle = OverBottom(Guidance(PARAMS, low, 100.0, 2.0), lambda _: 20.0, z=10.0, u=1.8)
    assert vehicle.run(Mode.MISSION, 120.0)[-1].z_d == pytest.approx(17.0, abs=0.01)
    blind = OverBottom(Guidance(PARAMS, low, 100.0, 2.0), lambda _: math.nan, z=10.0, u=1.8)
    blind.run(Mode.MANUAL, 0.1)
    assert {round(r.z_d, 6) for r in blind.run(Mode.MISSION, 60.0)} == {10.0}


def test_it_is_told_whether_the_bottom_tells_the_depth_that_is_flown() -> None:
    below, above = Waypoint(30.0, 0.0, 8.0, 1.8), Waypoint(90.0, 0.0, 6.0, 1.8, above=True)
    vehicle = OverBottom(Guidance(PARAMS, Mission((below, above)), 30.0, 2.0), lambda _: 14.0, z=8.0, u=1.8)
    assert not vehicle.run(Mode.MANUAL, 0.1)[-1].above
    told = {reference.item: reference.above for reference in vehicle.run(Mode.MISSION, 60.0)}
    assert told == {0: False, 1: True, 2: False}
    vehicle = OverBottom(Guidance(PARAMS, Mission((above,)), 30.0, 2.0), lambda _: 14.0, z=8.0, u=1.8)
    assert [vehicle.run(mode, 1.0)[-1].above for mode in (Mode.MISSION, Mode.HOLD, Mode.SURFACE)] == [
        True,
        False,
        False,
    ]


def test_a_mission_ends_where_it_says_and_goes_to_the_nearest_rally_point_first() -> None:
    rally = (Place(-100.0, 0.0), Place(60.0, 90.0))
    assert flown(kinematic(at(30.0), Surface(), at(900.0)), 60.0) == [0, 3]
    assert flown(kinematic(at(30.0), Surface(rally=True), at(900.0)), 60.0) == [0, 3]  # there is none
    vehicle = kinematic(at(30.0), Surface(rally=True), at(900.0), rally=rally)
    assert flown(vehicle, 300.0) == [0, 1, 3]
    assert math.hypot(vehicle.x - 60.0, vehicle.y - 90.0) < PARAMS.line_of_sight.acceptance + 0.1
    assert vehicle.z == pytest.approx(5.0, abs=0.01)


@pytest.mark.parametrize("items", [(), (at(900.0), at(900.0, 900.0))])
def test_returning_is_to_the_nearest_rally_point_at_the_depth_that_is_with_a_mission_or_without(items: tuple) -> None:
    vehicle = kinematic(*items, rally=(Place(-300.0, 0.0), Place(60.0, 90.0)), z=8.0)
    vehicle.run(Mode.MANUAL, 1.0)
    vehicle.run(Mode.HOLD, 2.0)
    assert not vehicle.guidance.finished or not items
    for _ in range(20 * 300):
        vehicle.step(Mode.RETURN)
        if vehicle.guidance.finished:
            break
    assert math.hypot(vehicle.x - 60.0, vehicle.y - 90.0) < PARAMS.line_of_sight.acceptance + 0.1
    assert vehicle.z == pytest.approx(8.0, abs=0.01)
    assert vehicle.events == ["rally point reached"]


WALL = Fence((), (Polygon(((40.0, -20.0), (40.0, 200.0), (50.0, 200.0), (50.0, -20.0))),))
"""North of the vehicle, which starts at the origin."""


def homing(*items, x: float = 150.0, y: float = 90.0, std: float = 1.0, **given) -> Kinematic:
    """Return a vehicle that goes home, from (x, y)."""

    class Homing(Kinematic):
        @property
        def state(self) -> StateEstimate:
            return dataclasses.replace(super().state, position_std=std)

    vehicle = Homing(Guidance(PARAMS, Mission(items), returns=(HOME,), **given), x=x, y=y, z=8.0, u=1.8)
    vehicle.run(Mode.MANUAL, 0.1)
    return vehicle


@pytest.mark.parametrize(("x", "std"), [(150.0, 1.0), (150.0, 120.0), (0.0, 20.0)])
def test_returning_without_a_rally_point_is_home_at_the_depth_that_is(x: float, std: float) -> None:
    vehicle = homing(at(900.0), x=x, y=0.0, std=std)
    reference = vehicle.step(Mode.RETURN)
    assert vehicle.guidance.finished or (reference.rally, reference.target) == (HOME, HOME)
    for _ in range(20 * 300):
        if vehicle.guidance.finished:
            break
        vehicle.step(Mode.RETURN)
    assert math.hypot(vehicle.x, vehicle.y) < PARAMS.line_of_sight.acceptance + 0.1
    assert vehicle.z == pytest.approx(8.0, abs=0.01)
    assert vehicle.events == ["home reached"]


@pytest.mark.parametrize("items", [(), (at(160.0, 90.0), Surface(rally=True))])
@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"fence": WALL}, "home has no straight way within the fence"),
        ({"std": 300.0}, "where home lies is not known: "),
    ],
)
def test_home_that_cannot_be_gone_to_is_told_and_the_return_is_over(items: tuple, given: dict, why: str) -> None:
    vehicle = homing(*items, **given)
    mode = Mode.MISSION if items else Mode.RETURN
    for _ in range(400):
        vehicle.step(mode)
        if vehicle.guidance.finished:
            break
    (said,) = [text for text in vehicle.events if "waypoint" not in text]
    assert said.startswith(why)
    assert math.hypot(vehicle.x, vehicle.y) > 160.0
    vehicle.step(Mode.SURFACE)
    assert math.isnan(vehicle.guidance.last.rally.x)


def test_surfacing_does_not_steer_for_home() -> None:
    vehicle = homing()
    assert vehicle.run(Mode.SURFACE, 30.0)[-1].psi_d == pytest.approx(0.0, abs=1e-6)


def test_of_rally_points_and_home_the_nearest_is_returned_to() -> None:
    guidance = Guidance(PARAMS, Mission(), rally=(Place(300.0, 0.0),), returns=(Place(300.0, 0.0), HOME))
    for x, place in ((200.0, Place(300.0, 0.0)), (100.0, HOME)):
        vehicle = Kinematic(guidance, x=x, z=5.0, u=1.8)
        vehicle.run(Mode.MANUAL, 0.1)
        assert vehicle.step(Mode.RETURN).rally == place


@pytest.mark.parametrize("items", [(), (at(10.0), Surface(rally=True))])
def test_a_rally_point_behind_an_exclusion_is_not_returned_to(items: tuple) -> None:
    vehicle = kinematic(*items, rally=(Place(60.0, 0.0), Place(-90.0, 60.0)), fence=WALL)
    vehicle.run(Mode.MANUAL, 0.1)
    for _ in range(20 * 300):
        vehicle.step(Mode.MISSION if items else Mode.RETURN)
        assert WALL.problem_at(vehicle.x, vehicle.y) == ""
        if vehicle.guidance.finished:
            break
    assert math.hypot(vehicle.x + 90.0, vehicle.y - 60.0) < PARAMS.line_of_sight.acceptance + 0.1


NO_WAY = "no rally point has a straight way within the fence"


def test_returning_is_over_at_once_and_says_why_where_no_way_keeps_to_the_fence() -> None:
    vehicle = kinematic(rally=(Place(60.0, 0.0),), fence=WALL)
    vehicle.run(Mode.MANUAL, 0.1)
    vehicle.step(Mode.RETURN)
    assert vehicle.guidance.finished
    assert vehicle.events == [NO_WAY]


@pytest.mark.parametrize("rally", [(Place(60.0, 0.0),), ()])
def test_a_mission_that_ends_with_a_return_says_why_it_goes_nowhere(rally: tuple[Place, ...]) -> None:
    """Where there are no rally points, coming up is what the item asks for: nothing is to be said."""
    vehicle = kinematic(at(10.0), Surface(rally=True), rally=rally, fence=WALL)
    vehicle.run(Mode.MANUAL, 0.1)  # it follows the vehicle, to its depth
    vehicle.run(Mode.MISSION, 30.0)
    assert vehicle.guidance.finished
    assert vehicle.events == ["waypoint 1 of 1 passed", *[NO_WAY] * len(rally)]


def test_surfacing_does_not_steer_for_a_rally_point_behind_an_exclusion() -> None:
    vehicle = kinematic(rally=(Place(60.0, 0.0), Place(-200.0, 0.0)), fence=WALL, z=20.0)
    vehicle.run(Mode.HOLD, 1.0)
    vehicle.run(Mode.SURFACE, 120.0)
    assert vehicle.x < -20.0
    alone = kinematic(rally=(Place(60.0, 0.0),), fence=WALL, z=20.0, psi=-2.0)
    alone.run(Mode.MANUAL, 0.1)
    assert alone.run(Mode.SURFACE, 60.0)[-1].psi_d == pytest.approx(-2.0, abs=1e-6)


def test_who_turns_round_on_the_way_back_goes_on_with_the_mission_and_returns_from_there_anew() -> None:
    vehicle = kinematic(at(20.0), at(900.0), at(0.0), rally=(Place(0.0, 300.0), Place(900.0, 300.0)))
    vehicle.run(Mode.MANUAL, 0.1)  # it follows the vehicle, to its depth
    vehicle.run(Mode.MISSION, 30.0)
    assert vehicle.step(Mode.RETURN).item == 1
    vehicle.run(Mode.RETURN, 10.0)
    other = kinematic(at(20.0), at(900.0), at(0.0), rally=(Place(0.0, 300.0), Place(900.0, 300.0)))
    other.guidance.thaw(vehicle.guidance.freeze())
    other.x, other.y, other.z, other.psi, other.u, other.k = (
        *(vehicle.x, vehicle.y, vehicle.z, vehicle.psi, vehicle.u, vehicle.k),
    )
    assert other.run(Mode.RETURN, 5.0) == vehicle.run(Mode.RETURN, 5.0)
    assert vehicle.run(Mode.MISSION, 300.0)[0].item == 1
    assert vehicle.x > 500.0
    while not vehicle.guidance.finished:
        vehicle.step(Mode.RETURN)
    assert math.hypot(vehicle.x - 900.0, vehicle.y - 300.0) < PARAMS.line_of_sight.acceptance + 0.1


def test_surfacing_steers_for_the_nearest_rally_point_and_keeps_the_heading_there() -> None:
    vehicle = kinematic(at(900.0), rally=(Place(-200.0, 150.0), Place(5000.0, 0.0)), z=20.0)
    vehicle.run(Mode.MISSION, 30.0)
    vehicle.run(Mode.SURFACE, 200.0)
    assert vehicle.z < 0.1
    distances = []
    for _ in range(4000):
        vehicle.step(Mode.SURFACE)
        distances.append(math.hypot(vehicle.x + 200.0, vehicle.y - 150.0))
    assert min(distances) < 40.0


def test_a_mission_that_is_taken_away_while_it_is_flown_is_over() -> None:
    vehicle = kinematic(at(300.0))
    vehicle.run(Mode.MISSION, 5.0)
    empty = Guidance(PARAMS, Mission())
    empty.thaw(vehicle.guidance.freeze())
    empty.restart()
    assert empty.finished
    vehicle.guidance = empty
    assert all(math.isfinite(reference.z_d) for reference in vehicle.run(Mode.MISSION, 1.0))
    vehicle.step(Mode.HOLD)
    assert not vehicle.guidance.finished  # nobody flies one


def replace_mission(vehicle: Kinematic, *items, rally: tuple[Place, ...] = ()) -> None:
    """Give the vehicle another mission, as `reconfiguration` does, while it flies one."""
    other = Guidance(PARAMS, Mission(items), rally=rally)
    other.thaw(vehicle.guidance.freeze())
    other.restart()
    vehicle.guidance = other


def test_another_mission_begins_at_its_first_item_in_the_middle_of_a_manoeuvre() -> None:
    vehicle = kinematic(Manoeuvre(ManoeuvreKind.PRBS, duration=60.0), at(100.0))
    vehicle.run(Mode.MISSION, 10.0)
    replace_mission(vehicle, at(-50.0), at(-90.0))
    assert flown(vehicle, 300.0) == [0, 1, 2]


def test_another_mission_that_is_a_return_alone_is_returned_from_where_the_vehicle_is() -> None:
    """It flew straight on for ever."""
    vehicle = kinematic(at(900.0), rally=(Place(-30.0, 0.0),))
    vehicle.run(Mode.MANUAL, 0.1)  # it follows the vehicle, to its depth
    vehicle.run(Mode.MISSION, 20.0)
    replace_mission(vehicle, Surface(rally=True), rally=(Place(-30.0, 0.0),))
    assert flown(vehicle, 120.0) == [0, 1]
    assert math.hypot(vehicle.x + 30.0, vehicle.y) < PARAMS.line_of_sight.acceptance + 0.1
    assert vehicle.events == ["rally point reached"]


def test_the_first_leg_of_another_mission_begins_where_the_vehicle_is() -> None:
    """Without a leg a waypoint abeam is no nearer than the turning circle: it went around it for ever."""
    vehicle = kinematic(at(900.0))
    vehicle.run(Mode.MANUAL, 0.1)  # it follows the vehicle, to its depth
    vehicle.run(Mode.MISSION, 20.0)
    x = vehicle.x
    replace_mission(vehicle, at(x + 10.0, 20.0))
    assert flown(vehicle, 60.0) == [0, 1]
    assert vehicle.events == ["waypoint 1 of 1 passed"]


@pytest.mark.parametrize(
    ("items", "passed"),
    [
        ((at(30.0), Jump(3, 1), at(60.0), at(90.0)), ["waypoint 1 of 3 passed", "waypoint 3 of 3 passed"]),
        ((at(30.0), Surface(), at(60.0), at(90.0)), ["waypoint 1 of 3 passed"]),
        ((at(30.0), at(33.0), at(90.0)), [f"waypoint {i} of 3 passed" for i in (1, 2, 3)]),
        ((at(60.0), at(60.0, 80.0), Jump(0, 1)), [f"waypoint {i} of 2 passed" for i in (1, 2, 1, 2)]),
    ],
)
def test_those_waypoints_alone_are_told_as_passed_that_were_flown(items: tuple, passed: list[str]) -> None:
    vehicle = kinematic(*items)
    flown(vehicle, 600.0)
    assert vehicle.events == passed
