"""`sternplane fly`: the vehicle alone. What runs at sea."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from rich.console import Console

from firmware_py import app
from firmware_py.adapters.files import read_toml
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.recorder import LogError, LogWriter, Recorder
from firmware_py.adapters.turns import LockstepError
from firmware_py.params import load
from firmware_py.records.cycle import Cycle
from tools import machine, report, state, vehicle
from tools.folders import run_folder
from tools.ground import open_ground
from tools.interrupt import interruptible
from tools.log import read
from tools.summary import table


class SeaTape:
    """A recorder that never ends a flight: when the log cannot be written it says so once, and the vehicle flies on."""

    def __init__(self, log: LogWriter, console: Console) -> None:
        self._recorder = Recorder(log)
        self._console = console
        self.cycles = 0
        self.broken = False

    def write(self, cycle: Cycle) -> None:
        """Keeps one cycle while that is possible, and shows its events."""
        for event in cycle.events:
            self.say(f"{cycle.tick.t:9.2f} s  {event}")
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
    io_file = options.io or options.config / "io_sitl.toml"
    configuration = {
        **app.read_configuration(options.config),
        "mission": {"waypoints": app.read_mission(options.config)},
        "kept": state.load(options.state) if options.state else {},
    }
    params = app.autopilot_params(configuration)
    io = load(IoParams, read_toml(io_file), str(io_file))
    autopilot = app.build(configuration)
    folder = run_folder(options.out)
    console = Console(stderr=True)
    header = machine.header("fly", configuration, pace=options.pace)
    completed, reason, began = True, "ended", time.monotonic()
    with open_ground(options.gcs, configuration) as stations, interruptible() as interrupted:
        log = LogWriter(folder / "log.mcap", header)
        tape = SeaTape(log, console)
        try:
            vehicle.run(
                autopilot,
                params.rate,
                io,
                options.bus or io.can.bus,
                Path(options.dvl or io.dvl.port),
                options.pace,
                stations.ground,
                tape,
                lambda: bool(interrupted),
                tape.say,
            )
        except LockstepError as error:
            completed, reason = False, str(error)
            console.print(f"sternplane: {error}", highlight=False, soft_wrap=True)
        finally:
            if not tape.broken:
                log.close({"completed": completed, "reason": reason, "wall_s": time.monotonic() - began})
    state.save(options.state or folder / "state", autopilot.estimator.keep())
    if tape.cycles:
        Console().print(table(report.leave(read(folder / "log.mcap"), folder)))
    return 0 if completed else 1
