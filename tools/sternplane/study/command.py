"""`sternplane study estimation`: flies and judges every case, and leaves report.html and results.json."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from rich.console import Console
from rich.table import Table

from firmware_py.run import provenance
from firmware_py.run.errors import UsageError
from firmware_py.run.run_folders import run_folder
from sternplane.study.cases import CASES
from sternplane.study.page import page
from sternplane.study.pool import run_all
from sternplane.study.rows import Row

JUDGED_FROM = 1000
"""Seeds below are for tuning; the figures that count come from here on."""
MOST = 400


def command(options: argparse.Namespace) -> int:
    """Runs the study; 0 if every target is met, 1 if one is missed."""
    seeds = seeds_of(options.seeds)
    folder = run_folder(options.out)
    findings = [
        case.judge(runs) for case, runs in zip(CASES, run_all(seeds, options.short, Console(stderr=True)), strict=True)
    ]
    rows = [row for found in findings for row in found.rows]
    form = "short form" if options.short else "full form"
    identity = f"seeds {seeds.start} to {seeds.stop - 1} · {form} · revision {provenance.git_revision()}"
    _write(folder / "results.json", json.dumps([row.plain() for row in rows], indent=1, allow_nan=False) + "\n")
    _write(folder / "report.html", page(CASES, findings, identity))
    _tell(rows, folder)
    return 1 if any(row.ok is False for row in rows) else 0


def seeds_of(text: str | None) -> range:
    """The seeds of A:B, A to B - 1; by default those that count.

    Raises:
        UsageError: not two numbers, or none between them.
    """
    if text is None:
        return range(JUDGED_FROM, JUDGED_FROM + MOST)
    match = re.fullmatch(r"(\d+):(\d+)", text)
    if match is None or int(match[1]) >= int(match[2]):
        raise UsageError(f"--seeds {text}: write A:B with A below B, such as 0:40; B itself is not flown")
    return range(int(match[1]), int(match[2]))


def _tell(rows: list[Row], folder: Path) -> None:
    """A line for each case, and each target that was missed."""
    console = Console()
    table = Table("case", "met", "of", box=None)
    for name in dict.fromkeys(row.case for row in rows):
        judged = [row for row in rows if row.case == name and row.ok is not None]
        if judged:
            table.add_row(name, str(sum(bool(row.ok) for row in judged)), str(len(judged)))
    console.print(table)
    for row in rows:
        if row.ok is False:
            target = (
                f"in {row.target[0]:.4g} … {row.target[1]:.4g}"
                if isinstance(row.target, tuple)
                else f"≤ {row.target:g}"
            )
            console.print(
                f"missed: {row.case}: {row.figure}: {row.value:.4g}, wanted {target}", highlight=False, soft_wrap=True
            )
    console.print(f"{folder / 'report.html'}\n{folder / 'results.json'}", highlight=False, soft_wrap=True)


def _write(path: Path, text: str) -> None:
    """Whoever reads the file at any time finds the old one or the new one."""
    fresh = path.with_name(f"{path.name}.new")
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror}); choose another --out") from None
