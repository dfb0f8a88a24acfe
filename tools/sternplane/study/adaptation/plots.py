"""Plots of the adaptation study: one flight as it went, and all flights beside the oracle's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from sternplane.logs.tracking import Array
from sternplane.report.drawing import ESTIMATE, REFERENCE, TRUTH, Plot, line

COLOURS = {"oracle": TRUTH, "fixed": REFERENCE, "adaptive": ESTIMATE}


def one_flight(seed_text: str, errors: Mapping[str, Array]) -> list[Plot]:
    """Return the errors in depth and in heading against time.

    Args:
        seed_text: which flight it is.
        errors: design -> (n, 3): t, s; depth, m; heading, deg; not a number while no law steers.
    """
    plots = []
    for i, (quantity, unit) in enumerate((("Depth", "m"), ("Heading", "deg")), 1):
        figure = go.Figure()
        for name, rows in errors.items():
            line(figure, rows[:, 0], rows[:, i], name, COLOURS[name], 1.4)
        figure.update_layout(xaxis={"title": "t, s"}, yaxis={"title": f"true less reference, {unit}"})
        plots.append(Plot(f"{quantity} error, {seed_text}", "By the truth.", figure, height=260))
    return plots


def beside_oracle(what: str, ratios: Mapping[tuple[str, str], Sequence[float]]) -> Plot:
    """Return every flight's RMS error over that of the oracle in the same flight.

    Args:
        what: what the vehicle file has, for the title.
        ratios: (quantity, design) -> a number for each flight.
    """
    figure = go.Figure()
    for (quantity, name), values in ratios.items():
        figure.add_box(
            y=np.asarray(values, np.float64).tolist(),
            name=f"{quantity}, {name}",
            boxpoints="all",
            jitter=0.4,
            pointpos=0.0,
            marker={"color": COLOURS[name], "size": 5},
            line={"width": 1},
            showlegend=False,
        )
    figure.add_hline(y=1.0, line={"color": TRUTH, "width": 1, "dash": "dash"})
    figure.update_yaxes(title="RMS error over the oracle's", type="log", exponentformat="power", dtick=1)
    note = "One point a flight; box: quartiles and median. At 1 a law does as well as one that knows the truth."
    return Plot(f"All flights, {what}", note, figure, over_time=False, height=300)
