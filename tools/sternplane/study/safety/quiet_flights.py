"""The flights without a fault on the page: what they said all the same, and the commands that fly them again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from sternplane.report.page import Cell, Section, Table
from sternplane.study.safety.campaign import QUIET_FLIGHTS, Job
from sternplane.study.safety.columns import COLUMN_OF, words
from sternplane.study.safety.flight_list import commands
from sternplane.study.safety.judge import Ending
from sternplane.study.safety.verdict import is_alarmed, is_unsafe, water_text

_HEAD = ("water", "flights", "of, s", "with a false alarm", "unsafe", "worst error of depth, m", "flown again by")
_ALARMS_HEAD = ("seed", "what was said or done without cause", "log", "flown again by")


def quiet_section(flights: Sequence[Mapping[str, Any]], settings: Sequence[str]) -> Section | None:
    """Return what became of the flights without a fault, None if there is none among these."""
    quiet = sorted((flight for flight in flights if not flight["trial"]), key=lambda flight: flight["seed"])
    if not quiet:
        return None
    lines = []
    for eddies in sorted({flight["eddies"] for flight in quiet}):
        those = [flight for flight in quiet if flight["eddies"] == eddies]
        alarms, unsafe = sum(map(is_alarmed, those)), sum(map(is_unsafe, those))
        lines.append(
            (
                water_text(eddies),
                str(len(those)),
                f"{max(flight['found']['t_end'] for flight in those):.0f}",
                Cell(str(alarms), "bad" if alarms else "good"),
                Cell(str(unsafe), "bad" if unsafe else "good"),
                f"{max(flight['found']['depth_error'] for flight in those):.2f}",
                _again(those[0], settings),
            )
        )
    tables = [Table(lines, _HEAD)]
    if wrong := [flight for flight in quiet if is_alarmed(flight) or is_unsafe(flight)]:
        tables.append(Table([_line(flight, settings) for flight in wrong], _ALARMS_HEAD))
    return Section(
        "Flights without a fault",
        (
            "Turns and changes of depth, with sensors at twice their stated noise. Whatever is said of a sensor or an "
            "actuator here, and whatever a rule does, is a false alarm. The commands fly the first of each line again; "
            "for another choose its seed.",
        ),
        tables=tables,
        wide=True,
        anchor="quiet",
    )


def _line(flight: Mapping[str, Any], settings: Sequence[str]) -> tuple[str, ...]:
    found = flight["found"]
    marks = [(t, f"{name} {words(kind)}") for t, name, kind in found["said"]]
    marks += [(t, f"rule: {words(cause)}") for t, cause in found["rules"]]
    parts = [f"{text} at {t:g} s" for t, text in sorted(marks)]
    if is_unsafe(flight):
        parts.append(f"unsafe: {COLUMN_OF[Ending(flight['ending'])].head}")
    return str(flight["seed"]), ", ".join(parts), flight["log"] or "–", _again(flight, settings)


def _again(flight: Mapping[str, Any], settings: Sequence[str]) -> Markup:
    return Markup("<pre>{}</pre>").format(commands(Job("", -1, flight["seed"]), QUIET_FLIGHTS, QUIET_FLIGHTS, settings))
