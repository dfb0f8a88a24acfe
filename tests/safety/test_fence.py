"""The fence: what is within an area, and that the supervisor brings up whoever is beyond it."""

from __future__ import annotations

import itertools
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.guidance.rally_point import nearest_rally_point
from firmware_py.records.fence import (
    NO_FENCE,
    Disc,
    Fence,
    Place,
    Polygon,
    fence_from_plain,
    fence_to_plain,
)
from firmware_py.records.order import Arming, Mode, Order
from firmware_py.safety.supervisor import Supervisor

from .test_supervisor import ARM, PARAMS, STATE, SupervisedVehicle

SQUARE = Polygon(((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)))
HOLE = Disc(0.0, 0.0, 2.0)
NUMBERS = st.floats(-1e5, 1e5)
AREAS = st.builds(Disc, NUMBERS, NUMBERS, st.floats(0.1, 1e5)) | st.builds(
    Polygon, st.lists(st.tuples(NUMBERS, NUMBERS), min_size=3, max_size=9).map(tuple)
)


@given(st.lists(AREAS, max_size=4), st.lists(AREAS, max_size=4))
def test_a_fence_survives_a_log(within: list, without: list) -> None:
    fence = Fence(tuple(within), tuple(without))
    assert fence_from_plain(json.loads(json.dumps(fence_to_plain(fence)))) == fence
    assert fence_from_plain({}) == NO_FENCE


@given(st.integers(3, 12), st.floats(-50, 50), st.floats(-50, 50), st.booleans())
def test_a_point_is_in_a_convex_polygon_where_it_is_on_the_inner_side_of_every_edge(
    n: int, x: float, y: float, clockwise: bool
) -> None:
    corners = [(40.0 * math.cos(math.tau * i / n), 30.0 * math.sin(math.tau * i / n)) for i in range(n)]
    sides = [
        (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
        for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    if min(map(abs, sides)) > 1e-6:
        polygon = Polygon(tuple(reversed(corners)) if clockwise else tuple(corners))
        assert polygon.contains(x, y) == (min(sides) > 0.0)


def test_what_is_wrong_with_a_place_is_said() -> None:
    fence = Fence((SQUARE, Disc(30.0, 0.0, 15.0)), (Disc(100.0, 0.0, 1.0), HOLE))
    assert fence.problem_at(5.0, 5.0) == fence.problem_at(40.0, 0.0) == ""
    assert fence.problem_at(1.0, 1.0) == "within exclusion 2 of the fence"
    assert fence.problem_at(-11.0, 0.0) == "outside the fence"
    assert fence.problem_at(math.nan, 0.0) == ""
    assert Fence((), (HOLE,)).problem_at(1e6, 0.0) == ""
    assert NO_FENCE.problem_at(1e6, 0.0) == ""


PLACES = st.tuples(st.floats(-60, 60), st.floats(-60, 60))
NEAR = st.builds(Disc, st.floats(-50, 50), st.floats(-50, 50), st.floats(1, 40)) | st.builds(
    Polygon, st.lists(PLACES, min_size=3, max_size=7).map(tuple)
)


def plainly_wrong(fence: Fence, x: float, y: float) -> bool:
    """Whether a place is wrong, and not only by rounding: a leg may run along an edge."""
    around = [(dx, dy) for dx in (-1e-9, 1e-9) for dy in (-1e-9, 1e-9)]
    return all(fence.problem_at(x + dx, y + dy) for dx, dy in ((0.0, 0.0), *around))


@given(st.lists(NEAR, max_size=3), st.lists(NEAR, max_size=3), PLACES, PLACES)
def test_a_way_is_barred_wherever_a_place_on_it_is(within: list, without: list, start: tuple, end: tuple) -> None:
    fence = Fence(tuple(within), tuple(without))
    places = [(start[0] + i / 500 * (end[0] - start[0]), start[1] + i / 500 * (end[1] - start[1])) for i in range(501)]
    wrong = [plainly_wrong(fence, *place) for place in places[1:-1]]
    if any(a and b for a, b in itertools.pairwise(wrong)):  # two in a row: more than touched
        assert fence.leg_problem(*start, *end)
    if not fence.leg_problem(*start, *end):
        assert not any(a and b for a, b in itertools.pairwise(wrong))


def test_what_is_thinner_than_any_step_bars_a_way_too() -> None:
    needle = Polygon(((50.0, -1.0), (50.0, 1.0), (50.0001, 1.0), (50.0001, -1.0)))
    assert Fence((), (needle,)).leg_problem(0.0, 0.0, 1000.0, 0.0) == "within exclusion 1 of the fence"
    assert Fence((), (needle,)).leg_problem(0.0, 2.0, 1000.0, 2.0) == ""
    assert Fence((SQUARE,), ()).leg_problem(-5.0, 0.0, 5.0, 0.0) == ""
    assert NO_FENCE.leg_problem(0.0, 0.0, 0.0, 0.0) == ""


@given(st.lists(NEAR, max_size=3), st.lists(NEAR, max_size=3), PLACES, st.floats(1, 50))
def test_a_circle_is_barred_wherever_a_place_on_it_is(
    within: list, without: list, centre: tuple, radius: float
) -> None:
    fence = Fence(tuple(within), tuple(without))

    def wrong(r: float) -> bool:
        """In two of 500 places in a row, which is more than touched."""
        places = [(math.cos(math.tau * i / 500), math.sin(math.tau * i / 500)) for i in range(501)]
        breaches = [fence.problem_at(centre[0] + r * north, centre[1] + r * east) for north, east in places]
        return any(a and b for a, b in itertools.pairwise(breaches))

    found = wrong(radius)
    if found == wrong(radius - 1e-6) == wrong(radius + 1e-6):  # it does not run along an edge
        assert bool(fence.circle_problem(*centre, radius)) >= found
    if not fence.circle_problem(*centre, radius):
        assert not wrong(radius - 1e-6) or not wrong(radius + 1e-6)


def test_what_is_thinner_than_any_step_bars_a_circle_too() -> None:
    needle = Polygon(((50.0, -1.0), (50.0, 1.0), (50.0001, 1.0), (50.0001, -1.0)))
    assert Fence((), (needle,)).circle_problem(0.0, 0.0, 50.00005) == "within exclusion 1 of the fence"
    assert Fence((), (needle,)).circle_problem(0.0, 0.0, 49.0) == ""
    assert Fence((SQUARE, Disc(10.0, 0.0, 8.0)), ()).circle_problem(8.0, 0.0, 5.0) == ""  # from one area into the next
    assert Fence((SQUARE,), (HOLE,)).circle_problem(0.0, 0.0, 5.0) == ""  # the hole is within it
    assert NO_FENCE.circle_problem(0.0, 0.0, 5.0) == ""


EAST, NORTH, WEST, FAR = Place(0.0, 9.0), Place(10.0, 0.0), Place(0.0, -9.5), Place(40.0, 0.0)


@pytest.mark.parametrize(
    ("fence", "x", "best"),
    [
        (NO_FENCE, 0.0, EAST),
        (Fence((), (Disc(0.0, 5.0, 1.0),)), 0.0, WEST),  # the way to the nearest is barred
        (Fence((), (Disc(0.0, 9.0, 1.0), Disc(0.0, -5.0, 1.0))), 0.0, NORTH),
        (Fence((Disc(0.0, 0.0, 5.0),)), 0.0, None),  # none is in it
        (Fence((Disc(40.0, 0.0, 5.0),)), 0.0, FAR),  # from beyond it no way is free
        (Fence((Disc(0.0, 0.0, 5.0),)), 20.0, None),
    ],
)
def test_the_rally_point_is_the_nearest_to_which_a_straight_leg_keeps_to_the_fence(
    fence: Fence, x: float, best: Place | None
) -> None:
    assert nearest_rally_point((NORTH, EAST, WEST, FAR), fence, x, 0.0) == best
    assert nearest_rally_point((), fence, x, 0.0) is None


def fenced(mode: Mode) -> SupervisedVehicle:
    vehicle = SupervisedVehicle()
    vehicle.supervisor = Supervisor(PARAMS, fence=Fence((SQUARE,), (HOLE,)))
    at(vehicle, 5.0)
    vehicle.tick(ARM, eta=STATE.eta._replace(x=5.0))
    if mode is not Mode.MANUAL:
        vehicle.tick(type(ARM)(mode=mode), eta=STATE.eta._replace(x=5.0))
    assert vehicle.mode is mode, vehicle.events
    return vehicle


def at(vehicle: SupervisedVehicle, x: float, ticks: int = 1) -> Mode:
    for _ in range(ticks):
        vehicle.tick(eta=STATE.eta._replace(x=x))
    return vehicle.mode


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.LOITER, Mode.GUIDED])
@pytest.mark.parametrize(("x", "words"), [(10.01, "outside the fence"), (1.99, "within exclusion 1 of the fence")])
def test_beyond_the_fence_for_a_second_it_surfaces_from_every_mode(mode: Mode, x: float, words: str) -> None:
    vehicle = fenced(mode)
    assert at(vehicle, x, 100) is mode
    assert at(vehicle, 5.0) is mode  # back in time: the time runs anew
    assert at(vehicle, x, 100) is mode
    assert at(vehicle, x) is Mode.SURFACE
    assert vehicle.events == (f"{mode.name} -> SURFACE: {words}",)
    assert at(vehicle, 5.0, 10) is Mode.SURFACE


OUT = {"eta": STATE.eta._replace(x=20.0, z=0.2)}


def beyond() -> SupervisedVehicle:
    """A disarmed vehicle at the surface, outside the fence."""
    vehicle = SupervisedVehicle()
    vehicle.supervisor = Supervisor(PARAMS, fence=Fence((SQUARE,)))
    return vehicle


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.MISSION, Mode.LOITER, Mode.GUIDED, Mode.RETURN])
def test_beyond_the_fence_nothing_arms_that_steers_itself(mode: Mode) -> None:
    vehicle = beyond()
    assert vehicle.tick(Order(arming=Arming.ARM, mode=mode), **OUT) is Mode.DISARMED
    assert vehicle.events == ("arming refused: outside the fence (MANUAL can be armed, to steer it back)",)


def test_beyond_the_fence_it_is_armed_to_be_steered_back_and_warned_of_it() -> None:
    vehicle = beyond()
    assert vehicle.tick(ARM, **OUT) is Mode.MANUAL
    assert vehicle.events == ("outside the fence", "DISARMED -> MANUAL: ordered")
    for _ in range(500):
        assert vehicle.tick(**OUT) is Mode.MANUAL
    assert at(vehicle, 5.0) is Mode.MANUAL
    assert at(vehicle, 20.0, 100) is Mode.MANUAL  # it was within: from here on the fence holds
    assert at(vehicle, 20.0) is Mode.SURFACE


def test_who_is_steered_back_and_takes_another_mode_has_a_second_for_it() -> None:
    vehicle = beyond()
    vehicle.tick(ARM, **OUT)
    for _ in range(100):
        assert vehicle.tick(Order(mode=Mode.GUIDED), **OUT) is Mode.GUIDED
    assert vehicle.tick(**OUT) is Mode.SURFACE


def test_a_place_that_is_not_known_breaks_no_fence() -> None:
    vehicle = fenced(Mode.HOLD)
    assert at(vehicle, math.nan, 300) is Mode.HOLD


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.LOITER, Mode.GUIDED, Mode.RETURN])
def test_deeper_than_the_depth_limit_it_surfaces_from_every_mode_and_nobody_arms(mode: Mode) -> None:
    vehicle = SupervisedVehicle()
    assert vehicle.tick(ARM, z=PARAMS.depth_max + 0.01) is Mode.DISARMED
    assert vehicle.events == ("arming refused: depth comes to 30.01 m, limit 30 m",)
    vehicle.tick(ARM)
    vehicle.tick(type(ARM)(mode=mode))
    assert vehicle.tick(z=PARAMS.depth_max) is mode
    for _ in range(30):  # depth_max_time: one false sample is no reason
        assert vehicle.tick(z=PARAMS.depth_max + 0.01) is mode
    assert vehicle.tick(z=PARAMS.depth_max + 0.01) is Mode.SURFACE
    assert vehicle.events == (f"{mode.name} -> SURFACE: depth comes to 30.01 m, limit 30 m",)


def test_a_vehicle_that_has_returned_surfaces_and_its_mission_is_not_done() -> None:
    vehicle = SupervisedVehicle()
    vehicle.tick(ARM)
    assert vehicle.tick(type(ARM)(mode=Mode.RETURN), done=True) is Mode.RETURN  # that was said of what was flown before
    assert vehicle.tick() is Mode.RETURN
    assert vehicle.tick(done=True) is Mode.SURFACE
    assert vehicle.events == ("RETURN -> SURFACE: return done",)
    assert not vehicle.answer.mission_done


def test_the_supervisor_says_whether_it_would_arm() -> None:
    vehicle = SupervisedVehicle()
    vehicle.tick()
    assert vehicle.answer.ready
    vehicle.tick(z=31.0)
    assert not vehicle.answer.ready
    vehicle.tick(leak=True)
    assert not vehicle.answer.ready  # before its time has come, as arming would be refused
    vehicle.tick(attitude_ok=False)
    assert not vehicle.answer.ready
    vehicle.tick(ARM)
    assert (vehicle.mode, vehicle.answer.ready) == (Mode.MANUAL, True)
    vehicle.tick(type(ARM)(arming=Arming.FORCE_DISARM))
    vehicle.tick()
    assert vehicle.answer.ready
