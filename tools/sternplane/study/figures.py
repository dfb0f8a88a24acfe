"""Statistics and plots that several cases share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from firmware_py.estimation.coefficient_params import TEN
from sternplane.logs.tracking import Array
from sternplane.report.drawing import BELIEVED, TRUE, WANTED, Plot
from sternplane.study.rows import Numbers, Row

NORMAL_999 = 3.2905267314919255
"""Two-sided 99.9 % of the normal distribution."""
Target = float | tuple[float, float] | None
SENSORS = ("DVL", "gyro", "attitude")
COLOURS = ("#2563eb", "#dc2626", "#059669", "#9333ea", "#d97706", "#0891b2", "#be185d", "#4d7c0f", "#64748b", "#0f172a")


def band_999(freedom: float) -> tuple[float, float]:
    """The 99.9 % band of chi-square over its degrees of freedom (Wilson and Hilferty 1931; 1 % off at 80 of them)."""
    a = 2.0 / (9.0 * freedom)
    return max(1.0 - a - NORMAL_999 * math.sqrt(a), 0.0) ** 3, (1.0 - a + NORMAL_999 * math.sqrt(a)) ** 3


def final(runs: Sequence[Numbers], name: str = "error") -> Array:
    """(runs, ...): what each run left at its end; NaN where a run broke off."""
    rows = [run[name][-1] if run["t"][-1] >= runs[0]["t"][-1] else run[name][-1] * math.nan for run in runs]
    return np.array(rows)


def rms(values: Array) -> Array:
    """Over the runs, the first axis."""
    root: Array = np.sqrt(np.mean(values**2, axis=0))
    return root


def per_name(
    case: str, figure: str, values: Array, target: Target | Mapping[str, float], names: Sequence[str] = TEN
) -> list[Row]:
    """One row for each coefficient; `target` is one for all, or by name."""
    each = [target.get(name) if isinstance(target, Mapping) else target for name in names]
    return [Row(case, f"{figure}, {n}", float(v), t) for n, v, t in zip(names, values, each, strict=True)]


def bars(
    title: str, note: str, unit: str, series: Mapping[str, Array], lines: Sequence[float] = (), log: bool = False
) -> Plot:
    """A group of bars for each coefficient, lines across at what they are held against."""
    figure = go.Figure()
    for (name, values), colour in zip(series.items(), (BELIEVED, WANTED, TRUE, "#94a3b8"), strict=False):
        figure.add_bar(x=list(TEN), y=[float(v) for v in values], name=name, marker={"color": colour})
    for level in lines:
        figure.add_hline(y=level, line={"color": "#dc2626", "width": 1, "dash": "dash"})
    figure.update_layout(barmode="group", xaxis={"title": "coefficient"}, yaxis={"title": unit})
    if log:
        figure.update_yaxes(type="log", exponentformat="power", dtick=1)
    return Plot(title, note, figure, over_time=False)


def over_time(title: str, note: str, t: Array, error: Array, bound: Array | None = None) -> Plot:
    """RMS error of each coefficient, in %, against time, and the bound dashed; `error` is (runs, points, names)."""
    figure = go.Figure()
    for i, (name, colour) in enumerate(zip(TEN, COLOURS, strict=True)):
        curve = 100.0 * rms(error[:, :, i])
        figure.add_scatter(x=t, y=np.maximum(curve, 1e-9), name=name, line={"color": colour, "width": 1.6})
        if bound is not None:
            pen = {"color": colour, "width": 1.2, "dash": "dot"}
            shown = {"showlegend": False, "hoverinfo": "skip"}
            figure.add_scatter(x=t, y=100.0 * bound[:, i], name=f"bound {name}", line=pen, **shown)
    figure.update_layout(
        xaxis={"title": "t, s"}, yaxis={"title": "RMS error, %", "type": "log", "exponentformat": "power", "dtick": 1}
    )
    return Plot(title, note, figure)


def nees_over_time(title: str, note: str, runs: Mapping[str, tuple[Array, Array, int]], over: int) -> Plot:
    """NEES by degree of freedom, averaged over `over` runs, with its 99.9 % band.

    Args:
        title: of the plot.
        note: below it.
        runs: name -> (t, NEES (runs, points), degrees of freedom).
        over: how many runs.
    """
    figure = go.Figure()
    for (name, (t, nees, freedom)), colour in zip(runs.items(), COLOURS, strict=False):
        figure.add_scatter(x=t, y=nees.mean(axis=0) / freedom, name=name, line={"color": colour})
        low, high = band_999(freedom * over)
        for edge in (low, high):
            figure.add_scatter(
                x=[t[0], t[-1]],
                y=[edge, edge],
                mode="lines",
                line={"color": colour, "width": 1, "dash": "dot"},
                showlegend=False,
                hoverinfo="skip",
            )
    figure.update_layout(
        xaxis={"title": "t, s"},
        yaxis={"title": "NEES per degree of freedom", "type": "log", "exponentformat": "power", "dtick": 1},
    )
    return Plot(title, note, figure)
