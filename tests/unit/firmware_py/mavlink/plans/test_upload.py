"""The mission protocol: up, down, refused, repeated, lost; pymavlink packs and reads every message."""

from __future__ import annotations

import itertools
import json
import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.water_frame import WaterFrame
from firmware_py.mavlink.plans.mission_items import items_of
from firmware_py.mavlink.plans.plan_builder import FILES, plan_of_mission, read_plan
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Mission, Surface, Waypoint
from firmware_py.records.mission_tables import mission_from_plain, mission_to_plain
from firmware_py.records.order import FenceChange, MissionChange, RallyChange
from firmware_py.wire.log.changes import decode, encode
from tests.unit.firmware_py.mavlink.planner import FENCE, MISSION, RALLY, WAYPOINT, Planner, fields, home, item
from tests.unit.firmware_py.mavlink.station import ORIGIN, LinkedVehicle, cycle, node

ACCEPTED = mavlink.MAV_MISSION_ACCEPTED
LOITER_UNLIM, LOITER_TURNS, LOITER_TIME = 17, 18, 19
RETURN, LAND, DO_JUMP, SPEED, LEARN = 20, 21, 177, 178, 31010
TERRAIN, LOCAL, IN_MISSION = mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT, 1, mavlink.MAV_FRAME_MISSION
INCLUDE, INCLUDE_CIRCLE, RALLY_POINT = 5001, 5003, 5100
NAN, INF = math.nan, math.inf
SEA = WaterFrame(ORIGIN, 0.0)


def everything_that_can_be_flown() -> list:
    return home(
        item(SPEED, 1, 1.5, frame=IN_MISSION),
        item(north=100),
        item(north=100, east=100, z=8.0, frame=TERRAIN),
        item(LOITER_TURNS, 2, 0, -40, NAN, north=200),
        item(LOITER_TIME, 60, north=200, x=0, y=0),
        item(LEARN, 2, 60, 15, -1, frame=IN_MISSION, x=2500, y=33, z=0.0),
        item(DO_JUMP, 2, 3, frame=IN_MISSION),
        item(x=1_000_000, y=-500_000, frame=LOCAL, z=7.0),
        item(RETURN),
    )


def ordered(vehicle: LinkedVehicle) -> Mission | None:
    """The mission of the last order that changed it, as a replay reads it."""
    changes = [decode(encode(change)) for order in vehicle.orders for change in order.changes]
    found = [change.mission for change in changes if isinstance(change, MissionChange)]
    return found[-1] if found else None


def test_what_goes_up_is_flown_and_comes_down_as_it_went_up() -> None:
    vehicle = LinkedVehicle()
    planner, items = Planner(vehicle), everything_that_can_be_flown()
    assert planner.upload(items) == ACCEPTED
    vehicle.step()
    mission = ordered(vehicle)
    first, second, around, timed, learn, jump, local, end = mission.items
    assert first[2:] == (5.0, pytest.approx(1.5), False)
    assert (first.x, first.y) == pytest.approx((111.2, 0.0), abs=0.3)
    assert (second.z, second.above) == (8.0, True)
    assert around[4:] == (False, -40.0, 2.0, 0.0)
    assert (timed.x, timed.y) == (around.x, around.y)  # where none is given it is the place before
    assert timed[5:] == (0.0, 0.0, 60.0)
    assert learn == Manoeuvre(
        ManoeuvreKind.PRBS, 60.0, math.radians(15.0), 0.0, clock=2.5, register=33, speed=learn.speed
    )
    assert jump == Jump(0, 3)  # item 2, which is the second behind the home, is the first step
    assert local[:3] == (100.0, -50.0, 7.0)
    assert end == Surface(rally=True)
    assert [s.u for s in (first, second, around, timed, local)] == [pytest.approx(1.5)] * 5
    assert fields(planner.download())[1:] == fields(items)[1:]


def test_the_mission_in_the_order_is_made_already_and_is_what_the_document_says() -> None:
    vehicle = LinkedVehicle()
    Planner(vehicle).upload(everything_that_can_be_flown())
    vehicle.step()
    (change,) = [change for order in vehicle.orders for change in order.changes]
    assert isinstance(change, MissionChange)
    assert decode(encode(change)) == change
    assert mission_from_plain(mission_to_plain(change.mission)).waypoints == change.mission.waypoints


@pytest.mark.parametrize(
    ("items", "to"),
    [
        ([item(SPEED, 1, 1.5, frame=IN_MISSION), item(), item(), item(north=100), item(DO_JUMP, 4, 3)], 2),
        ([item(LAND, north=50), item(LAND, north=90), item(north=100), item(DO_JUMP, 3, 1)], 4),
        ([item(), item(), item(DO_JUMP, 4, 1), item(SPEED, 1, 1.0, frame=IN_MISSION)], 3),
    ],
    ids=["fewer steps than items", "more steps than items", "to the end"],
)
def test_a_jump_leads_to_the_same_step_at_every_start_from_what_was_kept(items: list, to: int) -> None:
    vehicle = LinkedVehicle()
    assert Planner(vehicle).upload(home(*items)) == ACCEPTED
    vehicle.step()
    sent = ordered(vehicle)
    assert next(step.to for step in sent.items if isinstance(step, Jump)) == to
    kept = read_plan(MISSION, dict(vehicle.node.files_to_save())["mission.json"].decode(), SEA)
    assert [kept.finish()[1].mission for _ in range(3)] == [sent] * 3


def test_a_generic_station_has_no_home_and_finds_the_same_mission() -> None:
    vehicle = LinkedVehicle(links=2)
    planner = Planner(vehicle)
    vehicle.node = node(identities=(Identity.ARDUSUB, Identity.GENERIC))
    items = everything_that_can_be_flown()
    assert planner.upload(items) == ACCEPTED
    other = Planner(vehicle, 1).download()
    assert len(other) == len(items) - 1
    assert [m.command for m in other] == [m.command for m in items[1:]]
    assert next(m.param1 for m in other if m.command == DO_JUMP) == 1.0
    assert Planner(vehicle, 1).upload(other) == ACCEPTED
    assert fields(planner.download())[1:] == fields(items)[1:]


def test_too_many_items_are_refused_before_the_first() -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    planner.send(mavlink.MAVLink_mission_count_message(1, 1, 2502, MISSION))
    (ack,) = [m for m in planner.step() if m.get_type() == "MISSION_ACK"]
    assert ack.type == mavlink.MAV_MISSION_NO_SPACE


def test_while_one_station_sends_another_is_refused_and_the_first_goes_on() -> None:
    vehicle = LinkedVehicle(links=2)
    first, second = Planner(vehicle), Planner(vehicle, 1)
    items = home(item(north=10), item(north=20))
    first.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), MISSION))
    vehicle.step()
    assert second.upload(items) == mavlink.MAV_MISSION_DENIED
    second.send(mavlink.MAVLink_mission_clear_all_message(1, 1, MISSION))
    assert [m.type for m in second.step() if m.get_type() == "MISSION_ACK"] == [mavlink.MAV_MISSION_DENIED]
    assert first.upload(items) == ACCEPTED
    assert second.upload(items) == ACCEPTED


def test_a_request_is_repeated_ever_slower_and_given_up_after_ten_seconds() -> None:
    vehicle = LinkedVehicle(links=2)
    planner = Planner(vehicle)
    planner.send(mavlink.MAVLink_mission_count_message(1, 1, 3, MISSION))
    asked, codes = [], []
    for k in range(1100):
        for m in planner.step():
            asked += [k] * (m.get_type() == "MISSION_REQUEST_INT")
            codes += [(k, m.type)] if m.get_type() == "MISSION_ACK" else []
    gaps = [b - a for a, b in itertools.pairwise(asked)]
    assert gaps[:3] == pytest.approx([25, 50, 100], abs=1)
    assert gaps[3:] == pytest.approx([150] * len(gaps[3:]), abs=1)
    assert codes == [(pytest.approx(1000, abs=2), mavlink.MAV_MISSION_OPERATION_CANCELLED)]
    assert "item 0 did not come" in "".join(planner.texts)
    assert Planner(vehicle, 1).upload(home(item())) == ACCEPTED  # nobody is in the way any more


def test_items_that_come_twice_or_out_of_turn_change_nothing() -> None:
    vehicle = LinkedVehicle()
    planner, items = Planner(vehicle), home(item(north=10), item(north=20), item(north=30))
    planner.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), MISSION))
    planner.step()
    for i in (0, 0, 2, 1, 1, 3, 0, 2, 2, 3, 3):
        planner.send(items[i])
    acks = [m.type for _ in range(5) for m in planner.step() if m.get_type() == "MISSION_ACK"]
    assert acks == [ACCEPTED, ACCEPTED]  # the second for whoever did not hear the first
    assert len(ordered(vehicle).items) == 3
    assert len([order for order in vehicle.orders if order.changes]) == 1


@pytest.mark.parametrize("kind", [MISSION, FENCE, RALLY])
def test_what_is_cleared_is_gone_and_kept_as_gone(kind: int) -> None:
    vehicle = LinkedVehicle()
    planner = Planner(vehicle)
    content = {
        MISSION: [item()],
        FENCE: [item(INCLUDE_CIRCLE, 100, kind=FENCE)],
        RALLY: [item(RALLY_POINT, kind=RALLY)],
    }
    assert planner.upload(home(*content[kind], kind=kind), kind) == ACCEPTED
    assert json.loads(dict(vehicle.node.files_to_save())[FILES[kind]])["items"]
    planner.send(mavlink.MAVLink_mission_clear_all_message(1, 1, mavlink.MAV_MISSION_TYPE_ALL))
    assert [m.type for m in planner.step() if m.get_type() == "MISSION_ACK"] == [ACCEPTED]
    vehicle.step()
    assert planner.download(kind) == [] or kind == -1
    assert vehicle.node.files_to_save() == [(FILES[kind], b'{"items": [\n\n]}\n')]
    assert read_plan(kind, '{"items": [\n\n]}\n', SEA).finish()[0].items == ()


def test_the_identity_of_a_plan_is_that_of_its_content() -> None:
    idents = []
    for north in (10, 20, 10):
        vehicle = LinkedVehicle()
        planner = Planner(vehicle)
        planner.upload(home(item(north=north)))
        raw: list[bytes] = []
        vehicle.incoming[0].append(planner.station.pack(mavlink.MAVLink_mission_request_list_message(1, 1, MISSION)))
        vehicle.node.receive(cycle(vehicle.k).tick, vehicle.incoming)
        vehicle.incoming[0].clear()
        for k in range(3):
            raw.append(vehicle.node.report(cycle(vehicle.k + k))[0])
        frame = next(r[r.index(b"\x2c\x00\x00") - 7 :] for r in raw if b"\x2c\x00\x00" in r)
        idents.append(frame[10 + 5 : 10 + 9])  # opaque_id stands behind the five bytes that the dialect knows
    assert idents[0] == idents[2] != idents[1]
    assert len(idents[0]) == 4


def test_the_mission_that_came_with_the_configuration_can_be_read_and_sent_back() -> None:
    steps = (
        Waypoint(100.0, -20.0, 5.0, 1.5),
        Waypoint(100.0, 80.0, 9.0, 0.0, above=True),
        Manoeuvre(ManoeuvreKind.ZIGZAG, 60.0, math.radians(10.0), 0.0, pitch=math.radians(5.0), speed=1.2),
        Loiter(10.0, 20.0, 6.0, 1.2, False, -50.0, 1.5, 0.0),
        Jump(1, 2),
        Surface(rally=True),
    )
    vehicle = LinkedVehicle(plans={MISSION: plan_of_mission(Mission(steps), SEA)})
    planner = Planner(vehicle)
    assert planner.upload(planner.download()) == ACCEPTED
    vehicle.step()
    for was, now in zip(steps, ordered(vehicle).items, strict=True):
        assert type(was) is type(now)
        if isinstance(was, Manoeuvre):
            names = ("duration", "delta_s", "delta_r", "pitch", "heading", "speed")
            was, now = ([getattr(m, name) for name in names] for m in (was, now))
        assert [*now] == pytest.approx([*was], abs=0.02)
    assert items_of(ordered(vehicle), SEA)[0].command == SPEED


FRAGMENTS = st.one_of(
    st.builds(mavlink.MAVLink_mission_count_message, *[st.just(1)] * 2, st.integers(0, 4), st.integers(0, 3)),
    st.builds(lambda seq, each: (setattr(each, "seq", seq), each)[1], st.integers(0, 4), st.sampled_from([
        item(), item(z=9.0), item(RETURN), item(DO_JUMP, 1, -1), item(INCLUDE_CIRCLE, 50, kind=FENCE),
        item(INCLUDE, 3, kind=FENCE), item(RALLY_POINT, kind=RALLY), item(WAYPOINT, NAN, NAN, NAN, NAN),
    ])),
    st.builds(mavlink.MAVLink_mission_request_int_message, *[st.just(1)] * 2, st.integers(0, 5), st.integers(0, 3)),
    st.builds(mavlink.MAVLink_mission_request_message, *[st.just(1)] * 2, st.integers(0, 5), st.integers(0, 3)),
    st.builds(mavlink.MAVLink_mission_request_list_message, *[st.just(1)] * 2, st.integers(0, 3)),
    st.builds(mavlink.MAVLink_mission_clear_all_message, *[st.just(1)] * 2, st.sampled_from([0, 1, 2, 3, 255])),
    st.builds(mavlink.MAVLink_mission_set_current_message, *[st.just(1)] * 2, st.integers(0, 5)),
    st.builds(mavlink.MAVLink_mission_ack_message, *[st.just(1)] * 2, st.integers(0, 15), st.integers(0, 3)),
)  # fmt: skip


@settings(max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 1), FRAGMENTS, st.integers(0, 2)), max_size=40))
def test_whatever_is_said_in_whatever_order_a_mission_is_whole_or_as_it_was(said) -> None:
    vehicle = LinkedVehicle(
        links=2, configurations=[LinkConfiguration(identity, high_latency=True) for identity in Identity]
    )
    assert Planner(vehicle).upload(home(item(north=10), item(north=20))) == ACCEPTED
    vehicle.step()
    for link, message, ticks in said:
        vehicle.stations[link].send(message)
        vehicle.step(ticks)
    vehicle.step(1100)
    for order in vehicle.orders:
        for change in order.changes:
            if isinstance(change, MissionChange):
                assert len(change.mission.items) <= 4
                assert all(isinstance(s, Waypoint | Jump | Surface) for s in change.mission.items)
            else:
                assert isinstance(change, FenceChange | RallyChange)
    planner = Planner(vehicle)
    for kind in (MISSION, FENCE, RALLY):
        assert planner.upload(planner.download(kind), kind) == ACCEPTED  # what stands is a plan


def test_two_thousand_items_go_up_and_down_where_every_tenth_packet_is_lost() -> None:
    chance = random.Random(1)
    vehicle = LinkedVehicle(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])  # no telemetry
    planner = Planner(vehicle, hears=lambda _: chance.random() > 0.1, sends=lambda _: chance.random() > 0.1)
    items = home(*(item(north=i, east=(i * 37) % 101, z=-1.0 - i % 20) for i in range(2000)))
    assert planner.upload(items) == ACCEPTED
    vehicle.step()
    assert len(ordered(vehicle).items) == 2000
    assert vehicle.k < 30_000  # five minutes of the vehicle's time
    assert fields(planner.download())[1:] == fields(items)[1:]
