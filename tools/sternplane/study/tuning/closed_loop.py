"""A flight flown again with other gains, and with the references and the estimation errors of the first one.

Plant, laws, allocation and gate are those of a whole flight. What is left out is what gains hardly change: the bus, the
sensors and the estimators. Their errors (estimate minus truth) are those of the flight that was recorded, tick by tick.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from firmware_py import config_files
from firmware_py.control.control import Control, ControlParams
from firmware_py.marine import Eta, Nu, wrap
from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import StateEstimate
from firmware_py.safety.gate import GateMemory
from sim_bridge.build import plant_and_instruments
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.truth_sample import TruthSample
from sternplane.logs.tracking import Array
from sternplane.sitl.flight import Flight


class AxisFigures(NamedTuple):
    """How one axis was flown: RMS of its true error, m or deg, and travel of its fins, deg/s."""

    rms: float
    travel: float


class Recording:
    """A witness that keeps what `ClosedLoop` needs."""

    done = False

    def __init__(self) -> None:
        self.cycles: list[Cycle] = []
        self.truths: list[TruthSample] = []

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle and the truth at its tick."""
        self.cycles.append(cycle)
        self.truths.append(truth)


class ClosedLoop:
    """Flies a recorded flight again.

    Args:
        flight: what `sitl.flight.prepare` made; only its configuration and its gate are used.
        recording: of that flight.
        begin: from when on the errors count, s.

    Attributes:
        shipped: the parameters of the flight's laws.
    """

    def __init__(self, flight: Flight, recording: Recording, begin: float) -> None:
        self._flight, self._begin = flight, begin
        self.shipped = flight.params.control
        self._vehicle = config_files.vehicle(flight.configuration)
        self._devices = flight.devices.within(flight.rate)
        self._gate = flight.autopilot.parts.gate
        shares = self._vehicle.effectiveness
        self._stern, self._rudder = ([i for i, s in enumerate(one) if s] for one in (shares.s, shares.r))
        self._ticks = [
            (cycle, _off(cycle.state, truth)) for cycle, truth in zip(recording.cycles, recording.truths, strict=True)
        ]
        self._flown = [(cycle, truth.eta) for cycle, truth in zip(recording.cycles, recording.truths, strict=True)]

    def fly(self, params: ControlParams) -> tuple[AxisFigures, AxisFigures]:
        """Return the figures of depth and heading under these laws; infinite if the plant ends the flight."""
        flight, gate, request = self._flight, self._gate, self._flight.request
        gate.thaw(GateMemory(0, -math.inf))
        plant, _ = plant_and_instruments(flight.truth, self._devices, flight.scenario, request.seed, flight.rate)
        control, allocator = Control(params, self._vehicle), flight.autopilot.allocator
        applied = Applied(fins=(0.0,) * allocator.size, n=0.0, armed=False, limited=False)
        rows: list[tuple[float, ...]] = []
        try:
            for k, (cycle, (eta_off, nu_off)) in enumerate(self._ticks):
                if k:
                    plant.step(applied.fins, applied.n)
                eta, nu = plant.eta, plant.nu
                state = dataclasses.replace(
                    cycle.state,
                    eta=Eta(*[a + b for a, b in zip(eta, eta_off, strict=True)]),
                    nu=Nu(*[a + b for a, b in zip(nu, nu_off, strict=True)]),
                )
                demand = control.update(cycle.tick, cycle.mode, cycle.order, cycle.reference, state)
                applied = gate.limit(cycle.tick, cycle.mode, cycle.frame, allocator.allocate(demand), applied)
                rows.append((cycle.tick.t, *true_errors(eta, cycle), *applied.fins))
        except PlantError:
            return AxisFigures(math.inf, math.inf), AxisFigures(math.inf, math.inf)
        return self._figures(np.array(rows))

    def recorded(self) -> tuple[AxisFigures, AxisFigures]:
        """Return the figures of the recorded flight itself."""
        rows = [(cycle.tick.t, *true_errors(eta, cycle), *cycle.applied.fins) for cycle, eta in self._flown]
        return self._figures(np.array(rows))

    def _figures(self, rows: Array) -> tuple[AxisFigures, AxisFigures]:
        late = rows[rows[:, 0] >= self._begin]
        travel = np.degrees(np.abs(np.diff(late[:, 3:], axis=0)).mean(axis=0)) * self._flight.rate
        return (
            AxisFigures(float(np.sqrt(np.mean(late[:, 1] ** 2))), float(travel[self._stern].mean())),
            AxisFigures(math.degrees(float(np.std(late[:, 2]))), float(travel[self._rudder].mean())),
        )


def true_errors(eta: Eta, cycle: Cycle) -> tuple[float, float]:
    """Return true depth minus reference, m, and true heading minus reference, rad."""
    return eta.z - cycle.reference.z_d, wrap(eta.psi - cycle.reference.psi_d)


def _off(state: StateEstimate, truth: TruthSample) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return estimate minus truth: position and angles, velocities and rates."""
    eta, true = state.eta, truth.eta
    places = [a - b for a, b in zip(eta[:3], true[:3], strict=True)]
    angles = [wrap(a - b) for a, b in zip(eta[3:], true[3:], strict=True)]
    return (*places, *angles), tuple(a - b for a, b in zip(state.nu, truth.nu, strict=True))
