"""The plot of how late the cycles of a run began."""

from __future__ import annotations

import itertools

import numpy as np
import plotly.graph_objects as go

from sternplane.logs import lateness_histogram
from sternplane.report.drawing import ESTIMATE, REFERENCE, Plot

_PROMPT_US = 0.7
"""Where the bar of the cycles less than 1 us late begins; a logarithmic axis has no 0."""


def histogram(late: lateness_histogram.LatenessHistogram, step_us: float) -> Plot:
    """Both axes are logarithmic: the one cycle in a million that is late is what it is drawn for."""
    edges = np.maximum(late.edges_us, _PROMPT_US)
    ranges = itertools.pairwise(map(lateness_histogram.with_unit, late.edges_us))
    figure = go.Figure()
    figure.add_bar(
        x=(edges[1:] + edges[:-1]) / 2.0,
        y=late.counts,
        width=np.diff(edges),
        name="cycles",
        customdata=[f"{low} to {high}" for low, high in ranges],
        hovertemplate="%{customdata}: %{y} cycles<extra></extra>",
        marker={"color": ESTIMATE, "line": {"color": "#ffffff", "width": 1}},
    )
    top = [0.5, 2.0 * max(late.counts)]
    step = {"color": REFERENCE, "dash": "dash"}
    figure.add_scatter(x=[step_us] * 2, y=top, name="one step", mode="lines", line=step, hoverinfo="name")
    decades = [10.0**i for i in range(9)]
    texts = [lateness_histogram.with_unit(us) for us in decades]
    figure.update_xaxes(title="time after the deadline", type="log", tickvals=decades, ticktext=texts)
    figure.update_yaxes(title="cycles", type="log", dtick=1, exponentformat="none", range=np.log10(top).tolist())
    half, p99, p999, latest = map(
        lateness_histogram.with_unit, (late.median_us, late.p99_us, late.p999_us, late.max_us)
    )
    note = f"Half of the cycles within {half}, 99 % within {p99}, 99.9 % within {p999}, the latest {latest}; "
    slips = f"{late.slips} of {sum(late.counts)} slipped by more than a step."
    return Plot("Lateness", note + slips, figure, over_time=False)
