"""`sternplane study estimation`: runs every case, judges it by its targets, and writes report.html and results.json."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from firmware_py.run import version
from firmware_py.run.run_folders import run_folder
from sternplane.campaign.files import write
from sternplane.campaign.seeds import seeds_of
from sternplane.plain_console import PlainConsole
from sternplane.sitl.flight import CONFIG, FlightRequest, prepare
from sternplane.sitl.taken_settings import Takes, plain, taken, told
from sternplane.study.begun_with import refuse_other
from sternplane.study.cases import CASES
from sternplane.study.chance import MISS
from sternplane.study.kept_runs import FOLDER, KeptRuns
from sternplane.study.laid_settings import laid
from sternplane.study.page import page, target_text
from sternplane.study.pool import run_all
from sternplane.study.rows import Row, Study

JUDGED_FROM = 1000
"""Seeds below are for tuning; the figures that count come from here on."""
MOST = 400
_FILTER = "autopilot.estimation.coefficients"
TAKES = Takes(
    (_FILTER,),
    f"the estimation study sets vehicle, sensors and sea itself; it takes keys of {_FILTER}",
    tuple(
        f"{_FILTER}.{key}"
        for key in (
            *("std_pct", "speed_bias_m_s", "rate_bias_deg_s", "angle_bias_deg", "nuisances", "stds"),
            *("surge_noise", "roll_noise", "fin_resolution_deg"),
        )
    ),
)
"""`setups.flying` suits the rest of the filter to what is flown; the bound knows these and no other vehicle."""

ESTIMATION = Study(
    "Estimation study",
    "What the coefficient filter learns, beside the Cramér-Rao bound of what anybody can learn.",
    CASES,
    chance=True,
)


def command(options: argparse.Namespace) -> int:
    """Run the study; return 0 if every target is met, 1 if one is missed."""
    return run_study(ESTIMATION, options, MOST, TAKES)


def run_study(study: Study, options: argparse.Namespace, most: int, takes: Takes) -> int:
    """Run a study over `most` seeds unless others are asked for; return 0 if every target is met, else 1."""
    seeds = seeds_of(options.seeds, range(JUDGED_FROM, JUDGED_FROM + most))
    settings = taken(options.settings, takes)
    refuse_values(settings)
    folder = run_folder(options.out)
    study = study.in_form(options.short)
    refuse_other(folder, FOLDER, settings)
    kept = KeptRuns(folder, version.git_revision())
    found = run_all(study.cases, seeds, options.short, kept, PlainConsole(stderr=True), settings)
    with laid(settings):
        results = [case.evaluate(runs) for case, runs in zip(study.cases, found, strict=True)]
    rows = [row for result in results for row in result.rows]
    form = "short form" if options.short else "full form"
    identity = [f"seeds {seeds.start} to {seeds.stop - 1} · {form} · revision {kept.revision}"]
    if kept.others:
        identity.append(f"Some runs were made by another revision: {', '.join(sorted(kept.others))}.")
    if study.chance:
        identity.append(chance_text(rows))
    leave_results(folder, settings, rows)
    if not options.no_report:
        write(folder / "report.html", page(study, results, [*identity, *told(settings)]))
    _print(rows, study.chance)
    print_places(folder, options.no_report)
    return 1 if any(row.ok is False for row in rows) else 0


def chance_text(rows: Sequence[Row]) -> str:
    """Say how many rows chance can move, and how often a right filter misses one of them by chance."""
    moved = sum(row.n > 0 for row in rows if row.ok is not None)
    if not moved:
        return "No row depends on chance."
    return f"{moved} rows depend on chance: a right filter misses one of them in {moved * MISS:.1e} of all studies."


def _print(rows: Sequence[Row], chance: bool) -> None:
    """Print a line for each case, and each target that was missed."""
    console = PlainConsole()
    table = Table("case", "met", "of", "least margin", box=None)
    for name in dict.fromkeys(row.case for row in rows):
        judged = [row for row in rows if row.case == name and row.ok is not None]
        if judged:
            margins = [row.margin for row in judged if row.margin is not None]
            least = f"{100.0 * min(margins):.0f} %" if margins else ""
            table.add_row(name, str(sum(bool(row.ok) for row in judged)), str(len(judged)), least)
    console.print(table)
    if chance:
        console.print(chance_text(rows), highlight=False, soft_wrap=True)
    print_missed(rows)


def print_missed(rows: Sequence[Row]) -> None:
    """Print each target that was missed."""
    console = PlainConsole()
    for row in rows:
        if row.ok is False:
            seeds = f" (n = {row.n})" if row.n else ""
            text = f"missed: {row.case}: {row.figure}: {row.value:.4g}, target {target_text(row)}{seeds}"
            console.print(text, highlight=False, soft_wrap=True)


def refuse_values(settings: Sequence[str], config: Path = CONFIG) -> None:
    """Refuse settings with which nothing can fly, before anything does; raises as `prepare`."""
    if settings:
        prepare(FlightRequest(config=config, settings=tuple(settings)), {})


def leave_results(folder: Path, settings: Sequence[str], rows: Sequence[Row]) -> None:
    """Write results.json."""
    document = {"settings": plain(settings), "rows": [row.plain() for row in rows]}
    write(folder / "results.json", json.dumps(document, indent=1, allow_nan=False) + "\n")


def print_places(folder: Path, no_report: bool) -> None:
    """Print where report and results are."""
    names = ["results.json"] if no_report else ["report.html", "results.json"]
    PlainConsole().print("\n".join([str(folder / name) for name in names]), highlight=False, soft_wrap=True)
