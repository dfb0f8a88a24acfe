"""`sternplane fly`: the vehicle alone. What runs at sea."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

from rich.console import Console

from firmware_py import app
from firmware_py.adapters.hil.hil_link import parse_link, resolve
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.lockstep.lockstep import LockstepError
from firmware_py.adapters.storage.recorder import LogError, LogWriter, Recorder
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.params import load
from firmware_py.records.cycle import Cycle
from firmware_py.schedule import NS_PER_S
from sternplane.cli.errors import UsageError
from sternplane.cli.interrupt import interruptible
from sternplane.cli.run_folders import point_latest, run_folder
from sternplane.fly import kept_state, provenance, vehicle
from sternplane.fly.ground import open_ground
from sternplane.fly.sensor_watch import SensorWatch
from sternplane.logs.summary import table
from sternplane.report import report

_STATUS_NS = 10 * NS_PER_S
"""How often a line says how it stands."""
_AGAIN = 3
"""The exit status that asks whoever started the vehicle to start it again."""


class FlightRecorder:
    """A recorder that never ends a flight: when the log cannot be written it says so once, and the vehicle flies on."""

    def __init__(self, log: LogWriter, console: Console) -> None:
        self._recorder = Recorder(log)
        self._console = console
        self._hearing = SensorWatch()
        self.cycles = 0
        self.last: Cycle | None = None
        self.broken = False

    def write(self, cycle: Cycle) -> None:
        """Keeps one cycle while that is possible, and shows its events."""
        for line in (*cycle.events, *self._hearing.changes(cycle)):
            self.say(f"{cycle.tick.t:9.2f} s  {line}")
        if cycle.tick.k * cycle.tick.dt_ns % _STATUS_NS == 0:
            eta, mode = cycle.state.eta, cycle.mode.mode.name.lower()
            heading = round(math.degrees(eta.psi)) % 360
            self.say(
                f"{cycle.tick.t:9.2f} s  {mode}, depth {eta.z:.2f} m, heading {heading}°, {cycle.state.nu.u:.2f} m/s"
            )
        self.last = cycle
        if self.broken:
            return
        try:
            self._recorder.write(cycle)
            self.cycles += 1
        except LogError as error:
            self.broken = True
            self.say(f"sternplane: {error}; flying on without a log")

    def say(self, line: str) -> None:
        """Shows a line to people."""
        self._console.print(line, highlight=False, markup=False, soft_wrap=True)


def command(options: argparse.Namespace) -> int:
    """Flies until someone says stop; the exit status."""
    io_file, address = options.io or options.config / "io_sitl.toml", parse_link(options.link)
    pace = options.pace or ("bus" if address else "realtime")
    if address and (options.bus or options.dvl or pace != "bus"):
        raise UsageError(
            f"--link {options.link} has no bus, no DVL and the plant's pace: no --bus, --dvl, --pace realtime"
        )
    configuration = app.under_plans(
        {
            **app.read_configuration(options.config, vehicle.OVER_HIL if address else None, options.state),
            "mission": app.read_mission(options.config),
            "kept": kept_state.load(options.state) if options.state else {},
        },
        options.state,
    )
    params = app.autopilot_params(configuration)
    io = load(IoParams, read_toml(io_file), str(io_file))
    autopilot = app.build(configuration)
    spec = options.bus or io.can.bus
    # What cannot be opened is refused before anything is written.
    if address:
        resolve(address)
    else:
        vehicle.check(spec)
    folder = run_folder(options.out)
    console = Console(stderr=True)
    header = provenance.header("fly", configuration, pace=pace, link=options.link)
    lost, reason, began = False, "", time.monotonic()
    losses: dict[str, int] = {}
    with (
        open_ground(options.gcs, configuration, options.gcs_key, options.state) as stations,
        interruptible() as interrupted,
    ):
        stations.save_changes_in(options.state, folder)
        log = LogWriter(folder / "log.mcap", header)
        tape = FlightRecorder(log, console)

        def stop() -> bool:
            return bool(interrupted) or ground.node.end_request != ""

        ground = stations.ground
        ground.node.allow_end()
        try:
            if address or pace == "bus":
                tape.say(f"waiting for the {'simulator' if address else 'plant'} on {address or spec}")
            if address:
                vehicle.run_hil(autopilot, configuration, address, io, ground, tape, stop, tape.say, losses)
            else:
                dvl = Path(options.dvl or io.dvl.place(spec))
                vehicle.run(autopilot, params.rate, io, spec, dvl, pace, ground, tape, stop, tape.say, losses)
        except LockstepError as error:
            lost, reason = True, str(error)
            console.print(f"sternplane: {error}", highlight=False, soft_wrap=True)
        finally:
            node = ground.node
            asked = f"{node.end_request} by station {node.end_requester}" if node.end_request else ""
            reason = reason or _how(tape.last, bool(interrupted), asked)
            if not tape.broken:
                end = {"completed": None, "reason": reason, "wall_s": time.monotonic() - began}
                log.close({**end, "losses": {**losses, **stations.losses()}})
    kept_state.save(options.state or folder / "state", autopilot.estimator.keep())
    if tape.cycles:
        Console().print(table(report.leave_of(folder / "log.mcap", folder)))
    point_latest(folder)
    tape.say(f"  {folder}")
    return 1 if lost else _AGAIN if ground.node.end_request == "reboot" else 0


def _how(last: Cycle | None, interrupted: bool, asked: str) -> str:
    """How a flight that nothing broke off came to its end."""
    by = "ended by a person" if interrupted else asked or "ended with the plant's time"
    return by if last is None else f"{by}, in mode {last.mode.mode.name.lower()}"
