"""Every instrument that an io file can name, named in one, fitted, and heard in the frame of the vehicle."""

from __future__ import annotations

import os
import socket
import sys
import time
from types import SimpleNamespace
from typing import Any

import pytest

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.device_hardware import DeviceHardware
from firmware_py.adapters.drivers.instrument_table import I2C_SENSORS, INSTRUMENTS
from firmware_py.adapters.fitting import at_desk, fitted, open_line, places_of
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError, load
from firmware_py.records.sensing import Dvl, Heard
from firmware_py.tick import Tick
from sim_bridge.devices.serial_line import SerialLine

from .instruments import waterlink
from .test_bar30 import Sensor
from .test_drivers import DEVICES
from .vehicle import DT_NS, FIN_LIST, NODES, OWN

LATENCY_S = 0.125
PATIENCE_S = 10.0


def fit(**instrument: object) -> DeviceHardware:
    """The hardware of an io file with this instrument, which is believed after a device of [nodes]."""
    io = load(IoParams, {"can": {"node_id": OWN}, "nodes": NODES, "instruments": [instrument | {"priority": 2}]}, "io")
    lines = [open_line(device, place) for device, place in zip(io.lines, places_of(io, "virtual"), strict=True)]
    return fitted(io, FIN_LIST, open_bus("virtual", f"fitting-{instrument['port']}"), lines)


def heard(hardware: DeviceHardware, role: str, k: int = 100) -> Heard[Any]:
    """What the frame has of the instrument, when something of it has come."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        frame = hardware.read(Tick(k, DT_NS))
        one, *_ = (*getattr(frame, f"spare_{role}"), getattr(frame, role))
        if one.fresh:
            return one
    raise AssertionError(f"nothing was heard of {role}")


def check(hardware: DeviceHardware, name: str) -> None:
    device = DEVICES[name]
    one, truth = heard(hardware, device.instrument.role), device.truths[0]
    near = max(device.tolerance) if isinstance(device.tolerance, tuple) else device.tolerance
    assert one.value == pytest.approx(truth, abs=near, nan_ok=True)
    assert one.ok
    assert one.t_valid == pytest.approx(1.0 - LATENCY_S - device.delay(truth), abs=1e-4)


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_every_instrument_on_a_serial_line_is_fitted_by_its_name(name):
    with SerialLine() as line:
        hardware = fit(driver=name, port=line.path, latency_s=LATENCY_S)
        line.send(DEVICES[name].encode(DEVICES[name].truths[0], 1.0))
        check(hardware, name)
        hardware.close()


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_every_instrument_behind_a_tcp_port_is_fitted_by_its_name(name):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        hardware = fit(driver=name, port=f"tcp:127.0.0.1:{listener.getsockname()[1]}", latency_s=LATENCY_S)
        with listener.accept()[0] as peer:
            peer.sendall(DEVICES[name].encode(DEVICES[name].truths[0], 1.0))
            check(hardware, name)
        hardware.close()


@pytest.mark.parametrize("name", I2C_SENSORS)
def test_every_sensor_on_an_i2c_bus_is_fitted_by_its_name(name, monkeypatch):
    sensor = Sensor()
    monkeypatch.setitem(sys.modules, "smbus2", SimpleNamespace(SMBus=lambda number: {1: sensor}[number]))
    with open(os.devnull) as line:
        sensor.fd = line.fileno()
        hardware = fit(driver=name, port="i2c:1")
    for k in range(100, 120):
        sensor.t = k / 100
        frame = hardware.read(Tick(k, DT_NS))
    assert frame.spare_pressure[0].value == pytest.approx(sensor.pressure, abs=30.0)
    assert "pressure_2_breaks" in hardware.losses()
    hardware.close()


@pytest.mark.parametrize(
    "table",
    [
        {"dynamixel": {"port": "/dev/x", "fins": [{"id": i} for i in range(4)]}},
        {"canopen": {"fins": [{"node": 11 + i, "counts_per_turn": 4096.0} for i in range(4)]}},
    ],
)
def test_drives_that_turn_fins_slower_than_they_are_commanded_are_refused(table):
    [(protocol, entry)] = table.items()
    named = [one | {"name": fin.name, "speed_deg_s": 1.0} for one, fin in zip(entry["fins"], FIN_LIST, strict=True)]
    io = load(IoParams, {"can": {"node_id": OWN}, "nodes": NODES, protocol: entry | {"fins": named}}, "io")
    with pytest.raises(ParamError, match=rf"{protocol}.fins: stern_port: speed_deg_s = 1: must be at least"):
        fitted(io, FIN_LIST, open_bus("virtual", f"slow-{protocol}"), [None for _ in io.lines])


def test_what_is_mounted_at_an_angle_is_turned():
    with SerialLine() as line:
        hardware = fit(driver="waterlink", port=line.path, mounting={"yaw_deg": 90.0})
        line.send(waterlink.DEVICE.encode(Dvl(1.0, 0.5, 0.25, 0.01, 9.0), 1.0))
        assert heard(hardware, "dvl").value[:3] == pytest.approx((-0.5, 1.0, 0.25))
        hardware.close()


@pytest.mark.parametrize(
    ("instrument", "words"),
    [
        (
            {"driver": "bar30", "port": "/dev/ttyUSB0"},
            "port = '/dev/ttyUSB0': of driver \"bar30\" it must be i2c:N for",
        ),
        ({"driver": "ping", "port": "i2c:1"}, "port = 'i2c:1': of driver \"ping\" it must be a serial device or tcp:"),
        ({"driver": "ping", "port": "x", "mounting": {"roll_deg": 180.0}}, "mounting: of altitude it changes nothing"),
        ({"driver": "dronecan", "node": 33, "role": "fix", "mounting": {"yaw_deg": 9.0}}, "mounting: of fix it chan"),
        ({"driver": "xsens", "port": "x", "mounting": {"yaw_deg": 200.0}}, "mounting: yaw_deg = 200.0: out of"),
    ],
)
def test_what_cannot_be_fitted_is_said_in_one_line(instrument, words):
    with pytest.raises(ParamError) as caught:
        fit(**{"port": "", **instrument})
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_at_a_desk_no_two_devices_are_in_one_place(tmp_path):
    lines = [{"driver": "waterlink", "port": "/dev/a/x"}, {"driver": "ping", "port": "/dev/b/x", "priority": 2}]
    io = load(IoParams, {"can": {"node_id": 10}, "nodes": NODES, "instruments": lines}, "a test")
    with pytest.raises(ParamError, match=r"/dev/a/x and /dev/b/x would both be .*x at a desk; rename one"):
        at_desk(io, tmp_path)


def test_two_devices_on_one_port_are_refused():
    lines = [{"driver": "bar30", "port": "i2c:1", "priority": p} for p in (2, 3)]
    with pytest.raises(ParamError, match=r"instruments\[1\]: port 'i2c:1' is that of instruments\[0\] already"):
        load(IoParams, {"can": {"node_id": 10}, "nodes": NODES, "instruments": lines}, "a test")
