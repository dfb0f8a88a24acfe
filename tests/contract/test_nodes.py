"""A second node under an id, and a node that says that it does not work: not believed, and told in the frame."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import dronecan
import pytest

from firmware_py.adapters.buses.can_bus import NodeIds
from firmware_py.adapters.node_watch import HOLD
from firmware_py.records.sensing import NODES as NODE_NAMES
from firmware_py.records.sensing import node_bit

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


def test_every_node_of_the_io_file_has_a_bit() -> None:
    assert set(NODE_NAMES) == {"autopilot", *(field.name for field in dataclasses.fields(NodeIds))}
