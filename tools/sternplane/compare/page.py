"""The page of a comparison: who the runs are, what differs, their figures side by side, and overlaid plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sternplane.compare.compared_run import ComparedRun
from sternplane.compare.comparison import Comparison, Rows
from sternplane.compare.overlays import overlays
from sternplane.report.page import Cell, Heading, Page, Section, Table, plot_section, render


def comparison_page(comparison: Comparison) -> str:
    """Return the page as HTML."""
    runs = comparison.runs
    heads = ["", *(run.name for run in runs)]
    count = len(comparison.differences)
    page = Page(
        title="Comparison",
        status=f"{len(runs)} runs, {count} setting{'s' * (count != 1)} different" if count else f"{len(runs)} runs",
        mood="neutral",
        description=" · ".join(heads[1:]),
        warnings=comparison.warnings,
        sections=[*_sections(comparison, heads), *_plots(runs)],
        footnote="Lines are thinned for the screen; the figures use every cycle.",
    )
    return render(page)


def _sections(comparison: Comparison, heads: Sequence[str]) -> Iterator[Section | Heading]:
    who = (Table(comparison.identity, head=heads, style="words"),)
    yield Section("Runs", tables=who, wide=True, anchor="runs")
    rows: Rows = [[one.key, *one.values] for one in comparison.differences]
    notes = () if rows else ("No setting differs: neither of vehicle and autopilot nor of what was simulated.",)
    tables = (Table(rows, head=heads, style="words"),) if rows else ()
    yield Section("What differs", notes, tables=tables, wide=True, anchor="differences")
    table = Table(_grouped(comparison.figures), head=heads, style="words")
    yield Section("Key figures", tables=(table,), wide=True, anchor="figures")
    if comparison.common_figures:
        title = f"Accuracy over the first {comparison.shortest:.1f} s, which all have"
        yield Section(title, tables=(Table(comparison.common_figures, head=heads, style="words"),), wide=True)


def _grouped(figures: dict[str, Rows]) -> list[list[Cell | str]]:
    """Return the rows of all groups, each below its title."""
    found: list[list[Cell | str]] = []
    for title, rows in figures.items():
        found.append([Cell(title, "head", len(rows[0]))])
        found += [[*row] for row in rows]
    return found


def _plots(runs: Sequence[ComparedRun]) -> Iterator[Section | Heading]:
    yield Heading("Over each other", anchor="plots")
    group = ""
    for i, plot in enumerate(overlays(runs)):
        if plot.section and plot.section != group:
            group = plot.section
            yield Heading(group, anchor=group.lower())
        yield plot_section(plot, wide=i == 0 and not plot.tall)
