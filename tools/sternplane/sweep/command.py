"""`sternplane sweep`: flies a plan, and leaves the table of all flights, the worst of them and a report."""

from __future__ import annotations

import argparse
import contextlib
import shlex
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from firmware_py.run.run_folders import LOG_FILE
from firmware_py.run.usage_error import UsageError
from sternplane.campaign.crew import Crew, Died, LocalCrew
from sternplane.campaign.dask_crew import DaskCrew, check_address
from sternplane.campaign.engine import complete
from sternplane.campaign.files import write
from sternplane.campaign.line_store import LineStore
from sternplane.cli.extras import require, require_report
from sternplane.plain_console import PlainConsole
from sternplane.sweep import inputs, laws
from sternplane.sweep.accused import accused, text_of
from sternplane.sweep.flight import SCENARIO_FILE, died_row, fly_row
from sternplane.sweep.plan import Flights
from sternplane.sweep.planning import going_on, planned
from sternplane.sweep.table import FILE as TABLE
from sternplane.sweep.table import parquet
from sternplane.sweep.worst import Row, judged_by, refuse_unknown, worst

WORST, LOGS, AGAIN = "worst", "logs", "again"
_WORST = 5
"""Of them leave their logs, unless told otherwise."""
_MOST_ACCUSED = 8
"""So many lines tell what was said to be at fault."""


def command(options: argparse.Namespace) -> int:
    """Fly what is missing; return 0 if no flight ended in an error, else 1."""
    require("data", "pyarrow")
    if options.dask is not None:
        require("cluster", "distributed")
        check_address(options.dask)
    if not options.no_report:
        require_report()
    console = PlainConsole(stderr=True, highlight=False, soft_wrap=True)
    if options.again is not None:
        return fly_again(options, console)
    _refuse_local(options)
    flights, folder, store = planned(options, console)
    began = time.monotonic()
    try:
        files = inputs.read_inputs(folder)
        refuse_unknown(list(store.rows()), options.judge)
        if len(flights.laws) > 1 and (said := laws.unsteered(files, SCENARIO_FILE, flights.plan.scenario)):
            console.print(said, markup=False)
        missing = [k for k in range(len(flights)) if str(k) not in store.keys]
        with _crew(options, len(missing), console) as crew:
            logs = folder / LOGS if options.keep_logs else None
            _fly(flights, missing, files, store, logs, crew, console, options.judge)
        rows = sorted(store.rows(), key=lambda row: int(row["flight"]))
    finally:
        store.close()
    _told_speed(rows, {*missing}, time.monotonic() - began, console)
    write(folder / TABLE, parquet(rows, flights.plan.plain()))
    judge = judged_by(rows, options.judge)
    _fly_worst(flights, worst(rows, judge, _most(options)), files, folder, options, console)
    _report(flights, rows, judge, folder, options)
    return 1 if any(row["error"] for row in rows) else 0


def _most(options: argparse.Namespace) -> int:
    """Return how many of the worst leave their logs: where no report is wanted none, unless told."""
    given: int | None = options.worst
    return given if given is not None else 0 if options.no_report else _WORST


def _refuse_local(options: argparse.Namespace) -> None:
    """Refuse options of this computer's processes where a cluster flies.

    Raises:
        UsageError: which, and what there is instead.
    """
    if options.dask and options.keep_logs:
        raise UsageError(
            "--keep-logs: what a cluster flies leaves its logs nowhere; leave it away: the worst (--worst N) leave "
            "theirs here, and --again N flies any other again"
        )
    if options.dask and options.jobs:
        raise UsageError("--jobs: a cluster has as many as it has workers (dask worker --nworkers N); leave it away")


def _fly(
    flights: Flights,
    missing: Sequence[int],
    files: dict[str, bytes],
    store: LineStore,
    logs: Path | None,
    crew: Crew,
    console: Console,
    judge: str | None,
) -> None:
    def arguments(flight: int) -> tuple[Any, ...]:
        return flights.job(flight), files, str(logs / f"{flight:06d}.mcap") if logs else None

    def take(_: int, row: dict[str, Any]) -> None:
        nonlocal judge
        store.add(row)
        if not row["error"]:
            refuse_unknown([row], judge)  # a slip of the pen must not cost the hours of all flights
            judge = None
        if row["error"]:
            console.print(f"flight {row['flight']}: {row['error']}", markup=False)

    def died(flight: int, why: Died) -> None:
        take(flight, died_row(flights.job(flight), str(why)))

    done = len(flights) - len(missing)
    complete(
        fly_row,
        missing,
        arguments,
        take,
        "flights",
        console,
        parts=20,
        done=done,
        place=store.path,
        crew=crew,
        died=died,
    )


def _fly_worst(
    flights: Flights,
    rows: Sequence[Row],
    files: dict[str, bytes],
    folder: Path,
    options: argparse.Namespace,
    console: Console,
) -> None:
    """Fly the worst again, here, and leave their logs; a row that comes out otherwise is told."""
    logs = {row["flight"]: folder / WORST / f"{row['flight']:06d}" / LOG_FILE for row in rows if not row["error"]}
    known = {row["flight"]: row for row in rows}

    def arguments(flight: int) -> tuple[Any, ...]:
        return flights.job(flight), files, str(logs[flight])

    def take(flight: int, row: dict[str, Any]) -> None:
        if row != known[flight]:
            other = next(name for name in {**row, **known[flight]} if row.get(name) != known[flight].get(name))
            console.print(f"flight {flight} came out otherwise the second time, first in {other}", markup=False)

    missing = [flight for flight, log in logs.items() if not log.exists()]
    crew = LocalCrew(min(options.jobs or LocalCrew().size, max(len(missing), 1)))
    complete(fly_row, missing, arguments, take, "worst flights", console, crew=crew)
    if options.no_report:
        return
    from sternplane.report.report import write_report_of_file

    for log in logs.values():
        if log.exists() and not (log.parent / "report.html").exists():
            write_report_of_file(log, log.parent)


def _report(flights: Flights, rows: Sequence[Row], judge: str, folder: Path, options: argparse.Namespace) -> None:
    console, completed = PlainConsole(highlight=False, soft_wrap=True), sum(bool(row["completed"]) for row in rows)
    for law in flights.laws:
        own = [row for row in rows if row["law"] == law]
        console.print(f"  {law}: {sum(bool(row['completed']) for row in own)} of {len(own)} completed")
    if said := laws.equal(rows):
        console.print(f"  {said}")
    told = accused(rows)
    for one in told[:_MOST_ACCUSED]:
        console.print(f"  {text_of(one)}", markup=False)
    if len(told) > _MOST_ACCUSED:
        console.print(f"  and {len(told) - _MOST_ACCUSED} more: see the report")
    left = [folder / TABLE]
    if not options.no_report:
        from sternplane.sweep.page import page

        write(folder / "report.html", page(flights, rows, judge, folder, _most(options)))
        left.insert(0, folder / "report.html")
    console.print(f"  {completed} of {len(rows)} flights completed")
    for path in left:
        console.print(f"  {path}")


def _told_speed(rows: Sequence[Row], flown: set[int], seconds: float, console: Console) -> None:
    """Say how fast it went, which stands in no file: a table does not hang on the computer's speed."""
    if not flown:
        return
    sailed = sum(row.get("vehicle_time_s") or 0.0 for row in rows if row["flight"] in flown)
    console.print(
        f"{len(flown):,} flights, {sailed:,.0f} s of vehicle time, in {seconds:,.0f} s: "
        f"{len(flown) / seconds:.2f} flights/s, {sailed / seconds:.1f}× real time"
    )


@contextlib.contextmanager
def _crew(options: argparse.Namespace, missing: int, console: Console) -> Any:
    """Who flies: processes of this computer, or a cluster."""
    if options.dask and missing:
        with DaskCrew(options.dask, console) as cluster:
            console.print(f"{cluster.size} workers at {options.dask}")
            yield cluster
    else:
        yield LocalCrew(max(min(options.jobs or LocalCrew().size, missing), 1))


def fly_again(options: argparse.Namespace, console: Console) -> int:
    """Fly one flight of a sweep again, as `sternplane sitl` does, and say that command."""
    if options.out is None:
        raise UsageError("--again: give the sweep's folder with --out")
    flights = going_on(options, console)
    if not 0 <= options.again < len(flights):
        raise UsageError(f"--again {options.again}: flights are 0 to {len(flights) - 1}")
    job, files = flights.job(options.again), options.out / inputs.FOLDER
    words = ["sitl", "--scenario", str(files / SCENARIO_FILE), "--config", str(files), "--seed", str(job.seed)]
    words += [word for text in job.settings for word in ("--set", text)]
    words += [word for text in job.faults for word in ("--fault", text)]
    words += ["--out", str(options.out / AGAIN / f"{job.flight:06d}")]
    words += ["--no-report"] if options.no_report else []
    console.print(f"sternplane {shlex.join(words)}", markup=False)
    from sternplane.cli.main import main

    return main(words)
