"""The parts of a simulated boat, put together from what the files say."""

from __future__ import annotations

import numpy as np

from firmware_py.adapters.buses.can_bus import FramePort, NodeIds
from firmware_py.params import prefix_errors
from sim_bridge.bridge import Bridge
from sim_bridge.devices.devices import BoatParams, Devices
from sim_bridge.devices.instruments import Instruments, Water
from sim_bridge.devices.serial_dvl import SerialDvl
from sim_bridge.devices.serial_line import SerialLine
from sim_bridge.plant.environment import Environment
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario


def assemble(
    truth: Truth,
    boat: BoatParams,
    ids: NodeIds,
    scenario: Scenario,
    bus: FramePort,
    dvl_line: SerialLine,
    seed: int,
    base_hz: int,
) -> Bridge:
    """The boat at the start of a scenario, on its end of the bus and of the DVL's line.

    Everything random in it follows from `seed`.

    Raises:
        ParamError: a body or a battery that cannot be, or a fault that strikes what is not there.
    """
    boat = boat.within(base_hz)
    plant, instruments = afloat(truth, boat, scenario, seed, base_hz)
    dvl = SerialDvl(instruments.dvl, dvl_line)
    devices = Devices(boat, ids, instruments, bus, dvl, len(truth.fins), base_hz)
    return Bridge(plant, devices, scenario.faults)


def afloat(truth: Truth, boat: BoatParams, scenario: Scenario, seed: int, base_hz: int) -> tuple[Plant, Instruments]:
    """The plant at the start of a scenario, in its sea, and what it measures with; `boat` is `within` the base rate.

    Raises:
        ParamError: a body or a battery that cannot be.
    """
    sea, start = scenario.environment, scenario.start
    environment = Environment(sea, np.random.SeedSequence([seed, *b"environment"]), 1.0 / base_hz)
    with prefix_errors("truth.toml"):
        plant = Plant(truth, environment, 1.0 / base_hz, truth.substeps, start.eta, start.nu, start.n)
    with prefix_errors("sensors.toml"):
        instruments = Instruments(boat, Water(truth.hull.rho, sea.surface_pressure, sea.origin), seed, base_hz)
    return plant, instruments
