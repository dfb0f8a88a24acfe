"""`sternplane log`: the events of a log, one a line, for people and for programs."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any, NamedTuple

from rich.table import Table
from rich.text import Text

from firmware_py.foreign_text import visible
from firmware_py.records.event import Severity
from firmware_py.records.event_text import sentences
from sternplane.logs.after_log import after_log
from sternplane.logs.reading import find
from sternplane.logs.run import Run
from sternplane.logs.streaming import stream
from sternplane.plain_console import PlainConsole

_STYLES = {
    **dict.fromkeys((Severity.EMERGENCY, Severity.ALERT, Severity.CRITICAL), "bold red"),
    Severity.ERROR: "red",
    Severity.WARNING: "yellow",
}
"""Of the severities that stand out in a terminal."""
_ROUNDED = 6
"""Digits behind the point to which a time, s, may be rounded."""
_UNKNOWN = "-"
"""In place of the severity of an event that no log has kept."""


class ListedEvent(NamedTuple):
    """One event: vehicle time, s; severity, None where it is not known; the sentence."""

    t: float
    severity: Severity | None
    text: str

    @property
    def severity_word(self) -> str | None:
        """Return the severity as a word."""
        return None if self.severity is None else self.severity.name.lower()

    def document(self) -> dict[str, Any]:
        """Return it for JSON: t_s, severity (None where it is not known), text."""
        return {"t_s": round(self.t, _ROUNDED), "severity": self.severity_word, "text": self.text}


def listed_events(log: Run) -> list[ListedEvent]:
    """Return all events of a flight, in their order; those after the log's end, where the disk was full, too."""
    logged = [
        ListedEvent(t, sentence.severity, sentence.text) for t, events in log.events for sentence in sentences(events)
    ]
    after = after_log(log)
    if after is None:
        return logged
    known = {(round(event.t, _ROUNDED), event.text) for event in logged}
    rest = [ListedEvent(t, None, text) for t, text in after.events if (round(t, _ROUNDED), text) not in known]
    return [*logged, *rest]


def command(options: argparse.Namespace) -> int:
    """`sternplane log LOG`: print the events; what of the log cannot be read is said beside them."""
    log = stream(find(options.log))
    events = listed_events(log)
    if options.json:
        document = {"log": str(log.path), "lost": log.lost, "events": [event.document() for event in events]}
        print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))
        return 0
    console = PlainConsole()
    if console.is_terminal:
        console.print(_table(events))
    else:
        for event in events:  # nobody can widen a pipe: a line each, however long
            print(f"{event.t:9.2f} s  {event.severity_word or _UNKNOWN:<9}  {visible(event.text)}")
    if not events:
        print("sternplane: the log has no events", file=sys.stderr)
    if log.lost:
        print(f"sternplane: the log is {log.lost}", file=sys.stderr)
    return 0


def _table(events: list[ListedEvent]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, header_style="dim")
    table.add_column("time, s", justify="right", no_wrap=True)
    table.add_column("severity", no_wrap=True)
    table.add_column("event", overflow="fold")
    for event in events:
        style = "" if event.severity is None else _STYLES.get(event.severity, "")
        table.add_row(f"{event.t:.2f}", Text(event.severity_word or _UNKNOWN, style=style), event.text)
    return table
