"""`python -m sternplane.link_load`: cycles with three busy stations, under a flood, and with nobody there.

All three stations want more telemetry than a link carries. Meanwhile one fetches the list of parameters again and
again and sets twenty values a second, one fetches the log of the flight by MAVLink FTP, and one uploads a long mission
again and again. The flood is of datagrams that mean nothing, to one link.

All fly with the sea's options of real time, as far as this machine permits them.

Lateness is that of the machine, and of all that it does. What a cycle cost is the processor time of the flight's
thread: median, 99 %, 99.9 % and most.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
import tempfile
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from firmware_py.adapters import kernel_cache

_ROWS = (
    ("median_us", "lateness, median", "{:.0f} µs"),
    ("p99_us", "99 % within", "{:.0f} µs"),
    ("p999_us", "99.9 % within", "{:.0f} µs"),
    ("max_us", "greatest", "{:.0f} µs"),
    ("late_pct", "late by a step or more", "{:.4f} %"),
    ("cycles", "cycles", "{}"),
    ("changes", "changes adopted", "{}"),
    ("cpu_s", "processor time, start and report included", "{:.1f} s"),
    ("outcome", "outcome", "{}"),
)
_FLIGHTS = {"alone": "alone", "stations": "three stations", "flood": "flood"}


def main(arguments: list[str] | None = None) -> int:
    """Measure; return 0 if all flights and all stations did their work, 1 if not. Lateness is for people to judge."""
    parser = argparse.ArgumentParser(prog="python -m sternplane.link_load", description="Measures cycles under load.")
    parser.add_argument("--seconds", type=float, default=600.0, metavar="S", help="of each of the three flights [600]")
    parser.add_argument("--items", type=int, default=500, metavar="N", help="of each mission [500]")
    parser.add_argument("--flood", type=float, default=17_000.0, metavar="N", help="datagrams a second [17000]")
    parser.add_argument("--json", type=Path, metavar="FILE", help="leave the figures here too")
    options = parser.parse_args(arguments)
    if options.seconds < 5.0 or not 1 <= options.items <= 2000 or not 1.0 <= options.flood <= 1e6:
        parser.error("--seconds must be 5 or more, --items 1 to 2000, --flood 1 to 1000000")
    kernel_cache.use()
    from sternplane.link_load.flight import Problem, measure

    logging.disable(logging.CRITICAL)  # pymavlink's FTP client tells there what it tries again
    Console(stderr=True).print(f"flying three times, {options.seconds:g} s each", highlight=False)
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = measure(options.seconds, Path(folder), options.items, options.flood)
        except Problem as problem:
            print(f"load: {problem}", file=sys.stderr)
            return 1
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    _tell(found)
    return 0


def _tell(found: dict[str, Any]) -> None:
    console = Console()
    table = Table("", *_FLIGHTS.values(), box=None)
    for key, words, form in _ROWS:
        table.add_row(words, *(form.format(found[flight][key]) for flight in _FLIGHTS))
    table.add_section()
    for phase in found["alone"]["cost_ms"]:
        costs = (found[flight]["cost_ms"][phase] for flight in _FLIGHTS)
        table.add_row(f"{phase}, ms", *(" ".join(f"{cost:6.2f}" for cost in four) for four in costs))
    console.print(table)
    for name, counts in found["did"].items():
        words = ", ".join(f"{value:,} {key}" for key, value in counts.items())
        console.print(f"{name}: {words}", highlight=False, soft_wrap=True)
    console.print(json.dumps(found), highlight=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
