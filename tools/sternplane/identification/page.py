"""identify.html: what was found, to look at."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable
from typing import Any

import numpy as np
import plotly.graph_objects as go
import plotly.offline

from sternplane.identification.estimate import Answer
from sternplane.identification.recording import Recording
from sternplane.logs.reading import Log
from sternplane.report.drawing import BELIEVED, TRUE, WANTED, Plot, line
from sternplane.report.template import PAGE, POLICY

POINTS = 1500
"""So many are drawn of a line over time."""
_AXIS = {"gridcolor": "#e2e8f0", "zerolinecolor": "#94a3b8", "linecolor": "#cbd5e1", "ticks": "outside", "ticklen": 3}
_LAYOUT: dict[str, Any] = {
    "template": "none",
    "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#94a3b8", "activecolor": "#2563eb"},
    "margin": {"l": 56, "r": 12, "t": 30, "b": 42},
    "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
    "font": {"family": "system-ui, DejaVu Sans, sans-serif", "size": 12, "color": "#334155"},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
}


def page(log: Log, recording: Recording, found: Answer, told: dict[str, Any]) -> str:
    """The page, with all it needs inside."""
    cards, plots = [_card("Coefficients", _coefficients(told), wide=True)], []
    for i, (title, note, figure, over_time, *_) in enumerate(_drawn(recording, found, told)):
        figure.update_layout(_LAYOUT, hovermode="x unified" if over_time else "closest")
        figure.update_xaxes(_AXIS)
        figure.update_yaxes(_AXIS)
        cards.append(
            f'<div class="card"><h2>{html.escape(title)}</h2><p class="soft">{html.escape(note)}</p>'
            f'<div class="plot" id="plot{i}"></div></div>'
        )
        content = json.loads(figure.to_json())
        plots.append([f"plot{i}", content["data"], content["layout"], over_time])
    weak = [(f"{100.0 * one['sigma']:.2g} %", one["direction"]) for one in told["weak"]]
    cards.append(_card("Directions, the weakest first: 1 sigma, of what was found", _table(weak)))
    cards.append(_card("Residuals of maximum likelihood", _residuals(told)))
    lost = "; ".join(told["not_identifiable"])
    return PAGE.substitute(
        policy=POLICY,
        title="What the log says of the vehicle",
        verdict="identified" if not lost else "not all is identifiable",
        mood="good" if not lost else "bad",
        description=html.escape(" ".join(told["remarks"])),
        identity=html.escape(f"{told['log']} · {told['scenario']} · {told['from']:.2f} to {told['to']:.2f} s"),
        warning=f'<p class="warning">Not identifiable: {html.escape(lost)}.</p>' if lost else "",
        figures="".join(f"<div>{html.escape(a)}<b>{html.escape(b)}</b></div>" for a, b in _figures(told)),
        key="",
        cards="".join(cards),
        events=_table((f"{t:.2f} s", text) for t, text in log.events if told["from"] <= t <= told["to"]),
        origin=_table((log.header.get("machine", {}) | log.header.get("versions", {})).items()),
        thinned="",
        plotly=plotly.offline.get_plotlyjs(),
        plots=json.dumps(plots, separators=(",", ":")).replace("</", "<\\/"),
    )


def _figures(told: dict[str, Any]) -> list[tuple[str, str]]:
    said = [
        ("taken from", "maximum likelihood" if told["taken"] == "likelihood" else "the filter"),
        ("recorded", f"{told['to'] - told['from']:.1f} s"),
        ("turbulence", f"{told['turbulence']:.3f} m/s"),
        *((f"filter's NIS, {name}", f"{nis:.2f}") for name, nis in told["nis"].items()),
    ]
    if None not in told["current"]:
        north, east, north_std, east_std = told["current"]
        said.append(("current north, 3 sigma", f"{north:.3f} ± {3.0 * north_std:.3f} m/s"))
        said.append(("current east, 3 sigma", f"{east:.3f} ± {3.0 * east_std:.3f} m/s"))
    return said


def _drawn(recording: Recording, found: Answer, told: dict[str, Any]) -> Iterable[Plot]:
    names, size = list(found.names), found.sizes
    sure = [i for i, name in enumerate(names) if told["coefficients"][name]["identifiable"]]
    figure = go.Figure()
    known = {"filter": (found.filtered, BELIEVED)}
    if found.white:
        known["maximum likelihood"] = (found.likelihood, WANTED)
    for title, (one, colour) in known.items():
        figure.add_scatter(
            x=[names[i] for i in sure],
            y=(100.0 * (one.values / found.taken.values - 1.0))[sure],
            error_y={"type": "data", "array": (300.0 * one.std / size)[sure], "thickness": 1.5},
            name=f"{title} ± 3 sigma",
            mode="markers",
            marker={"color": colour, "size": 7},
        )
    true = [(i, told["coefficients"][names[i]]["truth"]) for i in sure]
    figure.add_scatter(
        x=[names[i] for i, value in true if value is not None],
        y=[100.0 * (value / found.taken.values[i] - 1.0) for i, value in true if value is not None],
        name="truth",
        mode="markers",
        marker={"color": TRUE, "symbol": "x", "size": 8},
    )
    figure.update_layout(scattermode="group", yaxis_title="off what is taken, %")
    yield Plot("Estimates", "What is identifiable, over what is taken: + is larger in size.", figure, False)

    figure = go.Figure(go.Heatmap(x=names, y=names, z=told["correlation"], zmin=-1.0, zmax=1.0, colorscale="RdBu"))
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
    figure.update_layout(yaxis_title="off what was believed, %", xaxis_title="vehicle time, s")
    yield Plot(
        "The filter, as it learns",
        "Over what was believed: + is larger in size. Hover for the 3 sigma of each.",
        figure,
    )

    figure = go.Figure()
    for i, (name, colour) in enumerate((("delta_s", BELIEVED), ("delta_r", WANTED))):
        line(figure, t, np.degrees(recording.inputs[thin, i]), name, colour)
    figure.update_layout(yaxis_title="fin angle, deg", xaxis_title="vehicle time, s")
    yield Plot("Excitation", "What stern planes and rudder did, by their own reports.", figure)


def _coefficients(told: dict[str, Any]) -> str:
    head = ("", "believed", "filter ± 3σ", "maximum likelihood ± 3σ", "widened", "truth", "in the vehicle file")
    rows = []
    for name, one in told["coefficients"].items():
        both = [f"{known['value']:.6f} ± {3.0 * known['std']:.6f}" for known in (one["filter"], one["likelihood"])]
        if not one["likelihood"]["valid"]:
            both[1] += " (not valid)"
        true = "" if one["truth"] is None else f"{one['truth']:.6f}"
        kept = f"{one[told['taken']]['value']:.6f}" if one["identifiable"] else "as believed: not identifiable"
        rows.append((name, f"{one['believed']:.6f}", *both, f"{one['likelihood']['widened']:.2f} ×", true, kept))
    return _table([head, *rows])


def _residuals(told: dict[str, Any]) -> str:
    head = ("", "1 sigma (m/s, rad/s, rad)", "over the sensor's noise", "autocorrelation")
    rows = (
        (name, f"{one['std']:.3g}", f"{one['over_sensor']:.2f}", f"{one['autocorrelation']:.2f}")
        for name, one in told["residuals"].items()
    )
    return _table([head, *rows])


def _card(title: str, body: str, wide: bool = False) -> str:
    return f'<div class="card{" wide" if wide else ""}"><h2>{html.escape(title)}</h2>{body}</div>'


def _table(rows: Iterable[Iterable[Any]]) -> str:
    cells = ("".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) for row in rows)
    return f"<table>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"
