"""report.html: the figures and tables of the paper, flown again."""

from __future__ import annotations

import html
import json
import string
from collections.abc import Iterable, Mapping

import plotly.offline

from firmware_py.run import provenance
from sternplane.paper import differences, tables
from sternplane.paper.control import Flown
from sternplane.paper.design import Row
from sternplane.paper.estimation import Estimation
from sternplane.paper.figures import Figure
from sternplane.paper.plots import content
from sternplane.report.template import PAGE, POLICY

_STYLE = """<style>
  .heading { grid-column: 1 / -1; padding: 18px 4px 0; }
  .heading h2 { font-size: 20px; }
  .wide .plot { height: 460px; }
  .card p { margin: 8px 0; max-width: 110ch; }
  .card li { margin: 6px 0; max-width: 108ch; }
  .scroll { overflow-x: auto; }
  .numbers td, .numbers th { text-align: right; padding: 4px 8px; font-variant-numeric: tabular-nums; }
  .numbers th { font-weight: 600; font-size: 13px; vertical-align: bottom; color: var(--soft); }
  .numbers td:first-child, .numbers th:first-child { text-align: left; }
  .numbers td { white-space: nowrap; }
  .words th { text-align: left; font-size: 13px; color: var(--soft); }
  .yes { color: #166534; } .no { color: #991b1b; }
  nav a { margin-right: 16px; color: var(--accent); text-decoration: none; }
</style>"""
_BODY = """<header><h1>$title</h1><span class="verdict $mood">$verdict</span></header>
<p>J.-Y. Kim, “Controller Design for an Autonomous Underwater Vehicle Using Estimated Hydrodynamic Coefficients”, with
this project's plant, estimators, laws and simulator.</p>
<nav class="soft"><a href="#estimation">Estimation</a><a href="#design">Design</a><a href="#flights">Flights</a>
<a href="#differences">What differs, and why</a></nav>
<section class="figures">$figures</section>
<section class="plots">$cards</section>
<p class="soft" style="margin-top:14px">Drag to zoom, double-click to see all. The figures are beside this page as PNG
files, the numbers in results.json, and what was flown in vehicles and flights: <code>sternplane sitl --config
DIR/vehicles/smo --scenario paper-depth</code> flies it again.</p>
"""
_TEMPLATE = string.Template(
    PAGE.template.partition("<header>")[0] + _STYLE + _BODY + "</main>" + PAGE.template.rpartition("</main>")[2]
)
"""The frame of a flight's report, with another body."""


def page(
    found: Estimation, rows: list[Row], flown: Mapping[str, Mapping[str, Flown]], figures: Iterable[Figure]
) -> str:
    """The page, with all it needs inside."""
    plots: list[object] = []
    drawn = {figure.name: _figure(figure, plots) for figure in figures}
    cards = [
        _heading("Estimation (section 2)", "estimation"),
        drawn["fig3"],
        _card("Table 1: steady-state error", tables.table_1(found)),
        *(drawn[name] for name in ("fig4", "fig5", "fig6", "fig7", "excited")),
        _heading("Design (section 3)", "design"),
        _card("Eq. 27 to 33", tables.equations(rows)),
        _heading("Flights (section 4)", "flights"),
        drawn["fig9"],
        _card("Fig. 9 in figures", tables.flights(flown["fig9"])),
        drawn["fig10"],
        _card("Fig. 10 in figures", tables.flights(flown["fig10"])),
        _heading("What differs, and why", "differences"),
        *(_card(title, text) for title, text in differences.sections(found, rows, flown)),
        _card("Made by", tables.table((), _origin(), kind="words")),
    ]
    verdict, good = differences.verdict(found)
    return _TEMPLATE.substitute(
        policy=POLICY,
        title="The paper, flown again",
        verdict=html.escape(verdict),
        mood="good" if good else "bad",
        figures="".join(
            f"<div>{html.escape(words)}<b>{html.escape(value)}</b></div>" for words, value in _tiles(found, flown)
        ),
        cards="".join(cards),
        plotly=plotly.offline.get_plotlyjs(),
        plots=json.dumps(plots, separators=(",", ":")).replace("</", "<\\/"),
    )


def _figure(figure: Figure, plots: list[object]) -> str:
    """A heading, and a card for each pair of axes; what is drawn in them goes to `plots`."""
    cards = [
        f'<div class="heading"><h2>{html.escape(figure.title)}</h2><p class="soft">{html.escape(figure.note)}</p></div>'
    ]
    for panel in figure.panels:
        place = f"plot{len(plots)}"
        plots.append([place, *content(panel), False])
        wide = " wide" if panel.lines[0].z is not None else ""
        cards.append(
            f'<div class="card{wide}"><h2>{html.escape(panel.title)}</h2><div class="plot" id="{place}"></div></div>'
        )
    return "".join(cards)


def _tiles(found: Estimation, flown: Mapping[str, Mapping[str, Flown]]) -> list[tuple[str, str]]:
    errors = {who: [abs(error) for error in one.errors.values()] for who, one in found.learned.items()}
    settling = {who: tables.number(one.figures["settling_s"], "{:.1f} s") for who, one in flown["fig9"].items()}
    return [
        ("EKF, greatest error of the ten", f"{max(errors['ekf']):.2g} %"),
        ("SMO, constant L", f"{min(errors['smo']):.0f} to {max(errors['smo']):.0f} %"),
        ("SMO, weighted L, under PRBS", f"at most {max(errors['smo_prbs']):.2g} %"),
        ("1 m of depth, law from the EKF", settling["ekf"]),
        ("1 m of depth, law from the SMO", settling["smo"]),
        ("1 m of depth, PID", settling["pid"]),
    ]


def _heading(words: str, anchor: str) -> str:
    return f'<div class="heading" id="{anchor}"><h2>{html.escape(words)}</h2></div>'


def _card(title: str, text: str) -> str:
    return f'<div class="card wide"><h2>{html.escape(title)}</h2>{text}</div>'


def _origin() -> list[tuple[str, str]]:
    made = {"revision": provenance.git_revision(), **provenance.fingerprint(), **provenance.versions()}
    return [(name, str(value)) for name, value in made.items()]
