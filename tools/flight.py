"""One simulated flight: the autopilot and a boat in one process, a CAN bus and a serial line between them."""

from __future__ import annotations

import contextlib
import gc
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from firmware_py import app, loop
from firmware_py.adapters.can_bus import CanBus, open_bus
from firmware_py.adapters.clock import RealTime
from firmware_py.adapters.dvl import DvlPort
from firmware_py.adapters.files import read_toml
from firmware_py.adapters.hardware import Hardware
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.kernel_cache import ROOT
from firmware_py.adapters.recorder import TRUTH_TOPIC, LogWriter, Recorder
from firmware_py.autopilot import Autopilot
from firmware_py.params import load
from firmware_py.ports import Schedule
from firmware_py.records.cycle import Cycle
from firmware_py.schedule import step_ns
from sim_bridge.assembly import assemble
from sim_bridge.bridge import Bridge, Lockstep
from sim_bridge.devices import BoatParams
from sim_bridge.pilot import ScriptedGround
from sim_bridge.scenarios import Completes, Scenario, load_scenario
from sim_bridge.serial_line import SerialLine
from sim_bridge.truth import Truth
from tools import machine

SCENARIOS = ROOT / "configs" / "scenarios"
CONFIG = ROOT / "configs" / "npsauv2"


@dataclass(frozen=True, slots=True)
class Wish:
    """What a person asked for."""

    scenario: str = "demo"
    config: Path = CONFIG
    bus: str = "virtual"
    pace: str = "max"
    seed: int = 1


class Outcome(NamedTuple):
    """How a flight went."""

    completed: bool
    reason: str


@dataclass(frozen=True, slots=True)
class Flight:
    """Everything that a wish asks to be read, read and checked."""

    wish: Wish
    scenario: Scenario
    configuration: Mapping[str, Any]
    autopilot: Autopilot
    rate: int
    io: IoParams
    truth: Truth
    boat: BoatParams

    def header(self) -> dict[str, Any]:
        """What the log begins with."""
        return {
            "scenario": self.wish.scenario,
            "description": self.scenario.description,
            "seed": self.wish.seed,
            "pace": self.wish.pace,
            "git": machine.git_revision(),
            "machine": machine.fingerprint(),
            "versions": machine.versions(),
            "mission": self.configuration["mission"],
            "configuration": self.configuration,
        }


def prepare(wish: Wish, kept: Mapping[str, float]) -> Flight:
    """Reads and checks all that a flight needs; writes nothing.

    Args:
        wish: what was asked for.
        kept: what the vehicle kept of an earlier run, or nothing.

    Raises:
        ParamError: in one line, which file and key is wrong, and what would be right.
    """
    scenario = load_scenario(wish.scenario, SCENARIOS)
    configuration = {
        **app.read_configuration(wish.config, scenario.autopilot),
        "mission": {"waypoints": [list(waypoint) for waypoint in scenario.mission.waypoints]},
        "kept": dict(kept),
    }
    return Flight(
        wish=wish,
        scenario=scenario,
        configuration=configuration,
        autopilot=app.build(configuration),
        rate=app.autopilot_params(configuration).rate,
        io=_load(IoParams, wish.config / "io_sitl.toml"),
        truth=_load(Truth, wish.config / "truth.toml"),
        boat=_load(BoatParams, wish.config / "sensors.toml", scenario.sensors),
    )


def fly(flight: Flight, log_path: Path, watch: Callable[[Cycle], None] = lambda _cycle: None) -> Outcome:
    """Flies to the end of the scenario, or to the first Ctrl-C, and leaves a log that is closed whatever happens.

    Args:
        flight: what `prepare` made; it is used up.
        log_path: where the log goes.
        watch: is shown every cycle.

    Raises:
        BusError: the bus or the line cannot be opened.
        LogError: the log cannot be written.
        ParamError: a device whose rate does not fit the base rate, or a fault that strikes what is not there.
    """
    scenario, rate, wish = flight.scenario, flight.rate, flight.wish
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(SerialLine())
        boat_bus = _bus(stack, flight)
        hardware = Hardware(
            flight.io, len(flight.autopilot.applied.fins), _bus(stack, flight), DvlPort(flight.io.dvl, line.path)
        )
        stack.callback(hardware.close)
        bridge = assemble(flight.truth, flight.boat, flight.io.nodes, scenario, boat_bus, line, wish.seed, rate)
        pilot = ScriptedGround(scenario)
        interrupted = stack.enter_context(_interruptible())
        lockstep = Lockstep(
            bridge, step_ns(rate), round(scenario.duration * rate), stop=lambda: pilot.done or bool(interrupted)
        )
        schedule: Schedule = RealTime(step_ns(rate), lockstep.advance) if wish.pace == "realtime" else lockstep
        log = stack.enter_context(LogWriter(log_path, flight.header()))
        began = time.monotonic()
        with _no_garbage():
            loop.run(flight.autopilot, hardware, pilot, _Tape(log, bridge, watch), schedule)
        outcome = _judge(scenario, pilot, bool(interrupted))
        log.close({**outcome._asdict(), "wall_s": time.monotonic() - began})
    return outcome


class _Tape:
    """The recorder of a simulated run: the cycle, what was really the case, and whoever watches."""

    def __init__(self, log: LogWriter, bridge: Bridge, watch: Callable[[Cycle], None]) -> None:
        self._recorder = Recorder(log)
        self._log = log
        self._bridge = bridge
        self._watch = watch
        log.channel(TRUTH_TOPIC, bridge.truth())

    def write(self, cycle: Cycle) -> None:
        self._recorder.write(cycle)
        self._log.write(TRUTH_TOPIC, cycle.tick.t_ns, self._bridge.truth())
        self._watch(cycle)


def _judge(scenario: Scenario, pilot: ScriptedGround, interrupted: bool) -> Outcome:
    if interrupted:
        return Outcome(False, "interrupted")
    if pilot.completed:
        return Outcome(True, "completed")
    if scenario.completes is Completes.SURFACED:
        return Outcome(False, f"did not surface within {scenario.duration:g} s")
    return Outcome(False, "was no longer flying when the time was over")


def _load(cls: type[Any], path: Path, over: Mapping[str, Any] = MappingProxyType({})) -> Any:
    where = f"{path} under the scenario's [{path.stem}]" if over else str(path)
    return load(cls, app.merge(read_toml(path), over), where)


def _bus(stack: contextlib.ExitStack, flight: Flight) -> CanBus:
    bus = open_bus(flight.wish.bus, flight.io.can.channel)
    stack.callback(bus.close)
    return bus


@contextlib.contextmanager
def _interruptible() -> Iterator[list[int]]:
    """A list that holds the first Ctrl-C (or SIGTERM); a second one interrupts in the ordinary way."""
    caught: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def note(number: int, _frame: object) -> None:
        caught.append(number)
        signal.signal(number, before[signal.Signals(number)])

    for number in before:
        signal.signal(number, note)
    try:
        yield caught
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def _no_garbage() -> Iterator[None]:
    """Spares the cycle the collector's pauses: nothing that a cycle makes refers to itself."""
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        gc.unfreeze()
