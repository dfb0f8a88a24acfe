"""`sternplane sitl` and `sternplane scenarios`."""

from __future__ import annotations

import argparse

from rich.console import Console

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.hil.hil_link import parse_link, serve
from sim_bridge.scenarios import known, load_scenario
from sternplane.cli.errors import UsageError
from sternplane.cli.progress import Progress
from sternplane.cli.run_folders import point_latest, run_folder
from sternplane.fly import kept_state
from sternplane.fly.ground import open_ground
from sternplane.logs.reading import TRUTH_FILE
from sternplane.logs.summary import table
from sternplane.report import report
from sternplane.sitl.flight import SCENARIOS, Wish, fly, prepare
from sternplane.sitl.two_process import fly_two_processes


def command(options: argparse.Namespace) -> int:
    """Flies, reports, and returns the exit status."""
    if options.seed < 0:
        raise UsageError(f"--seed {options.seed}: must be 0 or more")
    bus, faults, address = options.bus, tuple(options.fault), parse_link(options.link)
    if address and not bus.startswith("virtual"):
        raise UsageError(f"--bus {bus} and --link {options.link}: there is no bus on that link; leave --bus away")
    wish = Wish(
        options.scenario,
        options.config,
        bus,
        options.pace,
        options.seed,
        options.io,
        faults,
        options.link,
        options.state,
    )
    flight = prepare(wish, kept_state.load(options.state) if options.state else {})
    # What cannot be opened is refused before anything is written.
    (serve(address) if address else open_bus(bus)).close()
    with open_ground(options.gcs, flight.configuration, options.gcs_key, options.state) as stations:
        folder = run_folder(options.out)
        stations.save_changes_in(options.state, folder)
        (folder / TRUTH_FILE).unlink(missing_ok=True)
        scenario, log = flight.scenario, folder / "log.mcap"
        with Progress(scenario.duration, len(scenario.mission.waypoints), Console(stderr=True)) as progress:
            if bus.startswith("virtual") and not address:
                outcome = fly(flight, log, progress.update, stations.merged_with, stations.losses)
            else:
                outcome = fly_two_processes(flight, folder, progress.update, stations.merged_with, stations.losses)
    kept_state.save(options.state or folder / "state", flight.autopilot.estimator.keep())
    point_latest(folder)
    console = Console()
    console.print(table(report.leave_of(log, folder)))
    for name in ("report.html", "summary.json", "log.mcap"):
        console.print(f"  {folder / name}", highlight=False, soft_wrap=True)
    return 0 if outcome.completed else 1


def list_scenarios(_options: argparse.Namespace) -> int:
    """Prints every scenario with its sentence."""
    names = known(SCENARIOS)
    width = max(map(len, names))
    for name in names:
        print(f"{name:<{width}}  {load_scenario(name, SCENARIOS).description}")
    return 0
