"""The plots of a sweep: how its figures are distributed, and how success and error go with each key."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from sternplane.report.drawing import Plot
from sternplane.sweep.explain import Association, parts, success_interval
from sternplane.sweep.worst import Row

COLOURS = ("#2563eb", "#d97706", "#059669", "#9333ea", "#dc2626", "#0891b2")
_SHOWN = (
    ("path_error_rms_m", "Distance from the planned path, RMS", "m"),
    ("depth_tracking_error_rms_m", "Depth error, RMS", "m"),
    ("heading_tracking_error_rms_deg", "Heading error, RMS", "°"),
    ("navigation_error_end_m", "Position estimate off at the end", "m"),
    ("fin_travel_deg_s", "Fin travel", "°/s"),
    ("depth_max_m", "Greatest depth", "m"),
    ("vehicle_time_s", "Length of the flight", "s"),
)
_BINS = 24
_MOST_POINTS = 4000


def distributions(rows: Sequence[Row], judge: str) -> Iterator[Plot]:
    """Yield a histogram of each figure that varies, with a bar for each law, beside each other in every bin."""
    named = {name: (title, unit) for name, title, unit in _SHOWN}
    for name in dict.fromkeys([judge, *named]):
        by_law = _by_law(rows, name)
        every = np.concatenate([*by_law.values(), np.zeros(0)])
        if len(every) < 2 or float(np.ptp(every)) <= 0.0:
            continue
        title, unit = named.get(name, (name, ""))
        step = float(np.ptp(every)) / min(_BINS, math.ceil(math.sqrt(len(every))) + 1)
        figure = go.Figure()
        for (law, values), colour in zip(by_law.items(), COLOURS, strict=False):
            bins = {"start": float(every.min()), "end": float(every.max()) + step, "size": step}
            figure.add_histogram(x=values, name=law, xbins=bins, marker={"color": colour, "line": {"width": 0}})
        figure.update_layout(barmode="group", bargap=0.12, showlegend=len(by_law) > 1)
        figure.update_xaxes(title=f"{title}, {unit}" if unit else title)
        figure.update_yaxes(title="flights")
        yield Plot(title, f"{name}; {len(every)} flights have it.", figure, over_time=False)


def against(rows: Sequence[Row], key: str, judge: str) -> Iterator[Plot]:
    """Yield the share of completed flights against a key, and the figure that flights are judged by."""
    figure = go.Figure()
    rows = [row for row in rows if row[key] is not None]
    for law, colour in zip(_laws(rows), COLOURS, strict=False):
        found = parts([row for row in rows if row["law"] == law], key)
        share = [100.0 * part.completed / part.n for part in found]
        ends = [success_interval(part.completed, part.n, part.effect) for part in found]
        bars = {
            "type": "data",
            "symmetric": False,
            "array": [100.0 * high - value for (_, high), value in zip(ends, share, strict=True)],
            "arrayminus": [value - 100.0 * low for (low, _), value in zip(ends, share, strict=True)],
            "thickness": 1.2,
        }
        at, counts = [part.at for part in found], [f"{part.completed} of {part.n}" for part in found]
        pen = {"color": colour, "width": 1.5}
        figure.add_scatter(x=at, y=share, error_y=bars, name=law, text=counts, mode="lines+markers", line=pen)
    figure.update_xaxes(title=key)
    figure.update_yaxes(title="completed, %", range=[-4, 104])
    figure.update_layout(showlegend=len(_laws(rows)) > 1)
    note = "Groups of equally many flights by their values; bars are 95 % intervals of the share."
    yield Plot(f"Success against {key}", note, figure, over_time=False)
    if judge and any(row.get(judge) is not None for row in rows):
        yield _scatter(rows, key, judge)


def ranking(found: Mapping[str, Sequence[Association]]) -> Plot:
    """Return the rank correlation of each outcome with each key; what is between the lines may be chance."""
    figure = go.Figure()
    [first, *_] = found.values()
    keys = [one.key for one in first][::-1]
    for (outcome, those), colour in zip(found.items(), COLOURS, strict=False):
        rho = {one.key: one.rho for one in those}
        figure.add_bar(y=keys, x=[rho[key] for key in keys], name=outcome, orientation="h", marker={"color": colour})
    bound = max(one.bound for those in found.values() for one in those)
    for side in (-bound, bound) if bound < 1.0 else ():
        figure.add_vline(x=side, line={"color": "#64748b", "dash": "dash", "width": 1})
    figure.update_xaxes(title="rank correlation (Spearman)", range=[-1, 1])
    note = "Between the dashed lines chance alone would put all of them in 95 of 100 sweeps."
    height = 120 + 40 * len(keys) * len(found)
    return Plot("What goes with failures and errors", note, figure, over_time=False, height=height)


def _scatter(rows: Sequence[Row], key: str, judge: str) -> Plot:
    figure = go.Figure()
    every = max(1, -(-len(rows) // _MOST_POINTS))
    for law, colour in zip(_laws(rows), COLOURS, strict=False):
        own = [row for row in rows if row["law"] == law and row.get(judge) is not None][::every]
        for done, symbol in ((True, "circle"), (False, "x")):
            those = [row for row in own if bool(row["completed"]) is done]
            if those:
                style = {"color": colour, "size": 6, "symbol": symbol, "opacity": 0.7}
                name = f"{law}{'' if done else ', not completed'}"
                at = [str(row[key]) if isinstance(row[key], list) else row[key] for row in those]
                texts = [f"flight {row['flight']}" for row in those]
                figure.add_scatter(
                    x=at, y=[row[judge] for row in those], mode="markers", marker=style, name=name, text=texts
                )
    figure.update_xaxes(title=key)
    figure.update_yaxes(title=judge, rangemode="tozero")
    shown = f"Every {every}th flight." if every > 1 else "Each point is a flight; crosses were not completed."
    return Plot(f"{judge} against {key}", shown, figure, over_time=False)


def _laws(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["law"] for row in rows))


def _by_law(rows: Sequence[Row], name: str) -> dict[str, Any]:
    found = {
        law: np.array([float(row[name]) for row in rows if row["law"] == law and row.get(name) is not None])
        for law in _laws(rows)
    }
    return {law: values for law, values in found.items() if len(values)}
