"""What is no mission: items that cannot be flown, ways that cross the fence, and a fence that forbids what stands."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py import app, config_files
from firmware_py.adapters.installation import configs
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.plan_builder import plan_of_mission
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.mission import Jump, Loiter, Mission
from firmware_py.records.order import Mode
from firmware_py.records.turning import AS_ASKED
from tests.unit.firmware_py.mavlink.planner import FENCE, MISSION, WAYPOINT, Planner, fields, home, item
from tests.unit.firmware_py.mavlink.station import ORIGIN, LinkedVehicle, node

LIMITS = OperatingLimits(30.0, 2.0, AS_ASKED)
CONFIGURATION = {**config_files.read_configuration(configs() / "npsauv2"), "mission": {"waypoints": []}, "kept": {}}
ACCEPTED, X = mavlink.MAV_MISSION_ACCEPTED, mavlink.MAV_MISSION_INVALID_PARAM5_X
LOITER_UNLIM, LOITER_TURNS, LOITER_TIME = 17, 18, 19
LAND, DO_JUMP, SPEED, LEARN = 21, 177, 178, 31010
TERRAIN, OFFSET = mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT, mavlink.MAV_FRAME_LOCAL_OFFSET_NED
INCLUDE, EXCLUDE, INCLUDE_CIRCLE, EXCLUDE_CIRCLE = 5001, 5002, 5003, 5004
NAN, INF = math.nan, math.inf

REFUSED = [
    (item(z=3.0), mavlink.MAV_MISSION_INVALID_PARAM7, "3.00 m above the water"),
    (item(z=NAN), mavlink.MAV_MISSION_INVALID_PARAM7, "nan is not a height"),
    (item(z=-INF), mavlink.MAV_MISSION_INVALID_PARAM7, "-inf is not a height"),
    (item(z=-40.0), mavlink.MAV_MISSION_INVALID_PARAM7, "depth 40.0 m, limit 30 m"),
    (item(z=1.0, frame=TERRAIN), mavlink.MAV_MISSION_INVALID_PARAM7, "1 m above the bottom, minimum 2 m"),
    (item(north=2e5), mavlink.MAV_MISSION_INVALID_PARAM5_X, "not within 100 km"),
    (item(x=950_000_000), mavlink.MAV_MISSION_INVALID_PARAM5_X, "is not a position"),
    (item(y=1_900_000_000), mavlink.MAV_MISSION_INVALID_PARAM6_Y, "is not a position"),
    (item(frame=12), mavlink.MAV_MISSION_UNSUPPORTED_FRAME, "frame 12"),
    (item(frame=21), mavlink.MAV_MISSION_UNSUPPORTED_FRAME, "frame 21"),
    (item(WAYPOINT, 2e6), mavlink.MAV_MISSION_INVALID_PARAM1, "seconds"),
    (item(WAYPOINT, INF), mavlink.MAV_MISSION_INVALID_PARAM1, "infinite"),
    (item(WAYPOINT, 0, 0, 0, -INF), mavlink.MAV_MISSION_INVALID_PARAM4, "infinite"),
    (item(LOITER_TURNS, NAN), mavlink.MAV_MISSION_INVALID_PARAM1, "turns"),
    (item(LOITER_TIME, 0), mavlink.MAV_MISSION_INVALID_PARAM1, "seconds"),
    (item(LOITER_UNLIM, 0, 0, 5000), mavlink.MAV_MISSION_INVALID_PARAM3, "radius"),
    (item(LOITER_UNLIM, x=0, y=0), mavlink.MAV_MISSION_INVALID_PARAM5_X, "no item before it"),
    (item(SPEED, 2, 1), mavlink.MAV_MISSION_INVALID_PARAM1, "speed type 2"),
    (item(SPEED, 1, 0), mavlink.MAV_MISSION_INVALID_PARAM2, "m/s ahead"),
    (item(DO_JUMP, NAN, 1), mavlink.MAV_MISSION_INVALID_PARAM1, "item"),
    (item(DO_JUMP, 9, 1), mavlink.MAV_MISSION_INVALID_PARAM1, "jumps to item"),
    (item(DO_JUMP, 1, -2), mavlink.MAV_MISSION_INVALID_PARAM2, "times"),
    (item(LEARN, 7), mavlink.MAV_MISSION_INVALID_PARAM1, "manoeuvre 7"),
    (item(LEARN, 0, 1e9, x=0, y=0), mavlink.MAV_MISSION_INVALID_PARAM2, "duration_s"),
    (item(LEARN, 0, 60, 100, x=0, y=0), mavlink.MAV_MISSION_INVALID_PARAM3, "delta_s_deg"),
    (item(LEARN, 2, 60, x=10, y=0), mavlink.MAV_MISSION_INVALID_PARAM5_X, "clock_s"),
    (item(LEARN, 2, 60, x=0, y=999), mavlink.MAV_MISSION_INVALID_PARAM6_Y, "register"),
    (item(mavlink.MAV_CMD_NAV_TAKEOFF), mavlink.MAV_MISSION_UNSUPPORTED, "command 22"),
]


@pytest.mark.parametrize(("bad", "code", "words"), REFUSED, ids=lambda value: str(value)[:24])
def test_an_item_that_cannot_be_flown_ends_the_upload_and_the_old_mission_stays(bad, code: int, words: str) -> None:
    vehicle = LinkedVehicle(limits=LIMITS)
    planner, old = Planner(vehicle), home(item(north=50), item(north=60))
    assert planner.upload(old) == ACCEPTED
    vehicle.step()
    vehicle.node.files_to_save()
    changes = len([order for order in vehicle.orders if order.changes])
    later = [item()] if bad.command != LOITER_UNLIM or bad.x else []
    assert planner.upload(home(*later, bad, item())) == code
    for _ in range(9):
        planner.step()
    assert words in "".join(planner.texts)
    if "jumps to" not in words:
        assert f"mission item {len(later) + 1}: " in "".join(planner.texts)
    assert len([order for order in vehicle.orders if order.changes]) == changes
    assert vehicle.node.files_to_save() == []
    assert fields(planner.download())[1:] == fields(old)[1:]


@pytest.mark.parametrize("jumps", [[item(DO_JUMP, 1, 1)], [item(SPEED, 1, 1.5), item(DO_JUMP, 1, -1)]])
def test_a_mission_that_comes_to_nothing_but_jumps_is_refused(jumps: list) -> None:
    planner = Planner(LinkedVehicle())
    assert planner.upload(home(*jumps)) == mavlink.MAV_MISSION_INVALID_PARAM1
    planner.step()
    assert "mission: jumps lead to jumps alone" in "".join(planner.texts)
    for_ever = jumps[-1].param2 < 0
    assert planner.upload(home(*jumps, item())) == (mavlink.MAV_MISSION_INVALID_PARAM1 if for_ever else ACCEPTED)


def test_a_vehicle_that_keeps_such_a_mission_starts() -> None:
    kept = plan_of_mission(Mission((Jump(0, 1),)), WaterFrame(ORIGIN, 0.0))
    assert len(LinkedVehicle(plans={MISSION: kept}).node.files_to_save()) == 0


def fence(vehicle: LinkedVehicle, *areas) -> Planner:
    """A planner whose vehicle has that fence."""
    planner = Planner(vehicle)
    assert planner.upload(home(*areas, kind=FENCE), FENCE) == ACCEPTED
    return planner


def square(command: int, south: float, west: float, north: float, east: float) -> list:
    corners = ((south, west), (south, east), (north, east), (north, west))
    return [item(command, 4, north=n, east=e, kind=FENCE) for n, e in corners]


def at(north: float, east: float = 0.0, *, command: int = WAYPOINT, p: tuple[float, ...] = ()):
    return item(command, *p, north=north, east=east)


WALL = square(EXCLUDE, 40, -50, 60, 50)
BAY = [
    item(INCLUDE, 6, north=n, east=e, kind=FENCE)
    for n, e in ((0, 0), (0, 100), (100, 100), (100, 80), (20, 80), (20, 0))
]
BALL = [item(EXCLUDE_CIRCLE, 20, north=50, kind=FENCE)]
SHARED = [*square(INCLUDE, -10, -10, 50, 10), *square(INCLUDE, 50, -10, 100, 10)]
WAYS = [
    (WALL, [at(0), at(100)], 2, "the leg to it is within exclusion 1"),
    (WALL, [at(0), at(0, 70), at(100, 70), at(100)], 0, ""),
    (WALL, [at(0), item(SPEED, 1, 1.5), at(100)], 3, "the leg to it is within exclusion 1"),
    (BALL, [at(0), at(100)], 2, "the leg to it is within exclusion 1"),
    (BALL, [at(0, 35), at(100, 35)], 0, ""),
    (BAY, [at(10, 10), at(90, 90)], 2, "the leg to it is outside the fence"),
    (BAY, [at(10, 10), at(10, 90), at(90, 90)], 0, ""),
    (SHARED, [at(0), at(90)], 0, ""),
    (WALL, [at(0), at(0, 70), at(100, 70), at(100), item(DO_JUMP, 1, 2)], 5, "the leg back is within exclusion 1"),
    (WALL, [at(0), item(DO_JUMP, 5, 1), at(0, 70), at(100, 70), at(100)], 5, "the leg to it is within exclusion 1"),
    (WALL, [at(0), item(DO_JUMP, 5, 0), at(0, 70), at(100, 70), at(100)], 0, ""),
    (WALL, [at(0), item(DO_JUMP, 1, -1), at(100)], 0, ""),  # nobody comes to the last one
    (WALL, [at(0), item(LAND, x=0, y=0, z=0.0), at(100)], 0, ""),
    (WALL, [at(0), at(100, command=LAND)], 2, "the leg to it is within exclusion 1"),
    (WALL, [at(50, 75, command=LOITER_TURNS, p=(1, 0, 30))], 1, "within exclusion 1"),
    (WALL, [at(50, 75, command=LOITER_TURNS, p=(1, 0, 15))], 0, ""),
    (BALL, [at(50, 0, command=LOITER_TURNS, p=(1, 0, 60)), at(50, 90)], 0, ""),  # around it, and away
    (BALL, [at(50, 0, command=LOITER_TURNS, p=(1, 0, 21))], 1, "within exclusion 1"),
]


@pytest.mark.parametrize(("areas", "items", "bad", "words"), WAYS)
def test_the_ways_between_places_keep_to_the_fence_too(areas: list, items: list, bad: int, words: str) -> None:
    planner = fence(LinkedVehicle(), *areas)
    code = planner.upload(home(*items))
    planner.step()
    assert code == (X if bad else ACCEPTED), planner.texts
    if bad:
        assert f"mission item {bad}: {words}" in "".join(planner.texts)


def commanded(planner: Planner, number: int, *params: float) -> list[int]:
    planner.station.messages.clear()
    planner.station.command(number, *params)
    planner.vehicle.step(2)
    acks = [m for m in planner.station.messages if m.get_type() == "COMMAND_ACK"]
    planner.texts += [m.text for m in planner.station.messages if m.get_type() == "STATUSTEXT"]
    return [m.result for m in acks]


AUTO = [
    (mavlink.MAV_CMD_DO_SET_MODE, 1, 4, 4),
    (mavlink.MAV_CMD_MISSION_START, 0, 0),
    (mavlink.MAV_CMD_DO_PAUSE_CONTINUE, 1),
    (mavlink.MAV_CMD_DO_SET_STANDARD_MODE, 6),
]


@pytest.mark.parametrize("auto", AUTO)
@pytest.mark.parametrize(("identity", "second"), [(Identity.ARDUSUB, 2), (Identity.GENERIC, 1)])
def test_a_fence_that_forbids_the_mission_is_taken_and_the_mission_is_not_flown(
    auto: tuple, identity: Identity, second: int
) -> None:
    vehicle = LinkedVehicle()
    vehicle.node = node(identities=(identity,))
    planner, items = Planner(vehicle), [at(0), at(100)]
    items = home(*items) if identity is Identity.ARDUSUB else home(*items)[1:]
    for i, each in enumerate(items):
        each.seq = i
    assert planner.upload(items) == ACCEPTED
    vehicle.mode = Mode.HOLD
    assert commanded(planner, *auto) == [mavlink.MAV_RESULT_ACCEPTED]
    vehicle.mode = Mode.HOLD
    assert planner.upload(home(*WALL, kind=FENCE), FENCE) == ACCEPTED
    planner.step()
    words = f"item {second}: the leg to it is within exclusion 1"
    assert words in "".join(planner.texts)
    planner.texts.clear()
    assert commanded(planner, *auto) == [mavlink.MAV_RESULT_TEMPORARILY_REJECTED]
    assert vehicle.mode is Mode.HOLD
    assert words in "".join(planner.texts)
    assert len(planner.download()) == len(items)  # it stays as it was
    planner.send(mavlink.MAVLink_mission_clear_all_message(1, 1, FENCE))
    vehicle.step(2)
    assert commanded(planner, *auto) == [mavlink.MAV_RESULT_ACCEPTED]


def test_a_depth_limit_that_forbids_the_mission_is_as_good_as_a_fence() -> None:
    parameters = app.parameter_store(CONFIGURATION)
    vehicle = LinkedVehicle(limits=LIMITS, parameters=parameters)
    planner = Planner(vehicle)
    assert planner.upload(home(at(0), item(z=-25.0))) == ACCEPTED
    parameters.set("SAF_DEPTH_MAX", 20.0, armed=False)
    planner.step()
    assert "item 2: depth 25.0 m, limit 20 m" in "".join(planner.texts)
    vehicle.mode = Mode.HOLD
    assert commanded(planner, *AUTO[0]) == [mavlink.MAV_RESULT_TEMPORARILY_REJECTED]
    assert planner.upload(home(at(0), item(z=-15.0))) == ACCEPTED
    assert commanded(planner, *AUTO[0]) == [mavlink.MAV_RESULT_ACCEPTED]


def test_a_limit_that_is_lowered_during_the_upload_holds_for_the_items_that_came_before_it() -> None:
    parameters = app.parameter_store(CONFIGURATION)
    vehicle = LinkedVehicle(limits=LIMITS, parameters=parameters)
    planner, items = Planner(vehicle), home(at(0), item(z=-25.0))
    planner.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), MISSION))
    planner.step()
    planner.send(items[0])
    planner.step()
    parameters.set("SAF_DEPTH_MAX", 20.0, armed=False)
    found = []
    for each in items[1:]:
        planner.send(each)
        found += planner.step()
    assert [m.type for m in found if m.get_type() == "MISSION_ACK"] == [ACCEPTED]
    planner.step()
    assert "item 2: depth 25.0 m, limit 20 m" in "".join(planner.texts)
    vehicle.mode = Mode.HOLD
    assert commanded(planner, *AUTO[0]) == [mavlink.MAV_RESULT_TEMPORARILY_REJECTED]


def test_of_a_long_mission_a_few_items_are_looked_at_in_each_tick_and_it_waits_for_the_last() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    assert planner.upload(home(*(at(0, i % 30) for i in range(400)), at(100))) == ACCEPTED
    assert planner.upload(home(*WALL, kind=FENCE), FENCE) == ACCEPTED
    vehicle.mode = Mode.HOLD
    assert commanded(planner, *AUTO[0]) == [mavlink.MAV_RESULT_TEMPORARILY_REJECTED]
    assert "checked again" in "".join(planner.texts)
    for _ in range(101):
        planner.step()
    assert "item 401: the leg to it" in "".join(planner.texts)


def test_a_waypoint_to_be_held_is_a_circle_for_so_long() -> None:
    vehicle = LinkedVehicle()
    planner, items = Planner(vehicle), home(item(WAYPOINT, 45, north=20))
    assert planner.upload(items) == ACCEPTED
    vehicle.step()
    ((held,),) = (change.mission.items for order in vehicle.orders for change in order.changes)
    assert isinstance(held, Loiter)
    assert held[4:] == (False, 0.0, 0.0, 45.0)
    assert fields(planner.download())[1:] == fields(items)[1:]


def test_an_offset_is_seen_from_where_the_vehicle_is_when_the_mission_comes() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    items = home(item(x=100_000, y=-50_000, z=3.0, frame=OFFSET))
    assert planner.upload(items) == mavlink.MAV_MISSION_UNSUPPORTED_FRAME  # nobody knows yet where it is
    vehicle.step()
    assert planner.upload(items) == ACCEPTED
    vehicle.step()
    ((step,),) = (change.mission.items for order in vehicle.orders for change in order.changes)
    assert step[:3] == (10.0, -5.0, 8.0)  # the vehicle of these tests is at the origin, 5 m deep
    (_, kept) = planner.download()
    assert (kept.frame, kept.x, kept.y, kept.z) == (mavlink.MAV_FRAME_LOCAL_NED, 100_000, -50_000, 8.0)
