"""`sternplane study safety`: flies every fault, judges it by the truth, and writes report.html and results.json."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from firmware_py.adapters.installation import configs
from firmware_py.run import version
from firmware_py.run.run_folders import run_folder
from sternplane.campaign.files import write
from sternplane.campaign.seeds import seeds_of
from sternplane.plain_console import PlainConsole
from sternplane.sitl.taken_settings import Takes, taken, told
from sternplane.study.begun_with import refuse_other
from sternplane.study.command import JUDGED_FROM, leave_results, print_missed, print_places, refuse_values
from sternplane.study.rows import Row
from sternplane.study.safety.campaign import LISTED, SEEDS, jobs
from sternplane.study.safety.flight import vehicle_of
from sternplane.study.safety.flight_list import short_revision
from sternplane.study.safety.page import page
from sternplane.study.safety.pool import fly_all
from sternplane.study.safety.store import FILE, Store
from sternplane.study.safety.verdict import rows

LIST = "list"
"""Of --trial: what there is."""
_MOST = 4
"""So many revisions are named; each flight of the page has its own."""
TAKES = Takes(
    ("autopilot", "vehicle", "truth", "sensors", "io"),
    "the safety study sets mission, faults and sea itself; it takes keys of autopilot, vehicle, truth, sensors and io",
    ("autopilot.safety.depth_max_m", "autopilot.estimation.learning.enabled"),
)


def command(options: argparse.Namespace) -> int:
    """Run the campaign, or list its trials; return 0 if no flight is unsafe and every target is met, else 1."""
    if LIST in options.trial:
        print("\n".join(LISTED))
        return 0
    seeds = seeds_of(options.seeds, range(JUDGED_FROM, JUDGED_FROM + SEEDS))
    wanted, revision = jobs(seeds, options.short, options.trial), version.git_revision()
    settings = taken(options.settings, TAKES)
    for vehicle in sorted({vehicle_of(job) for job in wanted}):
        refuse_values(settings, configs() / vehicle)
    folder = run_folder(options.out)
    refuse_other(folder, FILE, settings)
    store, interrupted = Store(folder), False
    try:
        fly_all(wanted, store, revision, PlainConsole(stderr=True), settings)
    except KeyboardInterrupt:
        interrupted = True  # whoever looks in the middle of a long campaign wants to see what is flown
    finally:
        store.close()
    flights = store.of(job.key for job in wanted)
    if interrupted and not flights:
        raise KeyboardInterrupt
    found = rows(flights)
    form = "short form" if options.short else "these trials" if options.trial else "full form"
    hours = sum(flight["found"]["t_end"] for flight in flights) / 3600.0, sum(f["cpu_s"] for f in flights) / 3600.0
    identity = (
        f"seeds {seeds.start} to {seeds.stop - 1} · {form} · {_count(flights, wanted)} · {hours[0]:.1f} h under water, "
        f"flown in {hours[1]:.2f} h of one processor · revision {revision}"
    )
    leave_results(folder, settings, found)
    if not options.no_report:
        told_of, warnings = (identity, *told(settings)), _warnings(flights, revision)
        write(folder / "report.html", page(flights, found, told_of, warnings, settings))
    _print(found)
    print_places(folder, options.no_report)
    if interrupted:
        PlainConsole().print(f"{_count(flights, wanted)}: the same --out goes on with the rest")
        raise KeyboardInterrupt
    return 1 if any(row.ok is False for row in found) else 0


def _count(flights: Sequence[Any], wanted: Sequence[Any]) -> str:
    return f"{len(flights)} flights" if len(flights) == len(wanted) else f"{len(flights)} of {len(wanted)} flights"


def _warnings(flights: Sequence[dict[str, Any]], revision: str) -> list[str]:
    """Say that some flights were made by another revision: a campaign goes on where it was broken off."""
    others = {flight["revision"] for flight in flights} - {revision}
    if not others:
        return []
    count = sum(flight["revision"] in others for flight in flights)
    named = ", ".join(sorted(map(short_revision, others)))
    by = f"another revision: {named}" if len(others) <= _MOST else f"{len(others)} other revisions"
    return [
        f"{count} of {len(flights)} flights were made by {by}. "
        "They were found in this folder, and are judged by the judge of today; today they may fly otherwise. Of the "
        "project's recorded flights those that a change of flying code may change were flown again. "
        "Another --out flies all anew."
    ]


def _print(found: Sequence[Row]) -> None:
    print_missed(found)
    judged = [row for row in found if row.ok is not None]
    PlainConsole().print(f"{sum(bool(row.ok) for row in judged)} of {len(judged)} targets met")
