"""Foreign, malformed, lost, interleaved, out-of-order and too many frames: nothing false is heard, nothing fails."""

from __future__ import annotations

import dataclasses

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.adapters.drivers.dronecan.devices import FRAMES_PER_TICK
from firmware_py.records.sensing import Heard

from .devices import GOOD, NOTHING, fields, fin, pressure, solution
from .vehicle import DT_NS, FINS, LATENCY, NODES, OWN, Vehicle, frames


@pytest.mark.parametrize(("role", "message", "field", "value"), GOOD.values(), ids=GOOD)
def test_a_message_is_believed_from_the_node_of_its_role_alone(role, message, field, value):
    with Vehicle() as vehicle:
        for other in {*NODES.values(), 1, 11, 127} - {NODES[role]}:
            for can_id, data in frames(message(), other):
                vehicle.others.send(can.Message(arbitration_id=can_id, data=data))
        assert fields(vehicle.read(0)) == NOTHING


@pytest.mark.parametrize(("role", "message", "field", "value"), GOOD.values(), ids=GOOD)
def test_a_payload_cut_short_is_counted_and_ignored(role, message, field, value):
    with Vehicle() as vehicle:
        for can_id, data in frames(message(), NODES[role], cut=3):
            vehicle.node(role).raw(can_id, data)
        assert fields(vehicle.read(0)) == NOTHING
        assert vehicle.hardware.losses()["transfers_malformed"] == 1
        for can_id, data in frames(message(), NODES[role], transfer_id=1):
            vehicle.node(role).raw(can_id, data)
        assert getattr(vehicle.read(1), field).ok


@pytest.mark.parametrize("cut", range(4))
def test_a_servo_status_cut_short_is_counted_and_ignored(cut):
    with Vehicle() as vehicle:
        for can_id, data in frames(fin(0, 0.25), NODES["servo_hub"], cut=cut):
            vehicle.node("servo_hub").raw(can_id, data)
        assert fields(vehicle.read(0)) == NOTHING
        assert vehicle.hardware.losses()["transfers_malformed"] == 1


@pytest.mark.parametrize(
    "kind",
    [
        {"is_extended_id": False, "arbitration_id": 0x123},
        {"is_remote_frame": True},
        {"is_error_frame": True},
        {"is_fd": True},
    ],
    ids=lambda kind: next(iter(kind)),
)
def test_frames_that_are_not_extended_data_frames_are_passed_over(kind):
    with Vehicle() as vehicle:
        [(can_id, data)] = frames(pressure(2e5), NODES["pressure"])
        vehicle.others.send(can.Message(**({"arbitration_id": can_id, "data": data} | kind)))
        assert fields(vehicle.read(0)) == NOTHING
        vehicle.others.send(can.Message(arbitration_id=can_id, data=data))
        assert vehicle.read(1).pressure.value == 2e5


def test_a_flood_is_bounded_per_tick_and_nothing_behind_it_is_lost():
    with Vehicle() as vehicle:
        for i in range(3 * FRAMES_PER_TICK):
            vehicle.node(50).raw(16 << 24 | 341 << 8 | 50, bytes((0, 0, 0, 0, 0, 0, 0, 0xC0 | i % 32)))
        vehicle.node("pressure").send(pressure(2e5))
        for i in range(FINS):
            vehicle.node("servo_hub").send(fin(i, i / 8))
        for k in range(3):
            assert fields(vehicle.read(k)) == NOTHING
        frame = vehicle.read(3)
        assert frame.pressure.value == 2e5
        assert [heard.value for heard in frame.fins] == [0.0, 0.125, 0.25, 0.375]


def test_a_transfer_that_the_bound_splits_is_put_together_and_is_as_old_as_its_first_frame():
    with Vehicle() as vehicle:
        for _ in range(FRAMES_PER_TICK - 2):
            vehicle.node(50).raw(16 << 24 | 341 << 8 | 50, b"\0" * 7 + b"\xc0")
        vehicle.node("ahrs").send(solution(rates=(0.5, 0.5, 0.5)))
        assert fields(vehicle.read(7)) == NOTHING
        heard = vehicle.read(8).ahrs
        assert (heard.fresh, heard.ok, heard.value.p) == (True, True, 0.5)
        assert heard.t_valid == pytest.approx(0.07 - LATENCY["ahrs"])


def test_no_number_of_others_unfinished_transfers_crowds_out_ours():
    messages = [message() for _, message, *_ in GOOD.values()]
    first, *rest = frames(solution(rates=(0.5, 0.5, 0.5)), NODES["ahrs"])
    with Vehicle() as vehicle:
        vehicle.node("ahrs").raw(*first)
        k = 0
        for source in range(30, 128):
            for message in messages:
                beginning = frames(message, source)
                if len(beginning) > 1:
                    vehicle.node(source).raw(*beginning[0])
            vehicle.read(k := k + 1)
        for frame in rest:
            vehicle.node("ahrs").raw(*frame)
        assert vehicle.read(k + 1).ahrs.value.p == 0.5


def test_interleaved_transfers_of_many_nodes_all_arrive():
    said = [(role, message()) for role, message, *_ in GOOD.values()]
    streams = {role: frames(message, NODES[role]) for role, message in said if role != "battery"}
    streams["another ahrs"] = frames(solution(rates=(9.0, 9.0, 9.0)), 99)
    with Vehicle() as vehicle:
        while any(streams.values()):
            for stream in streams.values():
                if stream:
                    vehicle.node(50).raw(*stream.pop(0))
        frame = vehicle.read(0)
        assert all(heard.ok for heard in (frame.ahrs, frame.pressure, frame.altitude, frame.fix, frame.n))
        assert frame.ahrs.value.p != 9.0


@given(st.data())
@settings(max_examples=60)
def test_lost_repeated_and_swapped_frames_never_make_a_value_that_nobody_sent(data):
    sent = [frames(solution(rates=(i / 4, i / 4, i / 4)), NODES["ahrs"], i) for i in range(1, 7)]
    stream = [frame for transfer in sent for frame in transfer]
    for _ in range(data.draw(st.integers(0, 6))):
        i, j = (data.draw(st.integers(0, len(stream) - 1)) for _ in range(2))
        match data.draw(st.sampled_from(("lose", "repeat", "swap"))):
            case "lose":
                del stream[i]
            case "repeat":
                stream.insert(j, stream[i])
            case "swap":
                stream[i], stream[j] = stream[j], stream[i]
    # A node that counts its transfers anew is believed from the second one on.
    stream += [frame for i in (20, 21) for frame in frames(solution(rates=(2.0, 2.0, 2.0)), NODES["ahrs"], i)]
    with Vehicle() as vehicle:
        for k, frame in enumerate(stream):
            vehicle.node("ahrs").raw(*frame)
            heard = vehicle.read(k).ahrs
            if heard.fresh:
                assert heard.ok
                assert heard.value.p == heard.value.q == heard.value.r
                assert heard.value.p in {0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0}
        assert heard.fresh
        assert heard.value.p == 2.0


KINDS = (1, 4, 341, 1000, 1011, 1028, 1034, 1050, 1063, 1092)
IDS = [16 << 24 | kind << 8 | node for node in (*NODES.values(), OWN, 9, 126) for kind in KINDS]
ANONYMOUS_IDS = [16 << 24 | discriminator << 10 | 1 << 8 for discriminator in (0, 77, 0x3FFF)]
SERVICE_IDS = [
    16 << 24 | service << 16 | request << 15 | OWN << 8 | 0x80 | 40
    for service in (1, 4, 5, 10, 11)
    for request in (0, 1)
]


@given(
    st.lists(
        st.tuples(
            st.one_of(st.sampled_from([*IDS, *ANONYMOUS_IDS, *SERVICE_IDS]), st.integers(0, 2**29 - 1)),
            st.binary(max_size=8),
        ),
        max_size=60,
    )
)
def test_no_traffic_makes_it_fail_or_hear_from_the_future(traffic):
    with Vehicle(network={"allocate": True}) as vehicle:
        for can_id, data in traffic:
            vehicle.node(50).raw(can_id, data)
        for k in (0, 1, 400, 401, 402):
            frame = vehicle.read(k)
            values = [getattr(frame, field.name) for field in dataclasses.fields(frame)]
            everything = [value for value in values if isinstance(value, Heard)]
            assert all(heard.t_valid <= k * DT_NS * 1e-9 for heard in (*everything, *frame.fins))
            vehicle.write(k)


def test_a_bus_that_fails_in_flight_is_silence():
    with Vehicle() as vehicle:
        vehicle.node("pressure").send(pressure(2e5))
        vehicle.read(0)
        vehicle.bus.close()
        for k in (1, 2):
            heard = vehicle.read(k).pressure
            assert (heard.value, heard.fresh) == (2e5, False)
            vehicle.write(k)
        lost = vehicle.hardware.losses()
        assert lost["bus_failed_drains"] == 2
        assert lost["bus_not_sent"] > 0
