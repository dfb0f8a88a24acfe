"""One simulated flight: autopilot and plant in one process, with a CAN bus and a serial line between them."""

from __future__ import annotations

import contextlib
import dataclasses
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py import app, config_files, loop
from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from firmware_py.adapters.fitting import fitted, open_second
from firmware_py.adapters.hil.hil_link import parse_hil_link
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.linux_realtime import apply_while
from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.realtime_schedule import RealTimeSchedule
from firmware_py.autopilot import Autopilot
from firmware_py.ports import Ground, Schedule
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.records.cycle import Cycle
from firmware_py.records.mission_tables import mission_to_plain
from firmware_py.run import over_hil, provenance
from firmware_py.run.interrupt import interruptible
from firmware_py.run.kept_plans import with_kept_plans
from firmware_py.settings import plain_settings
from firmware_py.tick import step_ns
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.bridge import PlantSchedule
from sim_bridge.build import build_bridge, refuse_absent_targets, wiring
from sim_bridge.completion import Completion
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.line_device import line_losses
from sim_bridge.hil_server import refuse_faults
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.plant.truth import Truth, refuse_other_fins
from sim_bridge.scenarios import Scenario
from sim_bridge.scripted_operator import ScriptedOperator
from sternplane.sitl import plausibility
from sternplane.sitl.aboard_faults import AboardFaults
from sternplane.sitl.lines import opened
from sternplane.sitl.own_choices import refuse_missing_parts
from sternplane.sitl.request import CONFIG as CONFIG
from sternplane.sitl.request import SCENARIOS as SCENARIOS
from sternplane.sitl.request import FlightRequest as FlightRequest
from sternplane.sitl.request import (
    digests,
    fitted_nodes,
    parse_settings,
    read_devices,
    read_io,
    read_scenario,
    read_truth,
    scenario_place,
)
from sternplane.sitl.simulation_recorder import NoLog, SimulationRecorder, Witness

NOT_REPRODUCIBLE = "the run is not reproducible"
"""What the reason says of a flight that a busy computer has disturbed: it may be flown again."""
_FLIGHTS = count()
"""Numbers the flights of this process: each has a virtual bus of its own."""
_PATIENCE = {"max": 10.0, "realtime": 0.002}
"""How long a tick waits for a line of the DVL, s. On a busy machine the kernel takes 70 ms, on one that stood still
longer; a clock goes on."""


class Outcome(NamedTuple):
    """How a flight went; `surfaced`: not completed, but a rule brought it safely to the surface."""

    completed: bool
    reason: str
    surfaced: bool = False


@dataclass(frozen=True, slots=True)
class Flight:
    """What a flight needs, read and checked."""

    request: FlightRequest
    scenario: Scenario
    configuration: Mapping[str, Any]
    autopilot: Autopilot
    params: AutopilotParams
    io: IoParams
    truth: Truth
    devices: DevicesParams
    aboard: AboardFaults
    notes: tuple[str, ...] = ()
    """Sentences on the state of an earlier run."""

    @property
    def doubts(self) -> tuple[str, ...]:
        """Return what the files say that does not fit the simulated vehicle and its sea, a sentence each."""
        files = self.configuration["files"]["vehicle"], str(self.request.config / "truth.toml")
        vehicle, sensors = config_files.vehicle(self.configuration), str(self.request.config / "sensors.toml")
        placed = plausibility.misplaced(vehicle, self.devices, files[0], sensors)
        where = scenario_place(self.request)
        course = plausibility.doubtful_course(self.scenario, where, self.params, self.devices, sensors)
        return (*plausibility.doubts(vehicle, self.truth, *files), *placed, *course)

    @property
    def vehicle(self) -> Vehicle:
        """What the autopilot believes of the vehicle."""
        return config_files.vehicle(self.configuration)

    @property
    def rate(self) -> int:
        """Ticks a second."""
        return self.params.rate

    def header(self) -> dict[str, Any]:
        """Return the header of the log."""
        request, description = self.request, self.scenario.description
        return provenance.header(
            request.scenario,
            self.configuration,
            self.autopilot.reconfigurator.own,
            description=description,
            seed=request.seed,
            pace=request.pace,
            link=request.link,
            faults=list(self.scenario.faults),
            vehicle_factors={**self.scenario.vehicle_factors},
            settings=plain_settings(parse_settings(request.settings)),
            digests=digests(request),
            truth=self._built(),
            notes=list(self.notes),
        )

    def _built(self) -> dict[str, Any]:
        """Return the true coefficients, nondimensional, with density, length and fins; faults are not in them.

        Of each fin: name, share of (delta_s, delta_r, delta_b), and effectiveness as built, which is in no coefficient.
        """
        truth = self.truth
        fins = [{"name": one.name, "share": list(one.share), "effectiveness": one.effectiveness} for one in truth.fins]
        drag = {"C_d0": truth.propeller.C_d0, "C_dy": truth.hull.C_dy, "C_dz": truth.hull.C_dz}
        return {
            "coefficients": {**dataclasses.asdict(truth.coefficients), **drag},
            "density": truth.hull.rho,
            "length": truth.hull.L,
            "fins": fins,
        }


def prepare(request: FlightRequest, kept: Mapping[str, Any]) -> Flight:
    """Read and check all that a flight needs; write nothing.

    Args:
        request: what was asked for.
        kept: what the vehicle kept of an earlier run, or nothing.

    Raises:
        ParamError: in one line, which file and key is wrong, and what would be right.
    """
    settings, scenario = parse_settings(request.settings), read_scenario(request)
    if parse_hil_link(request.link):
        refuse_faults(scenario)
        over_hil.refuse_settings(settings)
    config_files.refuse_changed(settings, request.state)
    over, factors = laid_over(request, scenario), scenario.vehicle_factors
    shipped = config_files.read_configuration(request.config, over, factors=factors, settings=settings)
    by_files = config_files.autopilot_params(shipped)
    able = plausibility.abilities(config_files.read_configuration(request.config, over))
    plausibility.refuse_mission(scenario, scenario_place(request), by_files, able)
    configuration = with_kept_plans(
        {
            **config_files.with_kept_changes(shipped, request.state),
            "mission": mission_to_plain(scenario.mission),
            "kept": dict(kept),
        },
        request.state,
    )
    refuse_missing_parts(configuration, over, settings, scenario_place(request))
    io, hil = read_io(request), parse_hil_link(request.link)
    configuration |= {} if hil else fitted_nodes(request, io, config_files.vehicle(configuration).fins)
    autopilot, truth = app.build(configuration), read_truth(request)
    believed = len(autopilot.applied.fins)
    refuse_other_fins(truth, str(request.config / "truth.toml"), believed, configuration["files"]["vehicle"])
    flight = Flight(
        request=request,
        scenario=scenario,
        configuration=configuration,
        autopilot=autopilot,
        params=config_files.autopilot_params(configuration),
        io=io,
        truth=truth,
        devices=read_devices(request, scenario),
        aboard=AboardFaults(scenario.injected, realtime=request.pace == "realtime"),
    )
    files, sensors = configuration["files"], str(request.config / "sensors.toml")
    refuse_absent_targets(scenario, truth, wiring(flight.io, truth), on_bus=not hil)
    if hil:
        plausibility.refuse_payload(flight.devices, sensors)
        plausibility.refuse_other_scale(config_files.vehicle(configuration), flight.devices, files["vehicle"], sensors)
    plausibility.refuse_slow_sensors(by_files, flight.devices, shipped["files"]["autopilot"], sensors)
    return flight


def laid_over(request: FlightRequest, scenario: Scenario) -> Mapping[str, Any]:
    """Return what is laid upon autopilot.toml."""
    over = scenario.autopilot
    return config_files.merge(over, over_hil.OVER_HIL) if parse_hil_link(request.link) else over


def fly(
    flight: Flight,
    log_path: Path | None,
    watch: Callable[[Cycle], None] = lambda _cycle: None,
    command: Callable[[ScriptedOperator], Ground] = lambda operator: operator,
    losses: LossWatch | None = None,
    witness: Witness | None = None,
) -> Outcome:
    """Flies to the end of the scenario, or to the first Ctrl-C, and leaves a log that is closed whatever happens.

    Args:
        flight: what `prepare` made; it is used up.
        log_path: where the log goes; None: there is none, and a witness sees all.
        watch: is shown every cycle.
        command: merges the scenario's operator with other sources of orders.
        losses: counts what is lost, on the way to and from these too.
        witness: is shown every cycle and the truth; the flight ends when it is done.

    Raises:
        BusError: the bus or the line cannot be opened.
        LogError: the log cannot be written.
        ParamError: a device whose rate does not fit the base rate, or a fault that strikes what is not there.
    """
    losses = losses or LossWatch()
    scenario, rate, request, io = flight.scenario, flight.rate, flight.request, flight.io
    with contextlib.ExitStack() as stack:
        wired = wiring(io, flight.truth)
        ends = [opened(stack, device, _PATIENCE[request.pace]) for device in io.lines]
        lines, ports = [plant for plant, _ in ends], [autopilot for _, autopilot in ends]
        channel = f"flight {next(_FLIGHTS)}"
        plant_bus = _bus(stack, flight, channel)
        fins = config_files.vehicle(flight.configuration).fins
        hardware = fitted(io, fins, _bus(stack, flight, channel), ports, open_second(io, request.bus, stack))
        stack.callback(hardware.close)
        losses.add_hardware(hardware.losses, lambda: hardware.received, hardware.note)
        rest = plant_bus, lines, request.seed, rate, io.can.node_id, open_second(io, request.bus, stack)
        bridge = build_bridge(flight.truth, flight.devices, wired, scenario, *rest)
        operator = ScriptedOperator(scenario, lambda: bridge.depth)
        interrupted = stack.enter_context(interruptible())
        lockstep = PlantSchedule(
            bridge,
            step_ns(rate),
            round(scenario.duration * rate),
            stop=lambda: operator.completion.done or bool(interrupted) or (witness is not None and witness.done),
        )
        schedule: Schedule = (
            RealTimeSchedule(step_ns(rate), lockstep.advance, flight.io.realtime.spin_ns)
            if request.pace == "realtime"
            else lockstep
        )
        aboard = flight.aboard
        log = None if log_path is None else stack.enter_context(aboard.log(log_path, flight.header()))
        recorder = SimulationRecorder(log or NoLog(), bridge, aboard, watch, witness, losses)
        began = time.monotonic()
        for refusal in stack.enter_context(apply_while(dataclasses.replace(flight.io.realtime, freeze_garbage=True))):
            print(refusal, file=sys.stderr)
        try:
            loop.run(flight.autopilot, hardware, aboard.heard(command(operator)), recorder, schedule)
            outcome = outcome_of(operator.completion, bool(interrupted))
        except PlantError as error:
            outcome = Outcome(False, str(error))
        late = sum(line.late for line in lines)
        if late and request.pace == "max":
            outcome = Outcome(False, f"{late} messages on lines came late: {NOT_REPRODUCIBLE}")
        if log is None:
            return outcome
        end = {**outcome._asdict(), "judged_by": operator.completion.judged_by}
        babbled = {"bus_babbled": bridge.babbled} if bridge.babbled else {}
        counts = {**losses.totals(), **babbled, **line_losses(wired.on_lines, lines)}
        aboard.close(log, {**end, "wall_s": time.monotonic() - began, "losses": counts})
    return outcome


def outcome_of(completion: Completion, interrupted: bool) -> Outcome:
    """Return the outcome of a flight that ended by itself or by Ctrl-C."""
    if interrupted:
        return Outcome(False, "interrupted")
    if completion.completed:
        return Outcome(True, "completed")
    return Outcome(False, completion.reason, completion.surfaced)


def _bus(stack: contextlib.ExitStack, flight: Flight, channel: str) -> CanBus:
    bus = open_bus(flight.request.bus, channel, standard=flight.io.canopen.shares_bus)
    stack.callback(bus.close)
    return bus
