"""The section of a report on what the vehicle could do: at the beginning, at its worst and at the end."""

from __future__ import annotations

from collections.abc import Iterator

from sternplane.logs.manoeuvrability import FIGURES
from sternplane.logs.summary import Summary
from sternplane.report.page import Section, Table


def limits_section(summary: Summary) -> Iterator[Section]:
    """Yield the section, of a log that knows of limits."""
    limits = summary["limits"]
    if not limits:
        return
    rows = [[FIGURES[name], *(_text(name, value) for value in one.values())] for name, one in limits.items()]
    note = "By the coefficients in force and by what is known of each fin. Guidance, depth limit and checks go by it."
    table = Table(rows, head=("", "at the beginning", "at its worst", "at the end"), style="numbers")
    yield Section("Limits: what the vehicle can do", notes=(note,), tables=(table,), wide=True, anchor="limits")


def _text(name: str, value: float | None) -> str:
    if value is None:
        return "cannot turn" if name == "turn_radius_m" else "no limit"
    return f"{value:.3g}"
