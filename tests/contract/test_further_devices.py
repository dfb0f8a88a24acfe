"""Several devices of a role on the wires: each has its place in the frame, and is watched by itself."""

from __future__ import annotations

import pytest

from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.serial_port import SerialPort
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.records.sensing import candidate_bit
from firmware_py.wire.serial import waterlink_dvl
from sim_bridge.devices.serial_line import SerialLine

from .devices import pressure, solution
from .test_nodes import send, status
from .vehicle import NODES, Vehicle

SPARE = {"ahrs": 33, "pressure": 34}
LATENCY_S = 0.2


@pytest.fixture
def vehicle():
    instruments = [
        {"driver": "dronecan", "node": node, "role": role, "priority": 2, "latency_s": LATENCY_S}
        for role, node in SPARE.items()
    ]
    with Vehicle(instruments=instruments) as vehicle:
        yield vehicle


def test_each_node_has_its_place_and_its_latency(vehicle: Vehicle) -> None:
    send(vehicle, NODES["pressure"], pressure(1.2e5), 0)
    send(vehicle, SPARE["pressure"], pressure(1.3e5), 0)
    send(vehicle, SPARE["ahrs"], solution(rates=(0.5, 0.0, 0.0)), 0)
    frame = vehicle.read(100)
    [second], [ahrs] = frame.spare_pressure, frame.spare_ahrs
    assert (frame.pressure.value, second.value) == (pytest.approx(1.2e5), pytest.approx(1.3e5))
    assert second.t_valid == pytest.approx(1.0 - LATENCY_S)
    assert (ahrs.value.p, frame.ahrs.fresh) == (0.5, False)
    frame = vehicle.read(101)
    assert (frame.pressure.fresh, frame.spare_pressure[0].fresh) == (False, False)
    assert frame.spare_pressure[0].value == second.value


def test_what_a_further_node_says_of_itself_leaves_the_first_alone(vehicle: Vehicle) -> None:
    for role, node in SPARE.items():
        send(vehicle, node, pressure(1.2e5) if role == "pressure" else solution(), 0)
        send(vehicle, NODES[role], pressure(1.2e5) if role == "pressure" else solution(), 0)
    send(vehicle, SPARE["pressure"], status(0, health=3), 0)
    frame = vehicle.read(1)
    assert frame.unhealthy == candidate_bit("pressure", 1)
    assert (frame.pressure.ok, frame.spare_pressure[0].ok, frame.spare_ahrs[0].ok) == (True, False, True)


def test_a_double_of_a_further_node_is_told_of_it(vehicle: Vehicle) -> None:
    for i in range(20):
        for node, value in ((SPARE["pressure"], 1.2e5), (SPARE["pressure"], 1.4e5), (NODES["pressure"], 1.2e5)):
            send(vehicle, node, pressure(value), i if value == 1.2e5 else i + 9)
        frame = vehicle.read(5 * i)
    assert frame.two_senders == candidate_bit("pressure", 1)
    assert (frame.pressure.ok, frame.spare_pressure[0].ok) == (True, False)
    assert vehicle.hardware.losses()["pressure_2_strays"] > 0


def test_a_line_gives_its_readings_the_place_and_the_latency_of_its_device() -> None:
    with SerialLine() as line:
        driver = StreamDriver("dvl_2", INSTRUMENTS["waterlink"], SerialPort("dvl.2", line.path, 115200), 0.1, number=1)
        line.send(
            waterlink_dvl.encode(waterlink_dvl.Velocity(1.0, 0.0, 0.0, True, 9.0, 0.01, (0.0,) * 9, 5, 5, 0.0, 0))
        )
        [reading] = driver.poll(2.0)
        assert (reading.role, reading.number, reading.heard.value.u) == ("dvl", 1, 1.0)
        assert reading.heard.t_valid == pytest.approx(1.9)
        assert "dvl_2_broken" in driver.losses()
        driver.close()
