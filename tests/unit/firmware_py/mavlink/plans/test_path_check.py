"""Ways that no plan shows: to the first place, around circles whose radius the vehicle chooses, to rally points."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py import app, config_files
from firmware_py.adapters.installation import configs
from firmware_py.mavlink.plans.items import UNLIMITED
from firmware_py.mavlink.plans.path_check import check_first_leg
from firmware_py.records.fence import Fence, Polygon
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Surface, Waypoint
from firmware_py.records.order import Mode
from firmware_py.records.turning import Turning
from tests.unit.firmware_py.mavlink.planner import FENCE, RALLY, WAYPOINT, Planner, home, item
from tests.unit.firmware_py.mavlink.station import STATE, LinkedVehicle, put_together

ACCEPTED, X = mavlink.MAV_MISSION_ACCEPTED, mavlink.MAV_MISSION_INVALID_PARAM5_X
YES, NOT_NOW, DENIED = 0, mavlink.MAV_RESULT_TEMPORARILY_REJECTED, mavlink.MAV_RESULT_DENIED
LOCAL, LOITER, JUMP = mavlink.MAV_FRAME_LOCAL_NED, 17, 177
START, SET_CURRENT = mavlink.MAV_CMD_MISSION_START, mavlink.MAV_CMD_DO_SET_MISSION_CURRENT
EXCLUDE, RALLY_POINT = 5002, 5100
TURNING = Turning(30.0, 20.0, math.radians(4.0), 1.8, 2.5)


def at(x: float, y: float = 0.0, *, command: int = WAYPOINT, p: tuple[float, ...] = (), kind: int = 0):
    return item(command, *p, x=round(x * 1e4), y=round(y * 1e4), z=5.0, frame=LOCAL, kind=kind)


WALL = [at(x, y, command=EXCLUDE, p=(4,), kind=FENCE) for x, y in ((40, -50), (40, 50), (60, 50), (60, -50))]
"""North of the origin, where the vehicle is unless it is put elsewhere."""


def fenced(x: float = 0.0, y: float = 0.0, **state) -> Planner:
    vehicle = LinkedVehicle(limits=OperatingLimits(30.0, 2.0, TURNING))
    vehicle.state = {"eta": STATE.eta._replace(x=x, y=y), **state}
    planner = Planner(vehicle)
    assert planner.upload(home(*WALL, kind=FENCE), FENCE) == ACCEPTED
    vehicle.mode = Mode.HOLD
    vehicle.step()
    return planner


def commanded(planner: Planner, number: int, *params: float) -> int:
    planner.station.messages.clear()
    planner.texts.clear()
    planner.station.command(number, *params)
    planner.vehicle.step(2)
    planner.texts += [m.text for m in planner.station.messages if m.get_type() == "STATUSTEXT"]
    (ack,) = planner.station.acks()
    return ack[1]


AUTO = [
    (mavlink.MAV_CMD_DO_SET_MODE, 1, 3),
    (START, 0, 0),
    (mavlink.MAV_CMD_DO_PAUSE_CONTINUE, 1),
    (mavlink.MAV_CMD_DO_SET_STANDARD_MODE, 6),
]


@pytest.mark.parametrize("auto", AUTO)
def test_a_mission_does_not_begin_where_the_way_to_its_first_place_is_barred(auto: tuple) -> None:
    planner = fenced()
    assert planner.upload(home(at(100), at(100, 70))) == ACCEPTED
    assert commanded(planner, *auto) == NOT_NOW
    assert "the leg from here to item 1 is within exclusion 1 of the fence" in "".join(planner.texts)
    assert planner.vehicle.mode is Mode.HOLD
    planner.vehicle.state = {"eta": STATE.eta._replace(x=80.0)}
    planner.vehicle.step()
    assert commanded(planner, *auto) == YES
    assert planner.vehicle.mode is Mode.MISSION


AREA = Polygon(((40.0, -50.0), (40.0, 50.0), (60.0, 50.0), (60.0, -50.0)))
LIMITS = UNLIMITED._replace(fence=Fence((), (AREA,)), turning=TURNING)
FAR, NEAR = Waypoint(100.0, 0.0, 5.0, 0.0), Waypoint(0.0, 20.0, 5.0, 0.0)


def around(x: float, y: float, radius: float) -> Loiter:
    return Loiter(x, y, 5.0, 0.0, False, radius, 1.0, 0.0)


@pytest.mark.parametrize(
    ("steps", "at", "wrong"),
    [
        ([FAR], 0, 0),
        ([FAR, NEAR], 1, None),
        ([FAR], 1, None),  # all are flown
        ([around(100.0, 0.0, -20.0)], 0, 0),
        ([around(90.0, 0.0, -200.0)], 0, None),  # it is joined on this side
        ([around(70.0, 0.0, 0.0)], 0, None),  # as wide as it is flown it is joined south of the wall
        ([around(5.0, 60.0, 0.0), FAR], 0, None),
        ([Surface(), FAR], 0, None),  # nothing behind it is flown
        ([Manoeuvre(ManoeuvreKind.PRBS), FAR], 0, None),  # nobody knows where it ends
        ([Jump(2, 1), NEAR, FAR], 0, 2),
        ([Jump(2, -1), NEAR, Jump(3, 1), FAR], 0, 3),
        ([Jump(2, 0), NEAR, FAR], 0, None),
        ([Jump(0, 1)], 0, None),
        ([], 0, None),
    ],
)
def test_the_first_place_is_that_which_is_flown_first(steps: list, at: int, wrong: int | None) -> None:
    found = check_first_leg(steps, at, 0.0, 0.0, LIMITS)
    assert found == (None if wrong is None else (wrong, "within exclusion 1 of the fence"))


def test_nobody_is_refused_who_does_not_know_where_it_is_or_flies_the_mission_already() -> None:
    planner = fenced(position_std=50.0)
    assert planner.upload(home(at(100))) == ACCEPTED
    assert commanded(planner, *AUTO[0]) == YES
    planner.vehicle.state = {}
    planner.vehicle.step()
    assert commanded(planner, *AUTO[0]) == YES
    assert commanded(planner, START, 1) == NOT_NOW  # that would begin anew


def test_a_mission_is_not_sent_on_to_an_item_to_which_the_way_is_barred() -> None:
    planner = fenced()
    assert planner.upload(home(at(0, 20), at(0, 70), at(100, 70), at(100))) == ACCEPTED
    assert commanded(planner, START, 4) == NOT_NOW
    assert "the leg from here to item 4 is within exclusion 1" in "".join(planner.texts)
    assert commanded(planner, SET_CURRENT, 4) == YES  # it is not flown yet
    assert commanded(planner, START, 2) == YES
    assert commanded(planner, SET_CURRENT, 4) == DENIED
    jumps = [order.jump for order in planner.vehicle.orders if order.jump >= 0]
    planner.texts.clear()
    planner.send(mavlink.MAVLink_mission_set_current_message(1, 1, 4))
    planner.step()
    planner.step()
    assert "MISSION_SET_CURRENT refused: the leg from here to item 4" in "".join(planner.texts)
    assert [order.jump for order in planner.vehicle.orders if order.jump >= 0] == jumps


def test_another_mission_that_would_begin_behind_the_fence_is_refused_while_one_is_flown() -> None:
    planner = fenced()
    assert planner.upload(home(at(0, 20))) == ACCEPTED
    assert commanded(planner, *AUTO[0]) == YES
    assert planner.upload(home(at(100), at(100, 70))) == X
    planner.step()
    assert "the mission is flown now, and the leg to its start is within exclusion 1" in "".join(planner.texts)
    assert len(planner.download()) == 2
    assert planner.upload(home(at(0, 70), item(JUMP, 3, 1), at(100, 70), at(0, 90))) == ACCEPTED


def test_a_fence_across_the_way_that_is_being_flown_is_taken_and_said() -> None:
    planner = fenced()
    assert planner.upload(home(at(0, 20), at(0, 90), at(0, 120))) == ACCEPTED
    assert commanded(planner, *AUTO[0]) == YES
    planner.texts.clear()
    across = [at(x, y, command=EXCLUDE, p=(4,), kind=FENCE) for x, y in ((-9, 5), (9, 5), (9, 10), (-9, 10))]
    assert planner.upload(home(*across, kind=FENCE), FENCE) == ACCEPTED
    for _ in range(5):
        planner.step()
    assert "the leg from here to item 1 is within exclusion 1 of the fence" in "".join(planner.texts)
    assert planner.vehicle.mode is Mode.MISSION  # the supervisor brings it up, should it come so far


GOTO = mavlink.MAV_CMD_DO_REPOSITION


@pytest.mark.parametrize(
    ("x", "y", "speed", "why"),
    [
        (50.0, 0.0, 1.0, "the position is within exclusion 1 of the fence"),
        (10.0, 0.0, 1.0, "the circle around the position, 30 m in radius, is within exclusion 1 of the fence"),
        (-15.0, 0.0, 2.5, ""),
        (0.0, 0.0, 2.5, "the circle around the position, 45 m in radius, is within exclusion 1 of the fence"),
        (120.0, 0.0, 1.0, "the leg to the position is within exclusion 1 of the fence"),
        (120.0, 190.0, 1.0, ""),
    ],
)
def test_a_place_is_gone_to_if_the_way_and_the_circle_there_are_free(
    x: float, y: float, speed: float, why: str
) -> None:
    planner = fenced()
    vehicle, station = planner.vehicle, planner.station
    vehicle.mode = Mode.GUIDED
    vehicle.step()
    mask = 8 | 16 | 32 | 64 | 128 | 256 | 1024 | 2048
    lines = [
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, mavlink.MAV_FRAME_LOCAL_NED, mask & ~24, x, y, 5.0, speed, 0, 0, 0, 0, 0, 0, 0
        ),
        mavlink.MAVLink_command_int_message(
            1, 1, mavlink.MAV_FRAME_LOCAL_NED, GOTO, 0, 0, speed, 1, 0, 0, round(x * 1e4), round(y * 1e4), 5.0
        ),
    ]
    for line in lines:
        vehicle.orders.clear()
        station.messages.clear()
        station.send(line)
        vehicle.step(3)
        sent = [order.setpoint for order in vehicle.orders if math.isfinite(order.setpoint.x)]
        said = "".join(put_together([m for m in station.messages if m.get_type() == "STATUSTEXT"]))
        assert said.endswith(why) if why else not said
        assert len(sent) == (0 if why else 1)


def test_no_more_places_are_looked_at_in_a_tick_than_it_has_time_for() -> None:
    planner = fenced()
    planner.vehicle.mode = Mode.GUIDED
    planner.vehicle.step()
    for i in range(6):
        place = round(-1e6 + i), 0
        planner.station.send(mavlink.MAVLink_command_int_message(1, 1, LOCAL, GOTO, 0, 0, 1.0, 1, 0, 0, *place, 5.0))
    planner.vehicle.step(8)
    assert [result for _, result in planner.station.acks()] == [DENIED, DENIED, YES, YES, YES, YES]


@pytest.mark.parametrize(
    ("x", "radius", "speed", "code"),
    [
        (8.0, 0.0, 1.8, X),  # 32.2 m at 1.8 m/s
        (8.0, 5.0, 1.8, X),
        (8.0, 0.0, 0.0, X),  # the cruising speed
        (5.0, 0.0, 1.8, ACCEPTED),
        (7.0, 0.0, 1.0, ACCEPTED),  # 30 m; there is to be room for a twelfth of it
        (-4.0, -20.0, 9.0, X),  # 44.8 m at 2.5 m/s
        (-9.0, -20.0, 9.0, ACCEPTED),
    ],
)
def test_a_circle_is_as_wide_as_it_will_be_flown(x: float, radius: float, speed: float, code: int) -> None:
    planner = fenced()
    items = [item(178, 1, speed)] if speed else []
    assert planner.upload(home(*items, at(x, command=LOITER, p=(0, 0, radius)))) == code


CONFIGURATION = {**config_files.read_configuration(configs() / "npsauv2"), "mission": {"waypoints": []}, "kept": {}}


@pytest.mark.parametrize(
    ("name", "value", "gap", "before", "after"),
    [
        ("GDN_LOIT_RADIUS", 60.0, 50.0, ACCEPTED, X),
        ("GDN_TURN_RADIUS", 45.0, 50.0, ACCEPTED, X),
        ("GDN_TURN_RATE", 2.0, 50.0, ACCEPTED, X),
        ("GDN_CRUISE", 2.4, 40.0, ACCEPTED, X),
        ("GDN_SPEED_MAX", 1.0, 33.5, X, ACCEPTED),
    ],
)
def test_what_makes_circles_wider_holds_for_the_next_mission(
    name: str, value: float, gap: float, before: int, after: int
) -> None:
    parameters, turning = (
        app.parameter_store(CONFIGURATION),
        config_files.autopilot_params(CONFIGURATION).guidance.turning,
    )
    vehicle = LinkedVehicle(limits=OperatingLimits(30.0, 2.0, turning), parameters=parameters)
    planner, circle = Planner(vehicle), home(at(40.0 - gap, command=LOITER))
    assert planner.upload(home(*WALL, kind=FENCE), FENCE) == ACCEPTED
    assert planner.upload(circle) == before
    parameters.set(name, value, armed=False)
    vehicle.step(2)
    assert planner.upload(circle) == after


def test_a_fence_that_strands_a_rally_point_is_taken_and_says_so() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    points = [at(x, kind=RALLY, command=RALLY_POINT) for x in (0, 50)]
    assert planner.upload(home(*points, kind=RALLY), RALLY) == ACCEPTED
    assert planner.upload(home(*WALL, kind=FENCE), FENCE) == ACCEPTED
    planner.step()
    assert "rally point 1 is within exclusion 1 of the fence: the vehicle will not return to it" in "".join(
        planner.texts
    )
    assert len(planner.download(RALLY)) == 2
    assert planner.upload(home(points[1], kind=RALLY), RALLY) == X
    many = [at(0, y, kind=RALLY, command=RALLY_POINT) for y in range(33)]
    assert planner.upload(home(*many, kind=RALLY), RALLY) == mavlink.MAV_MISSION_NO_SPACE
