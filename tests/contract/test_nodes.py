"""A second node under an id, and a node that says that it does not work: not believed, and told in the frame."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import dronecan
import pytest
from dronecan.transport import Transfer

from firmware_py.adapters.buses.can_bus import NodeIds
from firmware_py.adapters.drivers.dronecan.node_roles import SENDS
from firmware_py.adapters.drivers.dronecan.node_watch import HOLD
from firmware_py.records.sensing import NODES as NODE_NAMES
from firmware_py.records.sensing import SensorFrame, node_bit

from .devices import pressure, solution
from .vehicle import NODES, OWN, Vehicle, frames

DEEP, SURFACE = 2e5, 101_325.0


def status(uptime: int, health: int = 0, mode: int = 0):
    return dronecan.uavcan.protocol.NodeStatus(uptime_sec=uptime, health=health, mode=mode)


def send(vehicle: Vehicle, node_id: int, message, transfer_id: int) -> None:
    for can_id, data in frames(message, node_id, transfer_id % 32):
        vehicle.node(node_id).raw(can_id, data)


@pytest.fixture
def diving():
    """A vehicle whose pressure sensor has been heard for 5 s, 20 times a second."""
    with Vehicle() as vehicle:
        for i in range(100):
            send(vehicle, NODES["pressure"], pressure(DEEP), i)
            assert vehicle.read(5 * i).pressure.ok
        yield SimpleNamespace(vehicle=vehicle, i=100)


@pytest.mark.parametrize("offset", [0, 1, 2, 7, 31])
def test_a_second_speaker_is_named_and_neither_is_believed_until_it_is_gone(diving, offset: int) -> None:
    vehicle, false = diving.vehicle, 0
    bit = node_bit("pressure")
    for i in range(100, 200):
        send(vehicle, NODES["pressure"], pressure(DEEP), i)
        send(vehicle, NODES["pressure"], pressure(SURFACE), i + offset)
        frame = vehicle.read(5 * i)
        false += frame.pressure.ok and frame.pressure.value < DEEP
        if i >= 103:
            assert frame.two_senders == bit
            assert not frame.pressure.ok
    assert false <= 1
    for i in range(200, 200 + 20 * round(HOLD) + 20):
        send(vehicle, NODES["pressure"], pressure(DEEP), i)
        frame = vehicle.read(5 * i)
    assert frame.two_senders == 0
    assert (frame.pressure.ok, frame.pressure.value) == (True, DEEP)


def test_a_sensor_of_which_a_whole_round_of_transfer_ids_was_lost_is_alone_and_believed(diving) -> None:
    send(diving.vehicle, NODES["pressure"], pressure(DEEP - 1.0), 99 + 32)
    frame = diving.vehicle.read(5 * (99 + 32))
    assert frame.two_senders == 0
    assert (frame.pressure.fresh, frame.pressure.ok) == (True, True)


def test_a_sensor_that_restarts_is_believed_again_with_its_second_message(diving) -> None:
    for i in range(10):
        send(diving.vehicle, NODES["pressure"], pressure(DEEP - i), i + 17)
        frame = diving.vehicle.read(500 + 5 * i)
        assert frame.two_senders == 0
        assert frame.pressure.ok
        assert frame.pressure.fresh == (i > 0)


def test_a_speaker_under_our_own_id_is_named() -> None:
    with Vehicle() as vehicle:
        assert vehicle.read(0).two_senders == 0
        send(vehicle, OWN, status(3), 0)
        assert vehicle.read(1).two_senders == node_bit("autopilot")
        assert vehicle.read(round(100 * HOLD) + 1).two_senders == node_bit("autopilot")
        assert vehicle.read(round(100 * HOLD) + 2).two_senders == 0


@pytest.mark.parametrize(("health", "mode", "works"), [(0, 0, True), (2, 0, True), (3, 0, False), (0, 1, False)])
def test_a_node_that_says_it_does_not_work_is_not_believed_until_it_says_it_does(health, mode, works) -> None:
    with Vehicle() as vehicle:
        node = NODES["ahrs"]
        for k, said in enumerate((status(0), status(1, health, mode), status(2))):
            send(vehicle, node, said, k)
            send(vehicle, node, solution(), k)
            frame = vehicle.read(100 * k)
            believed = works or k != 1
            assert frame.ahrs.fresh
            assert frame.ahrs.ok == believed
            assert frame.unhealthy == (0 if believed else node_bit("ahrs"))


def test_the_battery_node_has_two_sensors_and_the_servo_hub_all_fins() -> None:
    with Vehicle() as vehicle:
        for i, role in enumerate(("battery", "servo_hub")):
            send(vehicle, NODES[role], status(0, health=3), i)
        for fin in range(4):
            message = dronecan.uavcan.equipment.actuator.Status(actuator_id=fin, position=0.1, force=math.nan)
            send(vehicle, NODES["servo_hub"], message, fin)
        send(
            vehicle,
            NODES["battery"],
            dronecan.dronecan.sensors.hygrometer.Hygrometer(temperature=20.0, humidity=30.0),
            0,
        )
        frame = vehicle.read(0)
        assert frame.unhealthy == node_bit("battery") | node_bit("servo_hub")
        assert frame.leak.fresh
        assert not frame.leak.ok
        assert not any(fin.ok for fin in frame.fins)


def test_a_restart_is_counted() -> None:
    with Vehicle() as vehicle:
        for k, uptime in enumerate((40, 41, 0, 1)):
            send(vehicle, NODES["ahrs"], status(uptime), k)
            vehicle.read(100 * k)
        assert vehicle.hardware.losses()["ahrs_restarts"] == 1


class Device:
    """A foreign node that says its uptime once a second, and its unique id when it is asked."""

    def __init__(self, vehicle: Vehicle, role: str, unique_id: bytes, answers: bool = True) -> None:
        self.vehicle, self.node, self.role = vehicle, vehicle.node(role), role
        self.unique_id, self.answers = unique_id, answers
        self.begun, self.count, self.asked = 0, 0, 0

    def restart(self, k: int, unique_id: bytes | None = None) -> None:
        self.begun, self.count = k, 0
        self.unique_id = unique_id or self.unique_id

    def live(self, first: int, last: int) -> list[SensorFrame]:
        """The frames of these tenths of a second."""
        found = []
        for k in range(first, last):
            if k % 10 == self.begun % 10:
                send(self.vehicle, NODES[self.role], status((k - self.begun) // 10), self.count)
                self.count += 1
            if self.role == "pressure":
                send(self.vehicle, NODES[self.role], pressure(DEEP), k - self.begun)
            found.append(self.vehicle.read(10 * k))
            self.vehicle.write(10 * k)
            for request in self.node.listen():
                if request.service_not_message and request.dest_node_id == NODES[self.role]:
                    self.asked += 1
                    self.answer(request)
        return found

    def answer(self, request) -> None:
        info = dronecan.uavcan.protocol.GetNodeInfo.Response()
        info.hardware_version.unique_id = list(self.unique_id)
        info.name = "org.example.sensor"
        response = Transfer(
            transfer_id=request.transfer_id,
            source_node_id=NODES[self.role],
            dest_node_id=OWN,
            payload=info,
            service_not_message=True,
        )
        for frame in response.to_frames() if self.answers else ():
            self.node.raw(frame.message_id, bytes(frame.bytes))


ONE, OTHER = bytes(range(16)), bytes(range(1, 17))


def test_a_device_is_asked_once_for_its_unique_id() -> None:
    with Vehicle() as vehicle:
        device = Device(vehicle, "pressure", ONE)
        frame = device.live(0, 200)[-1]
        assert device.asked == 1
        assert (frame.replaced, frame.restarted, frame.pressure.ok) == (0, 0, True)


def test_a_device_that_restarts_is_told_for_a_time_and_believed() -> None:
    with Vehicle() as vehicle:
        device = Device(vehicle, "pressure", ONE)
        device.live(0, 100)
        device.restart(130)
        frames = device.live(130, 230)
        assert device.asked == 2
        assert [frame.restarted for frame in frames].count(node_bit("pressure")) in range(45, 55)
        assert not any(frame.replaced for frame in frames)
        assert frames[-1].pressure.ok


def test_another_device_under_the_id_is_not_believed_until_the_first_one_is_back() -> None:
    bit = node_bit("pressure")
    with Vehicle() as vehicle:
        device = Device(vehicle, "pressure", ONE)
        device.live(0, 100)
        device.restart(130, OTHER)
        frames = device.live(130, 230)
        assert [frame.replaced for frame in frames[12:]] == [bit] * 88
        assert not any(frame.pressure.ok for frame in frames[12:])
        assert not any(frame.restarted for frame in frames)
        device.restart(260, ONE)
        frame = device.live(260, 300)[-1]
        assert (frame.replaced, frame.restarted, frame.pressure.ok) == (0, bit, True)


def test_after_a_silence_another_device_is_asked_though_its_uptime_is_greater() -> None:
    with Vehicle() as vehicle:
        device = Device(vehicle, "pressure", ONE)
        device.live(0, 100)
        device.unique_id = OTHER
        frame = device.live(140, 160)[-1]
        assert (frame.replaced, frame.restarted, frame.pressure.ok) == (node_bit("pressure"), 0, False)
        device.unique_id = ONE
        frame = device.live(200, 220)[-1]
        assert (frame.replaced, frame.restarted, frame.pressure.ok) == (0, 0, True)
        assert device.asked == 3


def test_a_flood_of_requests_does_not_keep_a_device_from_being_asked() -> None:
    with Vehicle() as vehicle:
        tool, device = vehicle.node(126), Device(vehicle, "pressure", ONE)
        for k in range(20):
            tool.send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=OWN)
            tool.send(dronecan.uavcan.protocol.GetNodeInfo.Request(), to=OWN)
            device.live(k, k + 1)
        assert device.asked == 1


def test_a_device_that_never_answers_is_asked_three_times_and_counts_as_restarted() -> None:
    with Vehicle() as vehicle:
        device = Device(vehicle, "pressure", ONE, answers=False)
        assert device.live(0, 100)[-1].restarted == 0
        assert device.asked == 3
        device.restart(130)
        frames = device.live(130, 200)
        assert device.asked == 6
        assert any(frame.restarted for frame in frames)
        assert frames[-1].pressure.ok


def test_answers_that_nobody_asked_for_change_nothing() -> None:
    with Vehicle() as vehicle:
        device = Device(vehicle, "pressure", ONE)
        device.live(0, 100)
        device.unique_id = OTHER
        for i in range(40):
            device.answer(SimpleNamespace(transfer_id=i % 32))
        frame = device.live(100, 110)[-1]
        assert (frame.replaced, frame.pressure.ok) == (0, True)


def test_every_node_of_the_io_file_has_a_bit() -> None:
    assert set(NODE_NAMES) == {"autopilot", *(field.name for field in dataclasses.fields(NodeIds))}


def test_no_two_roles_of_a_node_send_one_type_of_message() -> None:
    assert {"autopilot", *SENDS} == set(NODE_NAMES)
    kinds = [kind for several in SENDS.values() for kind in several]
    assert len({*kinds}) == len(kinds)
