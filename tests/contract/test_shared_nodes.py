"""One foreign node that is servos, speed controller, pressure sensor and receiver: what happens to it, by roles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import dronecan
import pytest
from dronecan.transport import Transfer

from firmware_py.adapters.drivers.dronecan.node_watch import HOLD
from firmware_py.adapters.fitting import shared_nodes
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import load
from firmware_py.records.event_text import texts
from firmware_py.records.sensing import NodeBits, SensorFrame, candidate_bit, fin_bit, node_bit
from firmware_py.safety.health_events import node_events

from .devices import fin, fix, pressure, propeller, solution
from .vehicle import FIN_LIST, NODES, OWN, Vehicle, frames

ONE = 21
SHARED = NODES | {"esc": ONE, "pressure": ONE, "fix": ONE}
ROLES = ("servo_hub", "esc", "pressure", "fix")
BITS = sum(map(node_bit, ROLES))
DEEP = 2e5
FIRST, OTHER = bytes(range(16)), bytes(range(1, 17))


class Periph:
    """The node: all that it measures ten times a second, its status once, and who it is when it is asked."""

    def __init__(self, vehicle: Vehicle, node_id: int = ONE) -> None:
        self.vehicle, self.node, self.node_id = vehicle, vehicle.node(node_id), node_id
        self.counts: Counter[type] = Counter()
        self.begun = self.asked = 0
        self.unique_id, self.health = FIRST, 0

    def send(self, message: object) -> None:
        kind = dronecan.get_dronecan_data_type(message)
        for can_id, data in frames(message, self.node_id, self.counts[kind] % 32):
            self.node.raw(can_id, data)
        self.counts[kind] += 1

    def live(self, first: int, last: int) -> list[SensorFrame]:
        """The frames of these tenths of a second."""
        found = []
        for k in range(first, last):
            if (k - self.begun) % 10 == 0:
                self.send(dronecan.uavcan.protocol.NodeStatus(uptime_sec=(k - self.begun) // 10, health=self.health))
            for message in (*(fin(i, 0.1) for i in range(4)), propeller(300), pressure(DEEP), fix()):
                self.send(message)
            found.append(self.vehicle.read(10 * k))
            self.vehicle.write(10 * k)
            for request in self.node.listen():
                if request.service_not_message and request.dest_node_id == self.node_id:
                    self.asked += 1
                    self.answer(request)
        return found

    def answer(self, request: Transfer) -> None:
        info = dronecan.uavcan.protocol.GetNodeInfo.Response(name="org.ardupilot.ap_periph")
        info.hardware_version.unique_id = list(self.unique_id)
        response = Transfer(
            transfer_id=request.transfer_id,
            source_node_id=self.node_id,
            dest_node_id=OWN,
            payload=info,
            service_not_message=True,
        )
        for frame in response.to_frames():
            self.node.raw(frame.message_id, bytes(frame.bytes))

    def restart(self, k: int) -> None:
        self.begun = k
        self.counts.clear()


@pytest.fixture
def vehicle() -> Iterator[Vehicle]:
    with Vehicle(nodes=SHARED) as made:
        yield made


def good(frame: SensorFrame) -> list[bool]:
    return [frame.pressure.ok, frame.fix.ok, frame.n.ok, *(one.ok for one in frame.fins)]


def test_every_role_of_the_node_is_heard_and_it_is_asked_once_who_it_is(vehicle: Vehicle) -> None:
    periph = Periph(vehicle)
    frame = periph.live(0, 60)[-1]
    assert (frame.pressure.value, frame.n.value) == (DEEP, 5.0)
    assert [one.value for one in frame.fins] == pytest.approx([0.1] * 4, abs=1e-4)
    assert all(good(frame))
    assert periph.asked == 1
    assert not any(name.startswith("node") for name, count in vehicle.hardware.losses().items() if count)


def test_what_it_says_of_its_health_is_about_all_of_its_roles_and_no_other_node(vehicle: Vehicle) -> None:
    periph = Periph(vehicle)
    periph.live(0, 10)
    periph.health = 3
    for can_id, data in frames(solution(), SHARED["ahrs"]):
        vehicle.node("ahrs").raw(can_id, data)
    frame = periph.live(10, 20)[-1]
    assert frame.unhealthy == BITS
    assert not any(good(frame))
    assert frame.ahrs.ok
    periph.health = 0
    frame = periph.live(20, 30)[-1]
    assert frame.unhealthy == 0
    assert all(good(frame))


def test_a_second_speaker_of_one_type_makes_all_of_the_node_doubtful(vehicle: Vehicle) -> None:
    periph, second = Periph(vehicle), Periph(vehicle)
    periph.live(0, 50)
    for k in range(50, 60):
        second.send(fix(36.0))
        frame = periph.live(k, k + 1)[-1]
    assert frame.two_senders == BITS
    assert not any(good(frame))
    frame = periph.live(60, 60 + round(10 * HOLD) + 10)[-1]
    assert frame.two_senders == 0
    assert all(good(frame))
    counts = vehicle.hardware.losses()
    assert counts["fix_strays"] > 0
    assert not any(counts.get(f"{name}_strays") for name in (f"node{ONE}", "pressure", "esc", "servo_hub"))


def test_its_restart_is_one_for_all_of_its_roles_and_counted_once(vehicle: Vehicle) -> None:
    periph = Periph(vehicle)
    periph.live(0, 60)
    periph.restart(63)
    told = {frame.restarted for frame in periph.live(63, 80)}
    assert told == {0, BITS}
    counts = vehicle.hardware.losses()
    assert {name: count for name, count in counts.items() if "restarts" in name} == {f"node{ONE}_restarts": 1}


def test_another_device_under_its_id_is_another_one_in_all_roles(vehicle: Vehicle) -> None:
    periph = Periph(vehicle)
    periph.live(0, 60)
    periph.restart(63)
    periph.unique_id = OTHER
    frame = periph.live(63, 90)[-1]
    assert (frame.replaced, frame.restarted) == (BITS, 0)
    assert not any(good(frame))


def test_what_is_lost_of_it_counts_by_role_as_far_as_types_tell(vehicle: Vehicle) -> None:
    periph = Periph(vehicle)
    periph.live(0, 20)
    periph.counts[dronecan.uavcan.equipment.air_data.StaticPressure] += 1
    periph.counts[dronecan.uavcan.equipment.esc.Status] += 1
    periph.live(20, 22)
    for can_id, data in frames(fix(), ONE, periph.counts[dronecan.uavcan.equipment.gnss.Fix2] % 32)[:-1]:
        periph.node.raw(can_id, data)
    periph.live(22, 30)
    counts = {name: n for name, n in vehicle.hardware.losses().items() if n and not name.startswith("transfers")}
    assert counts.pop(f"node{ONE}_unfinished", 0) + counts.pop(f"node{ONE}_duplicate", 0) > 0
    assert counts == {"pressure_missed": 1, "esc_missed": 1}


def told(before: NodeBits, now: NodeBits) -> list[str]:
    shared = shared_nodes(
        load(IoParams, {"can": {"node_id": OWN}, "nodes": SHARED, "instruments": DVL}, "io"), FIN_LIST
    )
    return [*texts(node_events(before, now, [one.name for one in FIN_LIST], shared["shared_nodes"]))]


DVL = [{"driver": "waterlink", "port": "/dev/ttyUSB0"}]


def test_an_event_of_the_node_is_one_that_names_all_of_its_roles() -> None:
    listed = "node servo_hub, esc, pressure, fix"
    other = node_bit("battery")
    faulty = NodeBits(unhealthy=BITS | other)
    assert told(NodeBits(), faulty) == [
        f"{listed}: it reports that it does not work",
        "node battery: it reports that it does not work",
    ]
    assert told(faulty, NodeBits(unhealthy=other)) == [f"{listed} is sound again"]
    assert told(NodeBits(), NodeBits(restarted=BITS)) == [f"{listed} has restarted"]


WIRED = [{"name": one.name, "id": i + 1, "node": 31 + i // 2} for i, one in enumerate(FIN_LIST)]
SPLIT = NODES | {"servo_hub": 31, "pressure": 31, "esc": 32}
SPARE = {"driver": "dronecan", "node": 32, "role": "pressure", "priority": 2}


def test_of_two_nodes_with_servos_each_is_about_its_own_fins_and_whatever_else_it_does() -> None:
    with Vehicle(nodes=SPLIT, fins=WIRED, instruments=[SPARE]) as vehicle:
        for node_id in (31, 32):
            for i in range(4):
                for can_id, data in frames(fin(i + 1, 0.1), node_id, i):
                    vehicle.node(node_id).raw(can_id, data)
        assert all(one.ok for one in vehicle.read(0).fins)
        for node_id, ok, bits in (
            (32, [True, True, False, False], fin_bit(2) | fin_bit(3) | node_bit("esc") | candidate_bit("pressure", 1)),
            (31, [False] * 4, fin_bit(0) | fin_bit(1) | node_bit("pressure")),
        ):
            before = vehicle.read(1).unhealthy
            for can_id, data in frames(dronecan.uavcan.protocol.NodeStatus(uptime_sec=1, health=3), node_id):
                vehicle.node(node_id).raw(can_id, data)
            frame = vehicle.read(2)
            assert frame.unhealthy & ~before == bits
            assert [one.ok for one in frame.fins] == ok
