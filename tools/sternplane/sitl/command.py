"""`sternplane sitl`."""

from __future__ import annotations

import argparse
import contextlib
import json
from pathlib import Path

from firmware_py import config_files
from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.hil.hil_link import parse_hil_link, serve
from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.records.cycle import Cycle
from firmware_py.run import kept_navigation
from firmware_py.run.ground_links import open_ground
from firmware_py.run.kept_passport import PassportKeeper
from firmware_py.run.passport_note import PassportNote
from firmware_py.run.run_folders import LOG_FILE, flight_folder, point_latest
from firmware_py.run.terminal import say, to_all
from firmware_py.run.usage_error import UsageError
from sternplane.cli import extras
from sternplane.cli.progress import Progress
from sternplane.logs import after_log
from sternplane.logs.streaming import stream
from sternplane.logs.summary import Summary, summarise
from sternplane.logs.summary_text import summary_table
from sternplane.logs.truth_beside import TRUTH_FILE
from sternplane.plain_console import PlainConsole
from sternplane.sitl.flight import Flight, Outcome, fly
from sternplane.sitl.held_log import HeldLog
from sternplane.sitl.request import parse_settings, requested
from sternplane.sitl.resumed_flight import prepare_to_resume
from sternplane.sitl.run_traces import RunTraces
from sternplane.sitl.two_process import fly_two_processes


def command(options: argparse.Namespace) -> int:
    """Fly and report; return the exit status."""
    bus, address = options.bus, parse_hil_link(options.link)
    if address and not bus.startswith("virtual"):
        raise UsageError(f"--bus {bus} and --link {options.link}: there is no bus on that link; leave --bus away")
    flight = prepare_to_resume(requested(options))
    for setting in parse_settings(flight.request.settings):
        say(f"sternplane: {setting.key} = {setting.value} set")
    for note in (*flight.notes, *(f"{doubt}; the flight goes on" for doubt in flight.doubts)):
        say(f"sternplane: {note}")
    # What cannot be opened is refused before anything is written.
    (serve(address) if address else open_bus(bus)).close()
    with contextlib.ExitStack() as stack:
        folder, log, outcome, passport = _fly(options, flight, stack)
        point_latest(folder)
        console = PlainConsole()
        console.print(summary_table(_leave(log, folder, not options.no_report)))
        if passport:
            console.print(f"  {passport}", highlight=False, soft_wrap=True)
    if log.removed:
        raise LogError(f"{folder / LOG_FILE}: was removed in flight, and is lost")
    for name in ("report.html", "summary.json", LOG_FILE):
        if (folder / name).exists():
            console.print(f"  {folder / name}", highlight=False, soft_wrap=True)
    return 0 if outcome.completed else 1


def _fly(
    options: argparse.Namespace, flight: Flight, stack: contextlib.ExitStack
) -> tuple[Path, HeldLog, Outcome, str]:
    """Fly, and leave log and state in the folder of the run.

    Returns:
        The folder; its log, held by a stack; the outcome; where a passport was kept, or why none.
    """
    virtual = options.bus.startswith("virtual") and not parse_hil_link(options.link)
    with (
        RunTraces() as traces,
        open_ground(options.gcs, flight.configuration, options.gcs_key, options.state) as stations,
    ):
        there = options.out is not None and options.out.exists()
        folder = flight_folder(options.out)
        traces.follow(folder, made=not there or folder != options.out)
        stations.save_changes_in(options.state, folder)
        if options.out is not None and folder != options.out:
            say(f"sternplane: --out {options.out}: holds a log already, which is kept; this run is in {folder}")
        log = stack.enter_context(HeldLog(folder / LOG_FILE))
        traces.claimed = True
        for left in (folder / TRUTH_FILE, after_log.place_of(folder / LOG_FILE)):
            left.unlink(missing_ok=True)
        for note in flight.notes:
            stations.ground.say(note)
        scenario = flight.scenario
        keeper = kept_navigation.NavigationKeeper(
            stations.ground.save,
            lambda: flight.autopilot.parts.estimator.keep(),
            flight.io.state.interval,
            lambda t: flight.autopilot.parts.supervisor.keep(t),
        )
        passports = PassportKeeper(
            stations.ground.save,
            lambda: flight.autopilot.parts.estimator.learned_model(),
            flight.configuration,
            flight.io.state.passport_interval,
        )
        note_of_passport = PassportNote(options.state or folder / "state", passports)
        with Progress(scenario.duration, len(scenario.mission.waypoints), PlainConsole(stderr=True)) as progress:

            def watch(cycle: Cycle) -> None:
                traces.flown = True
                progress.update(cycle)
                keeper.update(cycle)
                passports.update(cycle)
                note_of_passport.update(cycle)
                log.update(cycle)

            stations.losses.tell = to_all(progress.tell, stations.ground.say)
            if virtual:
                outcome = fly(flight, folder / LOG_FILE, watch, stations.merged_with, stations.losses)
            else:
                outcome = fly_two_processes(flight, folder, watch, stations.merged_with, stations.losses)
    navigation = flight.autopilot.parts.estimator.keep()
    kept_navigation.save(options.state or folder / "state", navigation, keeper.speed, keeper.mode)
    passports.leave(options.state or folder / "state")
    learns = config_files.autopilot_params(flight.configuration).estimation.learning.enabled
    return folder, log, outcome, note_of_passport.text if learns else ""


def _leave(log: HeldLog, folder: Path, wanted: bool) -> Summary:
    """Leave summary.json, and report.html if it is wanted; where nothing can draw, say what to install."""
    if wanted and not extras.missing():
        from sternplane.report import report

        return report.write_report_of_file(log.readable, folder)
    summary = summarise(stream(log.readable))
    try:
        (folder / "report.html").unlink(missing_ok=True)
        write_atomically(folder / "summary.json", f"{json.dumps(summary, indent=2, ensure_ascii=False)}\n".encode())
    except OSError as error:
        raise LogError(f"{folder}: the summary cannot be written ({error.strerror})") from None
    if wanted:
        say(f"sternplane: no report.html without {', '.join(extras.missing())}: {extras.HINT}")
    return summary
