"""The report's plot of what the laws were designed from."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from sternplane.logs.reading import Columns
from sternplane.report.design_plot import design_plot

from firmware_py.records.adoption import Source


def columns(depth: list[int]) -> Columns:
    """Return four seconds of a run with these sources of the depth law."""
    n = len(depth)
    found = {"t": np.arange(float(n)), "adopted.caution": np.linspace(1.0, 0.0, n)}
    for law, source in (("depth", depth), ("heading", [0] * n)):
        found |= {f"adopted.{law}.source": np.array(source), f"adopted.{law}.authority": np.linspace(0.1, 0.2, n)}
    return found


def test_it_says_what_each_law_came_from_and_when() -> None:
    sources = [Source.FILE, Source.LEARNED, Source.LEARNED, Source.NOMINAL]
    plot = design_plot(columns([*map(int, sources)]), "Coefficients", go.Figure())
    assert plot is not None
    assert "Depth law: vehicle file, learned from 1.0 s, back to the vehicle file from 3.0 s." in plot.note
    assert [trace.name for trace in plot.figure.data] == [
        *("depth: fins, over the vehicle file", "heading: fins, over the vehicle file", "caution")
    ]
    np.testing.assert_allclose(plot.figure.data[0].y, [1.0, 4 / 3, 5 / 3, 2.0], rtol=1e-6)


def test_where_nothing_was_adopted_there_is_none() -> None:
    assert design_plot(columns([0, 0, 0, 0]), "Coefficients", go.Figure()) is None
    assert design_plot({"t": np.arange(4.0)}, "Coefficients", go.Figure()) is None
