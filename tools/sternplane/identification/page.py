"""identify.html: the estimated coefficients, their uncertainty, and how the filter found them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import plotly.graph_objects as go

from sternplane.identification.estimate import Identification
from sternplane.identification.recording import Recording
from sternplane.logs.run import Run
from sternplane.report.drawing import ESTIMATE, REFERENCE, TRUTH, Plot, line
from sternplane.report.page import Heading, Page, Section, Table, made_by, plot_section, render, rows_of

POINTS = 1500
"""So many are drawn of a line over time."""


def page(log: Run, recording: Recording, found: Identification, document: dict[str, Any]) -> str:
    """Return the page; `document` is what `results.result_document` made."""
    weak = [(f"{100.0 * one['sigma']:.2g} %", one["direction"]) for one in document["weak"]]
    events = [(f"{t:.2f} s", text) for t, text in log.sentences if document["from"] <= t <= document["to"]]
    directions = Table(rows_of(weak), style="log", caption="1 sigma of each, as a share of the values that were found.")
    sections: list[Section | Heading] = [
        Section("Coefficients", tables=(_coefficients(document),), wide=True),
        *(plot_section(plot) for plot in _plots(recording, found, document)),
        Section("Combinations of coefficients, the least known first", tables=(directions,)),
        Section("Residuals of maximum likelihood", tables=(_residuals(document),)),
        Section("Events", tables=(Table(rows_of(events or [("", "none")]), style="log"),)),
        Section("Made by", tables=(Table(made_by(log.header), style="log"),)),
    ]
    missing = "; ".join(document["not_identifiable"])
    return render(
        Page(
            title="Identification of the vehicle's coefficients",
            status="not all is identifiable" if missing else "identified",
            mood="bad" if missing else "good",
            description=" ".join(document["remarks"]),
            identity=(
                f"{document['log']} · {document['scenario']} · {document['from']:.2f} to {document['to']:.2f} s",
            ),
            warnings=(
                *((f"Not identifiable: {missing}.",) if missing else ()),
                *(f"Try: {remedy}." for remedy in document["remedies"]),
            ),
            key_figures={"": _key_figures(document)},
            sections=sections,
        )
    )


def _key_figures(document: dict[str, Any]) -> list[tuple[str, str]]:
    figures = [
        ("taken from", "maximum likelihood" if document["taken"] == "likelihood" else "the filter"),
        ("recorded", f"{document['to'] - document['from']:.1f} s"),
        ("turbulence", f"{document['turbulence']:.3f} m/s"),
        *((f"filter's NIS, {name}", f"{nis:.2f}") for name, nis in document["nis"].items()),
    ]
    if None not in document["current"]:
        north, east, north_std, east_std = document["current"]
        figures.append(("current north, 3 sigma", f"{north:.3f} ± {3.0 * north_std:.3f} m/s"))
        figures.append(("current east, 3 sigma", f"{east:.3f} ± {3.0 * east_std:.3f} m/s"))
    return figures


def _plots(recording: Recording, found: Identification, document: dict[str, Any]) -> Iterable[Plot]:
    names, size = list(found.names), found.sizes
    sure = [i for i, name in enumerate(names) if document["coefficients"][name]["identifiable"]]
    figure = go.Figure()
    known = {"filter": (found.filtered, ESTIMATE)}
    if found.white:
        known["maximum likelihood"] = (found.likelihood, REFERENCE)
    for title, (one, colour) in known.items():
        figure.add_scatter(
            x=[names[i] for i in sure],
            y=(100.0 * (one.values / found.taken.values - 1.0))[sure],
            error_y={"type": "data", "array": (300.0 * one.std / size)[sure], "thickness": 1.5},
            name=f"{title} ± 3 sigma",
            mode="markers",
            marker={"color": colour, "size": 7},
        )
    true = [(i, document["coefficients"][names[i]]["truth"]) for i in sure]
    figure.add_scatter(
        x=[names[i] for i, value in true if value is not None],
        y=[100.0 * (value / found.taken.values[i] - 1.0) for i, value in true if value is not None],
        name="truth",
        mode="markers",
        marker={"color": TRUTH, "symbol": "x", "size": 8},
    )
    figure.update_layout(scattermode="group", xaxis_title="coefficient")
    figure.update_yaxes(title="difference from the value taken, %")
    yield Plot("Estimates", "What is identifiable, over what is taken: + is larger in size.", figure, False)

    figure = go.Figure(go.Heatmap(x=names, y=names, z=document["correlation"], zmin=-1.0, zmax=1.0, colorscale="RdBu"))
    figure.update_yaxes(autorange="reversed")
    yield Plot("Correlation", "Of the errors of the estimate that is taken: −1 to 1.", figure, False)

    thin = slice(None, None, max(1, len(recording.inputs) // POINTS))
    t, first = recording.t[1:][thin], found.first
    figure = go.Figure()
    for i, name in enumerate(names):
        value, std = found.history.x[thin, first + i], found.history.std[thin, first + i]
        away, reach = 100.0 * (value / found.believed[i] - 1.0), 300.0 * std / abs(found.believed[i])
        figure.add_scatter(x=t, y=away, name=name, mode="lines", line={"width": 1.5}, customdata=reach,
                           hovertemplate="%{y:.2f} ± %{customdata:.2f} %")  # fmt: skip
    figure.update_layout(yaxis_title="difference from the vehicle file, %", xaxis_title="vehicle time, s")
    yield Plot(
        "The filter, as it learns",
        "Over what was believed: + is larger in size. Hover for the 3 sigma of each.",
        figure,
    )

    figure = go.Figure()
    for i, (name, colour) in enumerate((("delta_s", ESTIMATE), ("delta_r", REFERENCE))):
        line(figure, t, np.degrees(recording.inputs[thin, i]), name, colour)
    figure.update_layout(yaxis_title="fin angle, deg", xaxis_title="vehicle time, s")
    yield Plot("Excitation", "What stern planes and rudder did, by their own reports.", figure)


def _coefficients(document: dict[str, Any]) -> Table:
    head = ("", "vehicle file", "filter ± 3σ", "maximum likelihood ± 3σ", "widened", "truth", "in the new vehicle file")
    rows = []
    for name, one in document["coefficients"].items():
        both = [f"{known['value']:.6f} ± {3.0 * known['std']:.6f}" for known in (one["filter"], one["likelihood"])]
        if not one["likelihood"]["valid"]:
            both[1] += " (not valid)"
        true = "" if one["truth"] is None else f"{one['truth']:.6f}"
        kept = f"{one[document['taken']]['value']:.6f}" if one["identifiable"] else "as before: not identifiable"
        rows.append((name, f"{one['believed']:.6f}", *both, f"{one['likelihood']['widened']:.2f} ×", true, kept))
    return Table(rows, head, "All coefficients are nondimensional.", "numbers")


def _residuals(document: dict[str, Any]) -> Table:
    head = ("", "1 sigma (m/s, rad/s, rad)", "over the sensor's noise", "autocorrelation")
    rows = [
        (name, f"{one['std']:.3g}", f"{one['over_sensor']:.2f}", f"{one['autocorrelation']:.2f}")
        for name, one in document["residuals"].items()
    ]
    return Table(rows, head, style="numbers")
