"""`sternplane vehicle check`: what a vehicle can do, in words and in a table; exit status 1 if something is wrong."""

from __future__ import annotations

import argparse
from collections import Counter

from rich.table import Table
from rich.text import Text

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.foreign_text import visible
from firmware_py.run.usage_error import UsageError
from sternplane.cli.extras import require_report
from sternplane.plain_console import PlainConsole
from sternplane.vehicles.check import Checked, check
from sternplane.vehicles.finding import Grade
from sternplane.vehicles.limits import read_files

_STYLE = {Grade.PASS: "green", Grade.WARN: "yellow", Grade.FAIL: "bold red"}


def command(options: argparse.Namespace) -> int:
    """Check, and print; return 1 if something failed."""
    if options.picture is not None:
        require_report()
        if options.picture.suffix != ".html":
            raise UsageError(f"--picture {options.picture}: is a page; write FILE.html")
    files = read_files(options.config)
    found = check(files)
    console = PlainConsole(highlight=False)
    name = Text(visible(files.vehicle.name), style="bold")
    console.print(name, f"{files.vehicle.hull.length:g} m, by {options.config}", sep=", ")
    console.print(_findings(found))
    console.print(_abilities(found))
    console.print(verdict(found))
    if options.picture is not None:
        from sternplane.vehicles.check_page import page

        try:
            write_atomically(options.picture, page(files, found).encode())
        except OSError as error:
            raise UsageError(f"--picture {options.picture}: cannot be written ({error.strerror})") from None
        console.print(f"  {options.picture}", soft_wrap=True)
    return 1 if found.failed else 0


def verdict(found: Checked) -> str:
    """Return the outcome in a sentence."""
    count = Counter(finding.grade for finding in found.findings)
    said = f"{count[Grade.FAIL]} failed, {count[Grade.WARN]} to be thought over, {count[Grade.PASS]} good"
    return f"{said}: {'mend what failed first' if found.failed else 'it can be flown'}"


def _findings(found: Checked) -> Table:
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for finding in found.findings:
        table.add_row(Text(finding.grade.value, style=_STYLE[finding.grade]), finding.topic, finding.text)
    return table


def _abilities(found: Checked) -> Table:
    table = Table(title="what the vehicle can hold", title_justify="left", box=None, show_header=False, pad_edge=False)
    for what, figure in found.abilities:
        table.add_row(f"  {what}", figure)
    return table
