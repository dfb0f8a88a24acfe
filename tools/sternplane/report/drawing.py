"""What the plots of a report are drawn with: a plot, its colours, lines, bands and the height of its axis."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sternplane.logs.tracking import Array

TRUTH, ESTIMATE, REFERENCE = "#0f172a", "#2563eb", "#f59e0b"
PALE_ESTIMATE = "#60a5fa"
"""Of an estimate that is known to rest on nothing."""
COLOURS = ("#2563eb", "#dc2626", "#059669", "#9333ea", "#d97706", "#0891b2", "#be185d", "#4d7c0f")
"""Of what is of one kind: fins, runs."""


class Plot(NamedTuple):
    """A figure with its title and a sentence on what is in it; `over_time` if its x axis is the vehicle's time.

    Plots of one `section` stand together under that heading. `height`: in pixels; None is that of the page. `tall`: it
    is better seen in half the width and the height of two others than in the whole width.
    """

    title: str
    note: str
    figure: Any
    over_time: bool = True
    section: str = ""
    height: int | None = None
    tall: bool = False


def line(
    figure: Any, x: Array, y: Array, name: str, colour: str, width: float = 1.8, dash: str = "solid", **other: Any
) -> None:
    """A line; none where there is not one number."""
    if not np.isfinite(y).any():
        return
    other = {"mode": "lines", **other}
    pen = {"color": colour, "width": width, "dash": dash}
    figure.add_scatter(x=x.astype(np.float32), y=y.astype(np.float32), name=name, line=pen, **other)


def band(figure: Any, t: Array, low: Array, high: Array, name: str, colour: str = ESTIMATE) -> None:
    """What is between two lines, shaded: an area for each stretch in which both are known, and nothing in between.

    A fill from one line to the next would be drawn across what is not known.
    """
    known = np.isfinite(low) & np.isfinite(high)
    edges = np.flatnonzero(np.diff(known, prepend=False, append=False)).reshape(-1, 2)
    if not edges.size:
        return
    gap, outlines = np.full((1, 2), np.nan), []
    for begin, end in edges:
        there, back = (np.column_stack((t[begin:end], y[begin:end])) for y in (high, low))
        outlines += [gap, there, back[::-1]]
    x, y = np.vstack(outlines)[1:].astype(np.float32).T
    fill = {"fill": "toself", "fillcolor": f"rgba({rgb(colour)}, 0.15)"}
    figure.add_scatter(x=x, y=y, name=name, mode="lines", line={"width": 0}, hoverinfo="skip", **fill)


def rgb(colour: str) -> str:
    """Return the parts of a colour such as "#2563eb" as CSS lists them."""
    return ", ".join(str(int(colour[i : i + 2], 16)) for i in (1, 3, 5))


def minimum_height(figure: Any, height: float) -> None:
    """Makes the y axis at least this high, so that what hardly moves looks like it."""
    ends = [(np.nanmin(trace.y), np.nanmax(trace.y)) for trace in figure.data if trace.visible is None]
    if not ends:
        return
    low, high = float(min(low for low, _ in ends)), float(max(high for _, high in ends))
    if high - low < height:
        middle = 0.5 * (low + high)
        figure.update_yaxes(autorangeoptions={"include": [middle - 0.5 * height, middle + 0.5 * height]})
