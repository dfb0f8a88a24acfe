"""Node ids given to nodes that ask as DroneCAN's rules say, in pydronecan's bytes, and beside its own allocator."""

from __future__ import annotations

import json
import random
import time
from dataclasses import replace
from types import SimpleNamespace

import dronecan
import pytest
from dronecan.app.dynamic_node_id import CentralizedServer
from dronecan.transport import Transfer
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.adapters.drivers.dronecan.own_node import LISTENED, KeptNodeIds

from .vehicle import DISARMED, NODES, OWN, Vehicle

Allocation = dronecan.uavcan.protocol.dynamic_node_id.Allocation
ON = {"network": {"allocate": True}}
READY = round(100 * LISTENED)
ONE, OTHER = bytes(range(16)), bytes(range(100, 116))
PLANT = 125


def is_allocation(transfer: Transfer) -> bool:
    kind = dronecan.TYPENAMES["uavcan.protocol.dynamic_node_id.Allocation"]
    return dronecan.get_dronecan_data_type(transfer.payload) == kind


class Allocatee:
    """A node that wants an id: rules A to E of the message's definition, with its own random times."""

    def __init__(self, vehicle: Vehicle, unique_id: bytes, preferred: int = 0, seed: int = 1) -> None:
        self._vehicle, self._unique_id, self._preferred = vehicle, unique_id, preferred
        self._random = random.Random(seed)
        self._offset, self._due = 0, self._request_time(0.0)
        self.node_id = 0
        self._count = 0
        self.overheard = lambda _transfer, _t: None
        """Called with each request."""

    def _request_time(self, t: float) -> float:
        return t + self._random.uniform(0.6, 1.0)

    def hear(self, transfer: Transfer, t: float) -> None:
        if self.node_id or not is_allocation(transfer):
            return
        self._offset, self._due = 0, self._request_time(t)  # rule C
        found = transfer.payload.unique_id.to_bytes()
        if not transfer.source_node_id or not self._unique_id.startswith(found):
            return
        if len(found) < 16:  # rule D
            self._offset, self._due = len(found), t + self._random.uniform(0.0, 0.4)
        elif transfer.payload.node_id:  # rule E
            self.node_id = transfer.payload.node_id

    def live(self, t: float) -> None:
        if self.node_id or t < self._due:
            return
        part = self._unique_id[self._offset : self._offset + 6]
        message = Allocation(node_id=self._preferred, first_part_of_unique_id=self._offset == 0)
        message.unique_id.from_bytes(part)
        transfer = Transfer(
            transfer_id=self._count % 32,
            source_node_id=0,
            payload=message,
            transfer_priority=30,
            discriminator=self._random.randrange(1 << 14),
        )
        self._count += 1
        [frame] = transfer.to_frames()
        self._vehicle.node(1).raw(frame.message_id, bytes(frame.bytes))
        self._offset, self._due = 0, self._request_time(t)
        self.overheard(SimpleNamespace(source_node_id=0, payload=message, ts_monotonic=t), t)


class Network:
    """A vehicle, and what else is on its bus; time goes by in ticks."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle, self.k, self.applied = vehicle, 0, DISARMED
        self.asking: list[Allocatee] = []
        self.present: dict[int, bytes] = {}
        """Nodes that live, and their unique ids."""
        self.spoken: list[Transfer] = []
        self.hearing = []

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            t = self.k / 100
            if self.k % 100 == 5:
                for node_id in self.present:
                    status = dronecan.uavcan.protocol.NodeStatus(uptime_sec=self.k // 100)
                    self.vehicle.node(node_id).send(status)
            for one in self.asking:
                one.live(t)
            self.vehicle.read(self.k)
            self.vehicle.write(self.k, self.applied)
            for transfer in self.vehicle.said():
                self._pass_on(transfer, t)
            self.k += 1

    def _pass_on(self, transfer: Transfer, t: float) -> None:
        if transfer.service_not_message:
            if transfer.dest_node_id in self.present and transfer.request_not_response:
                self._answer(transfer)
            return
        if is_allocation(transfer):
            self.spoken.append(transfer)
        for one in (*self.asking, *self.hearing):
            one.hear(transfer, t)

    def _answer(self, request: Transfer) -> None:
        info = dronecan.uavcan.protocol.GetNodeInfo.Response(name="org.example.device")
        info.hardware_version.unique_id = list(self.present[request.dest_node_id])
        answer = Transfer(
            transfer_id=request.transfer_id,
            source_node_id=request.dest_node_id,
            dest_node_id=request.source_node_id,
            payload=info,
            service_not_message=True,
        )
        for frame in answer.to_frames():
            self.vehicle.node(request.dest_node_id).raw(frame.message_id, bytes(frame.bytes))

    def given(self, unique_id: bytes, preferred: int = 0, seconds: int = 8, seed: int = 1) -> int:
        """The id that a new node has after so long; 0 if it has none."""
        one = Allocatee(self.vehicle, unique_id, preferred, seed)
        self.asking.append(one)
        self.run(100 * seconds)
        self.asking.remove(one)
        return one.node_id


def network(vehicle: Vehicle) -> Network:
    """A network that has been listened to for long enough."""
    found = Network(vehicle)
    found.run(READY)
    return found


@pytest.mark.parametrize(("preferred", "granted"), [(0, 124), (73, 73), (NODES["ahrs"], 29), (PLANT, 124), (127, 124)])
def test_a_node_is_given_the_id_it_prefers_or_the_next_free_one(preferred: int, granted: int) -> None:
    with Vehicle("hz_1", **ON) as vehicle:
        assert network(vehicle).given(ONE, preferred) == granted


def test_the_ids_of_the_io_file_and_of_who_is_heard_are_given_to_nobody_else() -> None:
    with Vehicle("hz_1", **ON) as vehicle:
        bus = network(vehicle)
        bus.present = {node_id: bytes((node_id,)) * 16 for node_id in (30, 31, 33)}
        bus.run(500)
        given = [bus.given(bytes((i,)) * 16, 21, seed=i) for i in range(90, 94)]
    assert given == [29, 32, 34, 35]  # 21 to 28 are the io file's
    assert not {OWN, PLANT, *NODES.values()} & set(given)


def test_a_device_of_the_io_file_that_lost_its_id_is_given_it_again_and_no_other_is() -> None:
    """Its unique id was heard under that id before."""
    saved: list[bytes] = []
    with Vehicle("hz_1", kept=KeptNodeIds({}, saved.append), **ON) as vehicle:
        bus = network(vehicle)
        bus.present = {NODES["esc"]: ONE}
        bus.run(500)
        bus.present = {}
        bus.run(400)
    assert json.loads(saved[-1]) == {str(NODES["esc"]): ONE.hex()}
    kept = {bytes.fromhex(text): int(node_id) for node_id, text in json.loads(saved[-1]).items()}
    with Vehicle("hz_1", kept=KeptNodeIds(kept), **ON) as vehicle:
        bus = network(vehicle)
        assert bus.given(OTHER, NODES["esc"]) == 29
        assert bus.given(ONE, 0) == NODES["esc"]


def test_the_id_of_a_node_with_several_roles_is_kept_for_it_as_any_of_the_io_file() -> None:
    roles = NODES | dict.fromkeys(("esc", "pressure", "fix"), NODES["servo_hub"])
    table = {ONE: NODES["servo_hub"]}
    with Vehicle("hz_1", kept=KeptNodeIds(table), nodes=roles, **ON) as vehicle:
        bus = network(vehicle)
        assert bus.given(OTHER, NODES["servo_hub"]) == 22  # that of nobody now
        assert bus.given(ONE) == NODES["servo_hub"]


def test_a_node_has_the_same_id_in_the_next_run() -> None:
    saved: list[bytes] = []
    table: dict[bytes, int] = {}
    for _ in range(2):
        with Vehicle("hz_1", kept=KeptNodeIds(table, saved.append), **ON) as vehicle:
            bus = network(vehicle)
            first, second = bus.given(ONE), bus.given(OTHER)
            assert (first, second) == (124, 123)
    assert len(saved) == 2
    assert json.loads(saved[-1]) == {"124": ONE.hex(), "123": OTHER.hex()}


def test_a_node_that_starts_anew_is_given_its_id_once_it_counts_as_gone() -> None:
    with Vehicle("hz_1", **ON) as vehicle:
        bus = network(vehicle)
        assert bus.given(ONE) == 124
        bus.present = {124: bytes(16)}  # libcanard's example tells no unique id when it is asked
        bus.run(600)
        bus.present = {}
        assert bus.given(ONE, seconds=12) == 124


def test_an_id_under_which_another_device_is_heard_is_not_given_to_its_owner() -> None:
    with Vehicle("hz_1", kept=KeptNodeIds({ONE: 124}), **ON) as vehicle:
        bus = network(vehicle)
        bus.present = {124: OTHER}
        bus.run(300)
        assert bus.given(ONE) == 123


def test_the_ids_of_tools_are_not_kept_and_our_own_are_given_to_nobody_who_had_them() -> None:
    """The io file gave the autopilot the id of a device."""
    saved: list[bytes] = []
    with Vehicle("hz_1", kept=KeptNodeIds({ONE: OWN, OTHER: PLANT}, saved.append), **ON) as vehicle:
        bus = network(vehicle)
        bus.present = {126: bytes((1,)) * 16, 127: bytes((2,)) * 16}
        bus.run(500)
        assert [bus.given(ONE), bus.given(OTHER)] == [124, 123]
    assert set(json.loads(saved[-1])) == {"123", "124"}


@pytest.mark.parametrize("seed", range(6))
def test_nodes_that_ask_at_once_are_all_given_ids_of_their_own(seed: int) -> None:
    with Vehicle("hz_1", **ON) as vehicle:
        bus = network(vehicle)
        bus.asking = [Allocatee(vehicle, bytes((i,)) + ONE[1:], 0, 10 * seed + i) for i in range(4)]
        bus.run(3000)
        assert sorted(one.node_id for one in bus.asking) == [121, 122, 123, 124]


def test_no_id_is_given_while_armed_nor_before_all_are_known_nor_unless_it_is_asked_for() -> None:
    with Vehicle("hz_1", **ON) as vehicle:
        bus = network(vehicle)
        bus.applied = replace(DISARMED, armed=True)
        assert bus.given(ONE) == 0
        assert not bus.spoken
        bus.applied = DISARMED
        assert bus.given(ONE) == 124
    with Vehicle("hz_1", **ON) as vehicle:
        bus = Network(vehicle)
        bus.given(ONE, seconds=2)
        assert not bus.spoken
    with Vehicle("hz_1") as vehicle:
        bus = network(vehicle)
        assert bus.given(ONE) == 0
        assert not bus.spoken


def unique(i: int) -> bytes:
    return bytes((i, 7)) * 8


def test_a_bus_on_which_every_id_is_heard_has_none_left() -> None:
    with Vehicle("hz_1", **ON) as vehicle:
        bus = Network(vehicle)
        bus.present = {i: unique(i) for i in range(1, 126) if i not in (OWN, PLANT)}
        bus.run(READY + 300)
        assert bus.given(ONE) == 0


def test_who_asks_hundreds_of_times_and_never_comes_keeps_nobody_out_for_good() -> None:
    table: dict[bytes, int] = {unique(i): i for i in range(1, 126) if i not in (60, 61, 124)}
    with Vehicle("hz_1", kept=KeptNodeIds(table), **ON) as vehicle:
        bus = network(vehicle)
        bus.present = {100: unique(100)}
        bus.run(300)
        first = bus.given(ONE)
        bus.present[first] = ONE
        bus.run(300)
        assert {bus.given(unique(200 + i)) for i in range(2)} == {60, 61}
        bogus = next(owner for owner, i in table.items() if i == 61)
        assert (first, bus.given(OTHER)) == (124, 61)  # the oldest of this run that nobody has come under
        bus.present[61] = OTHER
        bus.run(300)
        assert bogus not in table
        assert [bus.given(unique(210 + i), seconds=6) for i in range(3)] == [60, 60, 60]
        assert (table[ONE], table[OTHER], table[unique(100)]) == (first, 61, 100)


def test_what_a_storm_has_left_in_the_file_is_taken_back_in_the_next_run_but_no_id_of_the_io_file() -> None:
    table = {unique(i): i for i in range(125, 0, -1)}
    with Vehicle("hz_1", kept=KeptNodeIds(table), **ON) as vehicle:
        bus = network(vehicle)
        bus.present = {124: unique(124), 123: bytes(16)}
        bus.run(300)
        assert bus.given(ONE) == 122
        assert (table[unique(124)], table[unique(NODES["ahrs"])]) == (124, NODES["ahrs"])


class ForeignAllocator:
    """pydronecan's CentralizedServer as it is, on a stand-in for its node and for its monitor."""

    def __init__(self, vehicle: Vehicle, node_id: int, client: Allocatee) -> None:
        self._peer, self._client, self._t, self.answers = vehicle.node(node_id), client, 0.0, 0
        handle = SimpleNamespace(remove=lambda: None)
        info = dronecan.uavcan.protocol.GetNodeInfo.Response(name="org.example.allocator")
        self._node = SimpleNamespace(is_anonymous=False, node_id=node_id, node_info=info, broadcast=self._say)
        self._node.add_handler = lambda _, handler: setattr(self, "_handler", handler) or handle
        CentralizedServer(
            self._node,
            SimpleNamespace(
                add_update_handler=lambda _: handle, find_all=lambda _: [], are_all_nodes_discovered=lambda: True
            ),
        )
        client.overheard = self._hear

    def _hear(self, transfer: SimpleNamespace, t: float) -> None:
        self._t = t
        transfer.ts_monotonic = time.monotonic()  # of its own timeout
        self._handler(SimpleNamespace(transfer=transfer, message=transfer.payload, node=self._node))

    def _say(self, message) -> None:
        self.answers += 1
        self._peer.send(message)
        self._client.hear(SimpleNamespace(source_node_id=self._node.node_id, payload=message), self._t)


def test_beside_another_allocator_it_is_silent_from_the_first_request_on_and_says_so() -> None:
    said = []
    with Vehicle("hz_1", **ON) as vehicle:
        bus = network(vehicle)
        one = Allocatee(vehicle, ONE, 60)
        foreign = ForeignAllocator(vehicle, 5, one)
        bus.asking, bus.hearing = [one], [SimpleNamespace(hear=lambda transfer, _: said.append(transfer.payload))]
        bus.run(1000)
        assert one.node_id == 60
        assert foreign.answers == 3
        assert not bus.spoken
        assert [str(p.text) for p in said if hasattr(p, "text")] == ["node 5 gives out node ids; this node does not"]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from((0x100, 0x1E000100, 0x00FFFF00 & ~0xFF, 0x100 | 5)), st.binary(max_size=8)),
        max_size=40,
    )
)
def test_no_requests_make_it_fail_or_give_an_id_that_is_taken(traffic: list[tuple[int, bytes]]) -> None:
    saved: list[bytes] = []
    with Vehicle("hz_1", kept=KeptNodeIds({}, saved.append), **ON) as vehicle:
        for can_id, data in traffic:
            vehicle.node(1).raw(can_id, data)
        for k in range(READY, READY + 10):
            vehicle.read(k)
            vehicle.write(k)
        given = {int(node_id) for content in saved for node_id in json.loads(content)}
        assert not given & {OWN, PLANT, 126, 127, *NODES.values()}
