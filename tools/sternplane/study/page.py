"""The study as a page: the rows of each case with target, number of seeds and margin, and its plots."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from firmware_py.estimation.coefficient_params import TEN
from sternplane.report.page import Cell, Heading, Page, Section, Table, plot_section, render
from sternplane.study.rows import Results, Row, Study

_STATE = {True: "good", False: "bad", None: ""}
_COLUMNS = len(TEN) + 4
"""Of a table: the figure, the ten, target, number of seeds, margin."""


def page(study: Study, results: Sequence[Results], identity: Sequence[str]) -> str:
    """Return the report as HTML."""
    sections: list[Section | Heading] = []
    for case, result in zip(study.cases, results, strict=True):
        title = case.name[:1].upper() + case.name[1:]
        notes = (case.about, *result.notes)
        sections.append(Section(title, notes, tables=(_table(title, result.rows),), wide=True))
        sections += [plot_section(plot) for plot in result.plots]
    rows = [row for result in results for row in result.rows]
    missed, judged = sum(row.ok is False for row in rows), sum(row.ok is not None for row in rows)
    return render(
        Page(
            title=study.title,
            status=f"{judged - missed} of {judged} targets met",
            mood="bad" if missed else "good",
            description=study.description,
            identity=(
                *identity,
                "Green meets its target, red misses it; the rest is for information. n: seeds; a row without is the "
                "same in every study. Margin: what is left to the target, in % of it (in % of half a band).",
            ),
            sections=sections,
        )
    )


def target_text(row: Row) -> str:
    """Return a row's target as text."""
    if row.target is None:
        return ""
    if isinstance(row.target, tuple):
        return f"{row.target[0]:.4g} … {row.target[1]:.4g}"
    return f"≤ {row.target:.3g}"


def _table(title: str, rows: Sequence[Row]) -> Table:
    return Table([*_lines(title, rows)], style="numbers")


def _lines(title: str, rows: Sequence[Row]) -> Iterator[list[Cell]]:
    """Yield the lines of a table. A figure of each of the ten is one line with ten columns.

    The name of each case stands above its rows, unless it is the `title` of the section.
    """
    cases = {row.case for row in rows}
    for case, found in itertools.groupby(rows, lambda row: row.case):
        if len(cases) > 1 or case.lower() != title.lower():
            yield [Cell(case, "head", _COLUMNS)]
        of_case = [*found]
        headed = not any(_figure(row) != row.figure for row in of_case)
        if headed:
            words = ("target", "n", "margin")
            yield [Cell(""), Cell("value", "head"), Cell("", span=len(TEN) - 1), *[Cell(w, "head") for w in words]]
        for figure, group in itertools.groupby(of_case, _figure):
            same = list(group)
            if len(same) != len(TEN):
                for row in same:
                    yield [Cell(row.figure), _value(row), Cell("", span=len(TEN) - 1), *_judgement([row])]
                continue
            if not headed:
                yield [Cell(text, "head") for text in ("", *TEN, "target", "n", "margin")]
                headed = True
            yield [Cell(figure), *map(_value, same), *_judgement(same)]
            if len({row.target for row in same}) > 1:
                yield [Cell("target", "note"), *(Cell(target_text(row), "note") for row in same), Cell("", span=3)]


def _judgement(rows: Sequence[Row]) -> list[Cell]:
    """The common target, the number of seeds, and the least margin."""
    targets = {target_text(row) for row in rows}
    margins = [row.margin for row in rows if row.margin is not None]
    target = targets.pop() if len(targets) == 1 else "each below"
    margin = f"{100.0 * min(margins):.0f} %" if margins else ""
    return [Cell(target, "note"), Cell(str(rows[0].n or ""), "note"), Cell(margin, "note")]


def _figure(row: Row) -> str:
    """The figure without the coefficient's name behind it."""
    figure, _, name = row.figure.rpartition(", ")
    return figure if name in TEN else row.figure


def _value(row: Row) -> Cell:
    """Within a narrow band the fourth place decides."""
    return Cell(f"{row.value:.4f}" if isinstance(row.target, tuple) else f"{row.value:.3g}", _STATE[row.ok])
