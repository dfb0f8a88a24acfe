"""`sternplane compare`: several runs in one page and one table."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.run.usage_error import UsageError
from sternplane.cli import extras
from sternplane.compare.compared_run import open_runs
from sternplane.compare.comparison import Comparison, Rows
from sternplane.logs.summary_text import LABEL_WIDTH
from sternplane.plain_console import PlainConsole

_PAGE = Path("compare.html")
_MOST_DIFFERENCES = 30
"""So many settings that differ are printed; the page and --json have all of them."""

_KEY_WIDTH = LABEL_WIDTH
"""Of the keys that differ in a terminal: of a longer one the end stays, which tells it from others."""
_UNBOUNDED = 10_000
"""Columns of what is no terminal."""


def command(options: argparse.Namespace) -> int:
    """Print what differs and the key figures, and write the page."""
    if options.out is not None:
        _refuse_no_page(options.out)
    comparison = Comparison(open_runs(options.runs, lambda text: print(text, file=sys.stderr)))
    out = options.out or (None if options.json else _PAGE)
    drawn = out is not None and not extras.missing()
    if out is not None and drawn:
        _write(comparison, out)
    if options.json:
        print(json.dumps(comparison.document(), indent=2, ensure_ascii=False, allow_nan=False))
        return 0
    console = PlainConsole()
    if not console.is_terminal:
        console = PlainConsole(width=_UNBOUNDED)  # nobody can widen a file or a pipe
    _print(comparison, console)
    if drawn:
        console.print(f"  {out}", highlight=False, soft_wrap=True)
    else:
        console.print(f"  no page without {', '.join(extras.missing())}: {extras.HINT}", highlight=False, markup=False)
    return 0


def _refuse_no_page(out: Path) -> None:
    """Refuse what is no page: a log, a device, a FIFO would be gone."""
    if out.suffix != ".html":
        raise UsageError(f"--out {out}: is a page; write FILE.html")
    if os.path.lexists(out) and not out.is_file():
        raise UsageError(f"--out {out}: is not a regular file; choose another file")


def _write(comparison: Comparison, out: Path) -> None:
    from sternplane.compare.page import comparison_page

    page = comparison_page(comparison)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(out, page.encode())
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({error.strerror}); choose another file") from None


def _ended(key: str, most: int) -> str:
    """Return the end of a key that is longer than `most` characters."""
    return key if len(key) <= most else f"…{key[1 - most :]}"


def _print(comparison: Comparison, console: Console) -> None:
    names = [run.name for run in comparison.runs]
    most = _KEY_WIDTH if console.is_terminal else _UNBOUNDED
    different: Rows = [[_ended(one.key, most), *one.values] for one in comparison.differences]
    left_out = len(different) - _MOST_DIFFERENCES
    groups = {
        "runs": comparison.identity,
        "what differs": different[:_MOST_DIFFERENCES] or [["nothing", *[""] * len(names)]],
        **comparison.figures,
    }
    if comparison.common_figures:
        groups[f"accuracy over the first {comparison.shortest:.1f} s"] = comparison.common_figures
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    table.add_column("", no_wrap=True)
    for name in names:
        table.add_column(name, overflow="fold")
    for title, rows in groups.items():
        table.add_row(Text(title, style="dim"))
        for label, *values in rows:
            table.add_row(f"  {label}", *values)
        if rows is groups["what differs"] and left_out > 0:
            table.add_row(f"  and {left_out} more: see the page")
    console.print(table)
    for warning in comparison.warnings:
        console.print(f"  {warning}", highlight=False, markup=False, style="yellow")
