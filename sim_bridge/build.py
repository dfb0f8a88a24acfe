"""Build the simulated vehicle from its parameters: plant, instruments, devices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.adapters.io_params import IoParams
from firmware_py.params import ParamError, prefix_errors
from firmware_py.wire.canopen.fin_drive import drives_of
from firmware_py.wire.dronecan.fin_servo import servos_of
from firmware_py.wire.serial import dynamixel_fins
from sim_bridge.bridge import Bridge
from sim_bridge.devices.devices import Devices, DevicesParams, Wiring
from sim_bridge.devices.i2c_line import I2cLine
from sim_bridge.devices.instruments import Instruments, Water
from sim_bridge.devices.line_device import Line, LineDevice
from sim_bridge.devices.lines.table import FIRMWARE, I2C_CHIPS
from sim_bridge.devices.ms5837_sensor import Ms5837Device
from sim_bridge.devices.payload import PayloadDevice
from sim_bridge.faults.channels import SENSORS
from sim_bridge.faults.checks import refuse_absent
from sim_bridge.faults.injector import FaultInjector
from sim_bridge.plant.environment import Environment
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario


def wiring(io: IoParams, truth: Truth) -> Wiring:
    """Return how the devices of a simulated vehicle are wired by an io file.

    Raises:
        ParamError: a servo of no fin, or a fin without one.
    """
    names = [fin.name for fin in truth.fins]
    drives, on_line = drives_of(io.canopen.fins, names), dynamixel_fins.servos_of(io.dynamixel.fins, names)
    servos = () if drives or on_line else servos_of(io.fins, names)
    return Wiring(io.nodes, servos, io.propeller, io.devices, io.canopen, drives, tuple(io.lines), on_line)


def refuse_absent_targets(scenario: Scenario, truth: Truth, wiring: Wiring, *, on_bus: bool) -> None:
    """Refuse what `build_bridge` would refuse of a scenario's faults, without building anything.

    Raises:
        ParamError: a fault of a fin, a sensor or a node that is not there.
    """
    fins, sensors = [fin.name for fin in truth.fins], {*SENSORS, *wiring.spares}
    nodes = {*wiring.nodes.by_name, *(device.name for device in wiring.measuring if device.node)}
    refuse_absent(scenario.injected, fins, sensors, nodes if on_bus else None)


def refuse_unsimulated(lines: Sequence[Device]) -> None:
    """Refuse drivers of whose devices, on lines of their own, there is no simulated one.

    Raises:
        ParamError: which driver, and where its device is to be added.
    """
    for device in lines:
        driver = device.line.driver
        if device.role != "fins" and driver not in FIRMWARE and driver not in I2C_CHIPS:
            raise ParamError(
                f'{device.key}: the plant has no device for driver "{driver}"; add one to '
                "sim_bridge/devices/lines/table.py"
            )


def build_bridge(
    truth: Truth,
    params: DevicesParams,
    wiring: Wiring,
    scenario: Scenario,
    bus: FramePort,
    lines: Sequence[Line | I2cLine],
    seed: int,
    base_hz: int,
    autopilot_id: int,
    second_bus: FramePort | None = None,
) -> Bridge:
    """Return the simulated vehicle at the start of a scenario, on its ends of the buses and of its lines.

    Everything random in it follows from `seed`; `lines` are those of the devices in `wiring.on_lines`, in their order.

    Raises:
        ParamError: an impossible body or battery, or a fault of a fin that does not exist.
    """
    params = params.within(base_hz)
    asked = [device.name for device in wiring.on_lines if device.line.driver in I2C_CHIPS]
    plant, instruments = plant_and_instruments(truth, params, scenario, seed, base_hz, wiring.spares, asked)
    line_of = dict(zip(wiring.on_lines, lines, strict=True))
    on_lines = {
        device.name: _on_line(device, instruments.by_name[device.name], line)
        for device, line in line_of.items()
        if device.role != "fins"
    }
    of_fins = (line for device, line in line_of.items() if device.role == "fins" and not isinstance(line, I2cLine))
    fin_line = next(of_fins, None)
    devices = Devices(params, wiring, instruments, bus, on_lines, base_hz, autopilot_id, second_bus, fin_line)
    for i, one in enumerate(params.payload):
        devices.add_payload(PayloadDevice(one, f"sensors.toml: payload[{i}]", devices.bus, seed, base_hz))
    return Bridge(
        plant, devices, FaultInjector(scenario.injected, plant, devices, instruments.by_name, seed, nodes=devices)
    )


def plant_and_instruments(
    truth: Truth,
    params: DevicesParams,
    scenario: Scenario,
    seed: int,
    base_hz: int,
    spares: Sequence[str] = (),
    asked: Sequence[str] = (),
) -> tuple[Plant, Instruments]:
    """Return the plant in its initial state and its instruments; `params` are `within` the base rate.

    `spares` and `asked` are those of `Instruments`.

    Raises:
        ParamError: an impossible body or battery.
    """
    sea, start = scenario.environment, scenario.start
    environment = Environment(sea, np.random.SeedSequence([seed, *b"environment"]), 1.0 / base_hz)
    with prefix_errors("truth.toml"):
        plant = Plant(truth, environment, 1.0 / base_hz, truth.substeps, start.eta, start.nu, start.n)
    with prefix_errors("sensors.toml"):
        water = Water(truth.hull.rho, sea.surface_pressure, sea.origin)
        instruments = Instruments(params, water, seed, base_hz, spares, asked)
    return plant, instruments


def _on_line(device: Device, sensor: Any, line: Line | I2cLine) -> LineDevice | Ms5837Device:
    """Return the simulated instrument on a line."""
    driver = device.table.driver
    if isinstance(line, I2cLine):
        return Ms5837Device(sensor, line, I2C_CHIPS[driver]())
    return LineDevice(sensor, line, FIRMWARE[driver](), device.mounting)
