"""The study as a page, in the look of a run's report: rows with their verdicts, and plots."""

from __future__ import annotations

import html
import itertools
import json
import string
from collections.abc import Sequence
from typing import Any

import plotly.offline

from firmware_py.estimation.coefficient_params import TEN
from sternplane.report.template import PAGE, POLICY
from sternplane.study.rows import Case, Findings, Row

_HEAD, _, _REST = PAGE.template.partition("<main>")
_TAIL = _REST[_REST.index("</main>") :]
_MAIN = """<main>
<header><h1>$title</h1><span class="verdict $mood">$verdict</span></header>
<p>$description</p>
<p class="soft">$identity</p>
<section class="plots" style="margin-top:16px">$cards</section>
"""
_PAGE = string.Template(_HEAD + _MAIN + _TAIL)
_LAYOUT: dict[str, Any] = {
    "template": "none",
    "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#94a3b8", "activecolor": "#2563eb"},
    "margin": {"l": 64, "r": 12, "t": 30, "b": 42},
    "hovermode": "closest",
    "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
    "font": {"family": "system-ui, DejaVu Sans, sans-serif", "size": 12, "color": "#334155"},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
}
_AXIS = {"gridcolor": "#e2e8f0", "zerolinecolor": "#cbd5e1", "linecolor": "#cbd5e1", "ticks": "outside", "ticklen": 3}
_MOOD = {True: "good", False: "bad", None: ""}


def page(cases: Sequence[Case], findings: Sequence[Findings], identity: str) -> str:
    """The report as HTML, with all it needs inside."""
    cards: list[str] = []
    plots: list[list[Any]] = []
    for case, found in zip(cases, findings, strict=True):
        notes = "".join(f'<p class="soft">{html.escape(note)}</p>' for note in found.notes)
        title = html.escape(case.name[:1].upper() + case.name[1:])
        words = f'<h2>{title}</h2><p class="soft">{html.escape(case.about)}</p>{notes}'
        cards.append(f'<div class="card wide">{words}{_table(found.rows)}</div>')
        for plot in found.plots:
            figure = plot.figure
            figure.update_layout(_LAYOUT)
            figure.update_xaxes(_AXIS)
            figure.update_yaxes(_AXIS)
            name = f"plot{len(plots)}"
            about = f'<h2>{html.escape(plot.title)}</h2><p class="soft">{html.escape(plot.note)}&nbsp;</p>'
            cards.append(f'<div class="card">{about}<div class="plot" id="{name}"></div></div>')
            content = json.loads(figure.to_json())
            plots.append([name, content["data"], content["layout"], plot.over_time])
    rows = [row for found in findings for row in found.rows]
    missed, judged = sum(row.ok is False for row in rows), sum(row.ok is not None for row in rows)
    return _PAGE.substitute(
        policy=POLICY,
        title="Estimation study",
        verdict=f"{judged - missed} of {judged} targets met",
        mood="bad" if missed else "good",
        description="What the coefficient filter learns, beside the Cramér-Rao bound of what anybody can learn.",
        identity=html.escape(identity) + "<br>Green meets its target, red misses it; the rest is told for information.",
        cards="".join(cards),
        plotly=plotly.offline.get_plotlyjs(),
        plots=json.dumps(plots, separators=(",", ":")).replace("</", "<\\/"),
    )


def _table(rows: Sequence[Row]) -> str:
    """The case stands above its rows; what is told of each of the ten is one line with ten columns."""
    lines = []
    for case, of_case in itertools.groupby(rows, lambda row: row.case):
        lines.append(f'<tr><td colspan="{2 + len(TEN)}"><b>{html.escape(case)}</b></td></tr>')
        headed = False
        for what, group in itertools.groupby(of_case, _common):
            same = list(group)
            if len(same) == len(TEN):
                if not headed:
                    heads = "".join(f"<td><b>{name}</b></td>" for name in TEN)
                    lines.append(f"<tr><td></td>{heads}<td></td></tr>")
                    headed = True
                cells = "".join(f"<td>{_cell(row)}</td>" for row in same)
                targets = {row.target for row in same}
                common = _target(same[0]) if len(targets) == 1 else ""
                each = "" if len(targets) == 1 else "".join(f"<td class=soft>{_target(row)}</td>" for row in same)
                lines.append(f"<tr><td>{html.escape(what)}</td>{cells}<td>{common}</td></tr>")
                if each:
                    lines.append(f"<tr><td>its target</td>{each}<td></td></tr>")
            else:
                for row in same:
                    lines.append(
                        f"<tr><td>{html.escape(row.figure)}</td><td>{_cell(row)}</td>"
                        f'<td colspan="{len(TEN)}">{_target(row)}</td></tr>'
                    )
    return f"<table>{''.join(lines)}</table>"


def _common(row: Row) -> str:
    """The figure without the coefficient's name behind it."""
    what, _, name = row.figure.rpartition(", ")
    return what if name in TEN else row.figure


def _cell(row: Row) -> str:
    return f'<span class="{_MOOD[row.ok]}" style="padding:1px 6px;border-radius:6px">{_number(row)}</span>'


def _number(row: Row) -> str:
    """Within a narrow band the fourth place decides."""
    return f"{row.value:.4f}" if isinstance(row.target, tuple) else f"{row.value:.3g}"


def _target(row: Row) -> str:
    if row.target is None:
        return ""
    if isinstance(row.target, tuple):
        return f"{row.target[0]:.4g} … {row.target[1]:.4g}"
    return f"≤ {row.target:g}"
