"""One bus for DroneCAN and CANopen: each hears its own ids, all of them, in order, and is bounded; a bus's health."""

from __future__ import annotations

import contextlib
import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.buses.frame_id import STANDARD
from firmware_py.adapters.buses.shared_port import split
from firmware_py.adapters.buses.virtual_bus import VirtualFrameBus
from firmware_py.adapters.lockstep.lockstep_link import LockstepLink
from firmware_py.records.event_text import texts
from firmware_py.records.sensing import NodeBits, SensorFrame, bus_bit
from firmware_py.safety.health_events import node_events
from firmware_py.wire.canopen import cia402, frames
from firmware_py.wire.dronecan.message_table import TICK
from firmware_py.wire.dronecan.node_messages import LockstepTick
from sim_bridge.devices.canopen_drive import Drive

from .devices import pressure
from .vehicle import FIN_LIST, NODES, OWN, Vehicle

DRIVES = (31, 32, 33, 34)
CANOPEN = {
    "fins": [
        {"name": fin.name, "node": node, "counts_per_turn": 4096.0} for fin, node in zip(FIN_LIST, DRIVES, strict=True)
    ]
}
"""[canopen] without a bus: that of [can]."""
_channels = itertools.count()
IDS = st.one_of(st.integers(0, 2**29 - 1), st.integers(0, 0x7FF).map(lambda number: number | STANDARD))


@given(
    st.lists(st.tuples(IDS, st.binary(max_size=8)), max_size=40), st.lists(st.integers(1, 9), min_size=1, max_size=5)
)
def test_each_end_hears_its_own_ids_all_and_in_order_at_most_so_many_at_once(frames, limits):
    channel = f"shared-{next(_channels)}"
    with (
        contextlib.closing(open_bus("virtual", channel)) as far,
        contextlib.closing(open_bus("virtual", channel, standard=True)) as near,
    ):
        far.send(frames)
        ends, heard = split(near), ([], [])
        for limit in itertools.islice(itertools.cycle(limits), 100):
            for end, found in zip(ends, heard, strict=True):
                portion = end.drain(limit)
                assert len(portion) <= limit
                found += portion
        assert heard[0] == [frame for frame in frames if frame[0] < STANDARD]
        assert heard[1] == [frame for frame in frames if frame[0] >= STANDARD]


def test_what_nobody_fetches_is_bounded_and_counted():
    channel = f"shared-{next(_channels)}"
    with (
        contextlib.closing(open_bus("virtual", channel)) as far,
        contextlib.closing(open_bus("virtual", channel, standard=True)) as near,
    ):
        extended, standard = split(near)
        for k in range(50):
            far.send([(k | STANDARD, b"")] * 100)
            assert extended.drain(100) == []
        assert len(standard.drain(10_000)) == 4096
        assert extended.losses()["crowded_out"] == 5000 - 4096
        assert standard.losses() == {}


def test_in_lockstep_frames_with_standard_ids_are_counted_whoever_sent_them():
    channel = f"shared-{next(_channels)}"
    with (
        contextlib.closing(open_bus("virtual", channel, standard=True)) as one,
        contextlib.closing(open_bus("virtual", channel, standard=True)) as other,
    ):
        plant, vehicle = LockstepLink(one, 125, [10]), LockstepLink(other, 10, [21])
        plant.send([(0x18B | STANDARD, b"position"), (341 << 8 | 21, bytes(7) + b"\xc0")])
        plant.send_message(TICK, LockstepTick(0, 0, 2, 1))
        assert vehicle.receive_message(TICK, 1.0).frames == vehicle.frames_received == 2
        assert [can_id for can_id, _ in vehicle.drain(9)] == [0x18B | STANDARD, 341 << 8 | 21]


def with_drives(vehicle: Vehicle, ticks: int) -> SensorFrame:
    """The frame after so many ticks, in which drives on its bus and a pressure sensor have spoken."""
    drives = [Drive(node) for node in DRIVES]
    for k in range(ticks):
        said = [frame for drive in drives for frame in ([drive.boot()] if k == 0 else drive.live(0.01 * k))]
        while (message := vehicle.others.recv(0)) is not None:
            if not message.is_extended_id:
                for drive in drives:
                    said += drive.handle(message.arbitration_id, bytes(message.data), 0.01 * k)
        for can_id, data in said:
            vehicle.node(NODES["pressure"]).raw(can_id, data, extended=False)
        vehicle.node("pressure").send(pressure(1.2e5 + k))
        frame = vehicle.read(k)
        vehicle.write(k)
    return frame


def test_drives_and_dronecan_nodes_on_one_bus_are_each_heard_by_their_own_driver_alone():
    with Vehicle(canopen=CANOPEN) as shared:
        frame = with_drives(shared, 60)
        assert [fin.ok for fin in frame.fins] == [True] * 4
        assert frame.pressure.value == 1.2e5 + 59
        # A standard id that ends as our node id does, and an extended one that is the number of a drive's position.
        node = shared.node("pressure")
        node.raw(0x700 + OWN, b"\5", extended=False)
        position = frames.encode(cia402.feedback(cia402.Feedback(DRIVES[0], 0x27, 1000)))
        node.raw(*position, extended=True)
        frame = shared.read(60)
        assert (frame.two_senders, frame.unhealthy, frame.fins[0].fresh) == (0, 0, False)
        assert {name: n for name, n in shared.hardware.losses().items() if n} == {}
        node.raw(*position, extended=False)
        assert shared.read(61).fins[0].value == pytest.approx(1000 / 4096 * math.tau)


def test_what_is_wrong_with_a_bus_that_both_share_is_counted_once_and_told_once(monkeypatch):
    tried = []
    monkeypatch.setattr(VirtualFrameBus, "errors", {"error_passive": 3})
    monkeypatch.setattr(VirtualFrameBus, "send_frames", lambda _bus, out: tried.extend(out) or len(out))
    with Vehicle(canopen=CANOPEN) as shared:
        monkeypatch.setattr(type(shared.bus), "sound", False)
        assert with_drives(shared, 3).unhealthy == bus_bit("bus")
        counts = {name: n for name, n in shared.hardware.losses().items() if "bus" in name and n}
    assert counts == {"bus_error_passive": 3, "bus_not_sent": len(tried)}
    assert {can_id < STANDARD for can_id, _ in tried} == {True, False}  # of both protocols


def test_a_bus_that_is_down_is_a_health_of_the_frame_and_an_event(monkeypatch):
    with Vehicle() as vehicle:
        assert vehicle.read(0).unhealthy == 0
        monkeypatch.setattr(type(vehicle.bus), "sound", False)
        frame = vehicle.read(1)
        assert frame.unhealthy == bus_bit("bus")
        monkeypatch.undo()
        assert vehicle.read(2).unhealthy == 0
    down = NodeBits(unhealthy=frame.unhealthy)
    assert texts(node_events(NodeBits(), down, ())) == ["bus: it is down, off or error-passive"]
    assert texts(node_events(down, NodeBits(), ())) == ["bus is sound again"]
