"""What becomes of plans: the fence holds everywhere, broken files are said, items are reached and set."""

from __future__ import annotations

import dataclasses
import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.plan_builder import read_plan
from firmware_py.params import ParamError
from firmware_py.records.event import Event, EventKind, Severity
from firmware_py.records.mission import Surface, Waypoint
from firmware_py.records.order import Mode
from tests.unit.firmware_py.mavlink.planner import FENCE, MISSION, RALLY, Planner, fields, home, item
from tests.unit.firmware_py.mavlink.station import ORIGIN, LinkedVehicle, cycle, node, parse

ACCEPTED = mavlink.MAV_MISSION_ACCEPTED
LOITER_UNLIM, LAND, SPEED = 17, 21, 178
INCLUDE, EXCLUDE, INCLUDE_CIRCLE, RALLY_POINT = 5001, 5002, 5003, 5100
X = mavlink.MAV_MISSION_INVALID_PARAM5_X
SEA = WaterFrame(ORIGIN, 0.0)


def test_a_place_beyond_the_fence_is_no_item_no_rally_point_and_no_place_to_be_guided_to() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    square = [item(INCLUDE, 4, north=n, east=e, kind=FENCE) for n, e in ((0, 0), (0, 90), (90, 90), (90, 0))]
    hole = [item(EXCLUDE, 3, north=n, east=e, kind=FENCE) for n, e in ((40, 40), (40, 60), (60, 50))]
    assert planner.upload(home(*square, *hole, kind=FENCE), FENCE) == ACCEPTED
    assert fields(planner.download(FENCE)) == fields(home(*square, *hole, kind=FENCE))
    for north, east, code in ((20, 20, 0), (-1, 20, X), (45, 50, X), (20, 91, X)):
        assert planner.upload(home(item(north=north, east=east))) == code
        point = item(RALLY_POINT, north=north, east=east, kind=RALLY)
        assert planner.upload(home(point, kind=RALLY), RALLY) == code
        place = item(north=north, east=east)
        goto = mavlink.MAVLink_command_int_message(1, 1, 3, 192, 0, 0, -1, 1, 0, math.nan, place.x, place.y, -5.0)
        vehicle.mode = Mode.HOLD
        planner.station.send(goto)
        vehicle.step(2)
        assert planner.station.acks() == [(192, 2 if code else 0)]
    assert planner.upload(home(item(LOITER_UNLIM, 0, 0, 60, north=30, east=30))) == X  # the circle leaves it
    assert planner.upload(home(*square[:3], kind=FENCE), FENCE) == mavlink.MAV_MISSION_INVALID
    too_many = [item(INCLUDE_CIRCLE, 10, north=i, kind=FENCE) for i in range(121)]
    assert planner.upload(home(*too_many, kind=FENCE), FENCE) == mavlink.MAV_MISSION_NO_SPACE
    assert len(planner.download(FENCE)) == 7


def test_landing_is_surfacing_at_a_place_or_where_the_vehicle_is() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    assert planner.upload(home(item(LAND, north=50, z=0.0))) == ACCEPTED
    assert planner.upload(home(item(LAND, x=0, y=0, z=0.0))) == ACCEPTED
    vehicle.step()
    at_a_place, here = (change.mission.items for order in vehicle.orders for change in order.changes)
    assert isinstance(at_a_place[0], Waypoint)
    assert (at_a_place[0].z, at_a_place[1:], here) == (0.0, (Surface(),), (Surface(),))


def test_a_fence_is_in_force_while_there_is_one() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    for on, result in ((1, 2), (0, 2)):
        planner.station.command(mavlink.MAV_CMD_DO_FENCE_ENABLE, on)
        vehicle.step()
        assert planner.station.acks() == [(mavlink.MAV_CMD_DO_FENCE_ENABLE, result)]
    assert planner.upload(home(item(INCLUDE_CIRCLE, 50, kind=FENCE), kind=FENCE), FENCE) == ACCEPTED
    for on, result in ((1, 0), (0, 2)):
        planner.station.command(mavlink.MAV_CMD_DO_FENCE_ENABLE, on)
        vehicle.step(2)
        assert planner.station.acks() == [(mavlink.MAV_CMD_DO_FENCE_ENABLE, result)]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "Expecting value"),
        ("[]", "list indices"),
        ('{"items": [[16, 3]]}', "missing"),
        ('{"items": [[16, 3, 1, 0, 0, 0, 0, 1e12, 0, 0]]}', "integer"),
        ('{"items": [[9999, 3, 1, 0, 0, 0, 0, 0, 0, 0]]}', "command 9999"),
        ('{"items": [["a", 3, 1, 0, 0, 0, 0, 0, 0, 0]]}', "mission cannot be used"),
    ],
)
def test_a_kept_mission_that_is_broken_is_said_in_a_line(content: str, words: str) -> None:
    with pytest.raises(ParamError) as caught:
        read_plan(MISSION, content, SEA)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_items_are_reached_and_the_next_one_is_current_as_the_link_counts_them() -> None:
    vehicle = LinkedVehicle(links=2)
    vehicle.node = node(identities=(Identity.ARDUSUB, Identity.GENERIC))
    planner = Planner(vehicle)
    planner.upload(home(item(north=10), item(SPEED, 1, 2.0), item(north=20), item(north=30)))
    planner.step()
    reached: list[list[int]] = [[], []]
    current: list[list[int]] = [[], []]
    for k in range(400):
        now = cycle(vehicle.k + k, Mode.MISSION)
        now = dataclasses.replace(now, reference=dataclasses.replace(now.reference, item=min(k // 100, 3)))
        for link, datagram in enumerate(vehicle.node.report(now)):
            for m in mavlink.MAVLink(None).parse_buffer(datagram) or []:
                if m.get_type() == "MISSION_ITEM_REACHED":
                    reached[link].append(m.seq)
                if m.get_type() == "MISSION_CURRENT":
                    current[link].append(m.seq)
                    assert (m.total, m.mission_state) == (4, mavlink.MISSION_STATE_ACTIVE)
    assert reached == [[1, 3, 4], [0, 2, 3]]
    assert [*dict.fromkeys(current[0])] == [1, 3, 4]
    assert [*dict.fromkeys(current[1])] == [0, 2, 3]


@pytest.mark.parametrize(("step", "numbers"), [(0, [1, 0]), (1, [3, 2]), (2, [4, 3])])
def test_high_latency_names_the_item_as_mission_current_does(step: int, numbers: list[int]) -> None:
    planner = Planner(LinkedVehicle())
    planner.upload(home(item(north=10), item(SPEED, 1, 2.0), item(north=20), item(north=30)))
    kept = read_plan(MISSION, dict(planner.station.vehicle.node.files_to_save())["mission.json"].decode(), SEA)
    links = [LinkConfiguration(identity, high_latency=True) for identity in Identity]
    now = cycle(0, Mode.MISSION)
    now = dataclasses.replace(now, reference=dataclasses.replace(now.reference, item=step))
    for plans, expected in (({MISSION: kept}, numbers), ({}, [0, 0])):
        said = [parse(datagram)[0] for datagram in node(configurations=links, plans=plans).report(now)]
        assert [m.wp_num for m in said] == expected


def test_an_item_that_is_given_up_is_not_reached() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    planner.upload(home(item(north=10), item(north=20), item(north=30)))
    planner.step()
    reached = []
    missed = Event(EventKind.WAYPOINT_MISSED, Severity.WARNING, numbers=(1.0, 3.0, 2.8))
    for k in range(300):
        now = cycle(vehicle.k + k, Mode.MISSION, events=(missed,) if k == 100 else ())
        now = dataclasses.replace(now, reference=dataclasses.replace(now.reference, item=k // 100))
        for datagram in vehicle.node.report(now):
            found = mavlink.MAVLink(None).parse_buffer(datagram) or []
            reached += [m.seq for m in found if m.get_type() == "MISSION_ITEM_REACHED"]
    assert reached == [2]


def test_what_is_behind_the_end_of_a_mission_is_not_reached() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    planner.upload(home(item(north=10), item(LAND, x=0, y=0, z=0.0), item(north=20), item(north=30)))
    planner.step()
    reached = []
    for k in range(200):
        now = cycle(vehicle.k + k, Mode.MISSION)
        now = dataclasses.replace(now, reference=dataclasses.replace(now.reference, item=4 if k >= 100 else 0))
        for datagram in vehicle.node.report(now):
            found = mavlink.MAVLink(None).parse_buffer(datagram) or []
            reached += [m.seq for m in found if m.get_type() == "MISSION_ITEM_REACHED"]
    assert reached == [1, 2]


@pytest.mark.parametrize(("seq", "jump"), [(1, 0), (2, 1), (3, 1), (0, 0)])
def test_an_item_that_is_set_is_flown_next(seq: int, jump: int) -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    planner.upload(home(item(north=10), item(SPEED, 1, 2.0), item(north=20)))
    planner.send(mavlink.MAVLink_mission_set_current_message(1, 1, seq))
    said = [m.get_type() for _ in range(3) for m in planner.step()]
    assert [order.jump for order in vehicle.orders if order.jump >= 0] == [jump]
    assert "MISSION_CURRENT" in said
    planner.station.command(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, seq)
    vehicle.step()
    assert planner.station.acks() == [(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 0)]
    planner.station.command(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 4)
    vehicle.step()
    assert planner.station.acks() == [(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 2)]
