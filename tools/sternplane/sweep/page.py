"""report.html of a sweep: how many flights succeeded, which were the worst, and what explains the failures."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from markupsafe import Markup

from sternplane.report.page import Cell, Heading, Page, Section, Table, environment, plot_section, render
from sternplane.sweep.accused import DAMAGED, accused
from sternplane.sweep.explain import FEWEST, Association, associations, design_effect, success_interval
from sternplane.sweep.laws import equal
from sternplane.sweep.plan import Flights
from sternplane.sweep.plots import against, distributions, ranking
from sternplane.sweep.worst import Row, badness, outcome_text, worst

_STATE = ("good", "", "bad", "bad")
_MOST_ACCUSED = 40
_FIGURES = ("path_error_rms_m", "depth_tracking_error_rms_m", "heading_tracking_error_rms_deg")
_BY_HAND = ("overshoot_first_deg", "overshoot_second_deg", "turning_diameter_m")
"""Figures of scenarios that move the fins themselves; they stand where any flight has them."""


def page(flights: Flights, rows: Sequence[Row], judge: str, folder: Path, most: int) -> str:
    """Return the report as HTML.

    Args:
        flights: of the sweep.
        rows: of all of them, in the order of their numbers.
        judge: the column that flights are judged by, the greater the worse; "" for none.
        folder: of the sweep, where the logs of the worst are.
        most: how many of the worst are shown.
    """
    plan, completed = flights.plan, sum(bool(row["completed"]) for row in rows)
    errors = sum(bool(row["error"]) for row in rows)
    keys = [axis.key for axis in plan.axes]
    each = f", each with {flights.each} flights" if flights.each > 1 else ""
    sailed = sum(row.get("vehicle_time_s") or 0.0 for row in rows)
    sections: list[Section | Heading] = [
        Section("Outcomes", tables=(_laws(rows), _outcomes(rows)), wide=True, anchor="outcomes"),
        *_accused(rows),
        Section(
            "Worst flights",
            (_worst_note(judge), _again_note(folder)),
            _worst(rows, keys, judge, folder, most),
            wide=True,
            anchor="worst",
        ),
        *_explained(flights, rows, judge),
        Heading("Distributions", anchor="distributions"),
        *[plot_section(plot) for plot in distributions(rows, judge)],
        *([Heading("Against what was varied", anchor="against")] if keys else []),
        *[plot_section(plot) for key in keys for plot in against(rows, key, judge)],
        Section("Set-up", tables=(_setup(flights),), wide=True, anchor="setup"),
    ]
    return render(
        Page(
            title=f"Sweep of {plan.scenario}",
            status=f"{completed} of {len(rows)} flights completed",
            mood="bad" if errors else "good" if completed == len(rows) else "warn",
            description=f"{_samples(flights, keys)}{each}.",
            identity=_identity(rows),
            warnings=[*_warnings(rows, errors)],
            key_figures={
                "": (
                    ("completed", f"{100.0 * completed / len(rows):.1f} %"),
                    ("came up safely", str(sum(badness(row) == 1 for row in rows))),
                    ("failed", str(sum(badness(row) == 2 for row in rows))),
                    ("errors", str(errors)),
                    ("with an actuator said to be damaged", str(_damaged(rows))),
                    ("vehicle time", f"{sailed / 3600.0:.1f} h" if sailed > 7200.0 else f"{sailed / 60.0:.0f} min"),
                )
            },
            sections=sections,
            footnote="flights.parquet has every row and figure.",
        )
    )


def _samples(flights: Flights, keys: Sequence[str]) -> str:
    n = len(flights.samples)
    of = f" of {', '.join(keys)}" if keys else ", of which nothing is varied"
    return f"{n} sample{'s' if n > 1 else ''}{of}"


def _identity(rows: Sequence[Row]) -> list[str]:
    """Return who flew them: more than one revision or processor is told."""
    revisions, cpus = (sorted({str(row[name]) for row in rows if name in row}) for name in ("revision", "cpu"))
    return [f"revision {', '.join(revisions)} · {', '.join(cpus)}"]


def _warnings(rows: Sequence[Row], errors: int) -> Iterator[str]:
    if errors:
        yield f"{errors} flights ended in an error, see the table of outcomes."
    if said := equal(rows):
        yield f"{said}."


def _laws(rows: Sequence[Row]) -> Table:
    lines = []
    names = [name for name in (*_FIGURES, *_BY_HAND) if any(row.get(name) is not None for row in rows)] or [*_FIGURES]
    for law in dict.fromkeys(row["law"] for row in rows):
        own = [row for row in rows if row["law"] == law]
        done = sum(bool(row["completed"]) for row in own)
        low, high = success_interval(done, len(own), design_effect(own))
        figures = [[row[name] for row in own if row.get(name) is not None] for name in names]
        share = f"{100.0 * done / len(own):.1f} % ({100.0 * low:.0f} … {100.0 * high:.0f})"
        lines.append([law, str(len(own)), str(done), share, *[f"{median(one):.3g}" if one else "–" for one in figures]])
    head = ("law", "flights", "completed", "share (95 %)", *[f"median {name}" for name in names])
    return Table(lines, head=head, style="numbers")


def _outcomes(rows: Sequence[Row]) -> Table:
    counts = Counter((badness(row), outcome_text(row)) for row in rows)
    lines = [
        [Cell(text, _STATE[bad]), str(n)] for (bad, text), n in sorted(counts.items(), key=lambda one: -one[1])[:20]
    ]
    return Table(lines, head=("how they ended", "flights"), style="numbers")


def _damaged(rows: Sequence[Row]) -> int:
    """Return in how many flights an actuator was said to be damaged."""
    return len({flight for one in accused(rows) if one.said == DAMAGED for flight in one.flights})


def _accused(rows: Sequence[Row]) -> Iterator[Section]:
    """Yield what flights said to be at fault, where any did."""
    found = accused(rows)
    if found:
        note = "Where no fault was injected, what was accused was sound."
        lines = [[one.said, one.name, str(len(one.flights)), _numbers(one.flights)] for one in found[:_MOST_ACCUSED]]
        table = Table(lines, head=("", "what", "flights", "their numbers"), style="numbers")
        yield Section("Said to be at fault", (note,), tables=(table,), wide=True, anchor="accused")


def _numbers(flights: Sequence[int], most: int = 12) -> str:
    return ", ".join(map(str, flights[:most])) + (", ..." if len(flights) > most else "")


def _worst_note(judge: str) -> str:
    then = f", then those of the greatest {judge}" if judge else ""
    return f"Errors first, then flights that failed, then those that came up safely{then}."


def _again_note(folder: Path) -> str:
    return (
        f"Any flight once more, with log and report: sternplane sweep --out {shlex.quote(str(folder))} --again FLIGHT"
    )


def _worst(rows: Sequence[Row], keys: Sequence[str], judge: str, folder: Path, most: int) -> Markup:
    lines = []
    for row in worst(rows, judge, most):
        place = f"worst/{row['flight']:06d}"
        files = {"report": f"{place}/report.html", "log": f"{place}/log.mcap"}
        lines.append(
            {
                **{name: row[name] for name in ("flight", "law", "seed")},
                "state": _STATE[badness(row)],
                "outcome": outcome_text(row),
                "figure": _text(row.get(judge)),
                "varied": [_text(row[key]) for key in keys],
                "links": [(name, file) for name, file in files.items() if (folder / file).exists()],
            }
        )
    made = environment(Path(__file__).parent)
    made.filters["head"] = _head
    return Markup(made.get_template("worst.html").render(rows=lines, keys=keys, judge=judge))


def _head(name: str) -> Markup:
    """Return a key or column as a heading that may end its line behind each dot and underscore."""
    return Markup("<wbr>").join(re.findall(r"[^._]+[._]?", name))


def _explained(flights: Flights, rows: Sequence[Row], judge: str) -> Iterator[Section]:
    """Yield what goes with failures, and with the figure that flights are judged by."""
    keys = [axis.key for axis in flights.plan.axes if axis.numeric]
    if not keys:
        return
    failed = {row["flight"]: float(not row["completed"]) for row in rows}
    outcomes = {"failure": failed}
    if judge:
        outcomes[judge] = {row["flight"]: float(row[judge]) for row in rows if row.get(judge) is not None}
    found = {name: associations(rows, keys, outcome, len(outcomes)) for name, outcome in outcomes.items()}
    notes = [_said(name, those) for name, those in found.items()]
    notes.append(
        "A rank correlation shows what goes steadily up or down with a key; what is worst at both ends, or depends on "
        "two keys at once, it does not. See the plots below."
    )
    plot = ranking(found)
    table = Table(
        [
            [name, one.key, f"{one.rho:+.2f}" if one.rho == one.rho else "–", _bound(one), _verdict(one), str(one.n)]
            for name, those in found.items()
            for one in those
        ],
        head=("outcome", "key", "rank correlation", "chance stays below", "", "samples"),
        style="numbers",
    )
    yield Section(plot.title, (*notes, plot.note), tables=(table,), plot=plot, wide=True, anchor="explained")


def _said(outcome: str, those: Sequence[Association]) -> str:
    """Return what may be said of an outcome in one sentence."""
    n = max(one.n for one in those)
    if n < FEWEST:
        return f"{outcome}: there are {n} samples; of fewer than {FEWEST} nothing is said."
    if not any(one.rho == one.rho for one in those):
        return f"{outcome}: it is the same in all samples, so that nothing can be said."
    beyond = [f"{one.key} ({one.rho:+.2f})" for one in those if one.beyond_chance]
    if not beyond:
        return f"{outcome}: nothing goes with it that could not be chance with {n} samples."
    return f"{outcome}: more than chance goes with it {', '.join(beyond)}."


def _bound(one: Association) -> str:
    return f"{one.bound:.2f}" if one.bound < 1.0 else "–"


def _verdict(one: Association) -> Cell:
    if one.n < FEWEST:
        return Cell(f"too few samples: at least {FEWEST}", "note")
    return Cell("beyond chance", "good") if one.beyond_chance else Cell("may be chance", "note")


def _setup(flights: Flights) -> Table:
    plan = flights.plan
    lines = [["scenario", plan.scenario]]
    for axis in plan.axes:
        span = ", ".join(map(_text, axis.choices)) if axis.choices else f"{axis.low:.6g} … {axis.high:.6g}"
        lines.append(["varied", f"{axis.key}: {span}{', even in the logarithm' if axis.log else ''}"])
    lines += [["set", text] for text in plan.settings]
    lines += [["fault", text] for text in plan.faults]
    lines.append(["laws", ", ".join(flights.laws)])
    form = f"Latin hypercube of {plan.n} samples" if plan.n else f"grid, {plan.grid} values of each range"
    lines.append(["samples", f"{form}, seed {plan.seed}" if plan.axes else f"{plan.n}, of which nothing is varied"])
    last = f"{plan.seed} + number of the sample"
    lines.append(
        ["seeds of flights", f"{plan.seeds[0]} to {plan.seeds[1] - 1}, each with every sample" if plan.seeds else last]
    )
    return Table(lines, style="log")


def _text(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else "–" if value is None else str(value)
