"""`sternplane sitl` and `sternplane scenarios`."""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from rich.console import Console

from sim_bridge.scenarios import known, load_scenario
from tools import report, state
from tools.errors import UsageError
from tools.flight import SCENARIOS, Wish, fly, prepare
from tools.log import read
from tools.progress import Progress
from tools.summary import table


def command(options: argparse.Namespace) -> int:
    """Flies, reports, and returns the exit status."""
    if options.seed < 0:
        raise UsageError(f"--seed {options.seed}: must be 0 or more")
    wish = Wish(options.scenario, options.config, options.bus, options.pace, options.seed)
    flight = prepare(wish, state.load(options.state) if options.state else {})
    folder = run_folder(options.out)
    scenario, log = flight.scenario, folder / "log.mcap"
    console = Console()
    with Progress(scenario.duration, len(scenario.waypoints), Console(stderr=True)) as progress:
        outcome = fly(flight, log, progress.update)
    state.save(options.state or folder / "state", flight.autopilot.estimator.keep())
    console.print(table(report.leave(read(log), folder)))
    for name in ("report.html", "summary.json", "log.mcap"):
        console.print(f"  {folder / name}", highlight=False, soft_wrap=True)
    return 0 if outcome.completed else 1


def list_scenarios() -> int:
    """Prints every scenario with its sentence."""
    names = known(SCENARIOS)
    width = max(map(len, names))
    for name in names:
        print(f"{name:<{width}}  {load_scenario(name, SCENARIOS).description}")
    return 0


def run_folder(out: Path | None) -> Path:
    """The folder of a run, made: `out`, or a new one below runs/ where the command was called.

    Raises:
        UsageError: it cannot be made.
    """
    try:
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
            return out
        runs = Path("runs")
        runs.mkdir(exist_ok=True)
        folder = runs / time.strftime("%Y%m%d-%H%M%S")
        if folder.exists():  # another run began in the same second
            return Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=runs))
        folder.mkdir()
        return folder
    except OSError as error:
        where = f"--out {out}" if out is not None else "runs/"
        raise UsageError(f"{where}: cannot be made ({error.strerror}); choose another folder with --out") from None
