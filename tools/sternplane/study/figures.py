"""Statistics, rows and plots that several cases share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from firmware_py.estimation.coefficient_params import TEN
from sternplane.logs.tracking import Array
from sternplane.report.drawing import ESTIMATE, REFERENCE, TRUTH, Plot
from sternplane.study.chance import K_SIGMA, chi_square_band, rms_band
from sternplane.study.rows import Row, RunArrays, Target

_LAST = 1.0
"""A run whose last time is nearer to its end than this, s, is whole."""
SENSORS = ("DVL", "gyro", "attitude")
COLOURS = ("#2563eb", "#dc2626", "#059669", "#9333ea", "#d97706", "#0891b2", "#be185d", "#4d7c0f", "#64748b", "#0f172a")


def final(runs: Sequence[RunArrays], duration: float, name: str = "error", of: str = "") -> Array:
    """Return what each run left at its end, (runs, ...); NaN where a run broke off.

    Args:
        runs: of one case.
        duration: of a whole run, s.
        name: of the array.
        of: what stands before the names of this filter's arrays, where a run has those of several.
    """
    ends = [run[of + name][-1] * (1.0 if run[f"{of}t"][-1] >= duration - _LAST else math.nan) for run in runs]
    return np.array(ends)


def longest(runs: Sequence[RunArrays], of: str = "") -> Array:
    """Return the times of the longest run, s; `of` as in `final`."""
    return max((run[f"{of}t"] for run in runs), key=len)


def over_runs(runs: Sequence[RunArrays], name: str = "error") -> Array:
    """Return an array of every run over its times, (runs, points, ...); NaN from where a run broke off."""
    parts = [run[name] for run in runs]
    points = max(map(len, parts))
    return np.array([np.concatenate((a, np.full((points - len(a), *a.shape[1:]), math.nan))) for a in parts])


def broke_off(case: str, *ends: Array) -> Row:
    """Return the row of the runs that broke off; `ends` are (runs, names), each as `final` returns it."""
    broken = ~np.all([np.isfinite(end).all(axis=1) for end in ends], axis=0)
    return Row(case, "runs that broke off", float(broken.sum()), 0.0)


def rms(values: Array) -> Array:
    """Over the runs, the first axis."""
    root: Array = np.sqrt(np.mean(values**2, axis=0))
    return root


def per_name(
    case: str,
    figure: str,
    values: Array,
    target: Target | Mapping[str, float],
    n: int = 0,
    names: Sequence[str] = TEN,
) -> list[Row]:
    """Return one row for each coefficient; `target` is one for all, or by name; n as in `Row`."""
    each = [target.get(name) if isinstance(target, Mapping) else target for name in names]
    return [Row(case, f"{figure}, {name}", float(v), t, n) for name, v, t in zip(names, values, each, strict=True)]


def over_bound(
    case: str, figure: str, error: Array, bound: Array, ratio: float = 1.0
) -> tuple[Array, tuple[float, float], list[Row]]:
    """Return the RMS of each coefficient's error over its bound, the band it is held in, and the rows.

    Args:
        case: of the rows.
        figure: of the rows.
        error: (seeds, names), as a part of the true value.
        bound: the same, 1 sigma. Where it differs from seed to seed fewer seeds count (Satterthwaite 1946).
        ratio: the filter's true ratio is 1 to `ratio`.
    """
    values: Array = rms(error) / rms(bound)
    squares = np.sum(bound**2, axis=0) ** 2 / np.sum(bound**4, axis=0)
    finite = bool(np.isfinite(squares).all())
    band = rms_band(max(round(float(np.min(squares))), 1), ratio) if finite else (math.nan, math.nan)
    return values, band, per_name(case, figure, values, band, len(error))


def correlation(a: Array, b: Array) -> Array:
    """Return the least correlation that a and b, (seeds, names), may have by `K_SIGMA`; not below 0 (Fisher 1921)."""
    if len(a) < 4:
        return np.zeros(a.shape[1])
    sample = np.abs(np.sum(a * b, axis=0)) / np.sqrt(np.sum(a**2, axis=0) * np.sum(b**2, axis=0))
    z = np.arctanh(np.minimum(sample, 1.0 - 1e-12)) - K_SIGMA / math.sqrt(len(a) - 3)
    least: Array = np.tanh(np.maximum(z, 0.0))
    return least


def bars(
    title: str, note: str, unit: str, series: Mapping[str, Array], lines: Sequence[float] = (), log: bool = False
) -> Plot:
    """A group of bars for each coefficient, lines across at what they are held against."""
    figure = go.Figure()
    for (name, values), colour in zip(series.items(), (ESTIMATE, REFERENCE, TRUTH, "#94a3b8"), strict=False):
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
    """NEES by degree of freedom, averaged over `over` runs, with its band of chance.

    Args:
        title: of the plot.
        note: below it.
        runs: name -> (t, NEES (runs, points), degrees of freedom).
        over: how many runs.
    """
    figure = go.Figure()
    for (name, (t, nees, freedom)), colour in zip(runs.items(), COLOURS, strict=False):
        figure.add_scatter(x=t, y=nees.mean(axis=0) / freedom, name=name, line={"color": colour})
        low, high = chi_square_band(freedom * over)
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
