"""The report's plot of what the laws were designed from."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from sternplane.logs.adoption import design_states
from sternplane.logs.health_record import Timeline
from sternplane.logs.reading import Columns
from sternplane.report.design_plot import design_plot
from sternplane.report.drawing import Plot

from firmware_py.records.adoption import Refusal, Source


def columns(depth: list[int]) -> Columns:
    """Return four seconds of a run with these sources of the depth law."""
    n = len(depth)
    found = {"t": np.arange(float(n)), "adopted.caution": np.linspace(1.0, 0.0, n)}
    for law, source in (("depth", depth), ("heading", [0] * n)):
        refusal = [Refusal.NONE if i > 1 else Refusal.UNCERTAIN for i in range(n)]
        found |= {f"adopted.{law}.source": np.array(source), f"adopted.{law}.refusal": np.array([*map(int, refusal)])}
        found |= {f"adopted.{law}.authority": np.linspace(0.1, 0.2, n)}
    return found


def plotted(c: Columns) -> Plot | None:
    """Return the plot of a run that is drawn whole."""
    designs = {law: Timeline() for law in ("depth", "heading")}
    for law, timeline in designs.items():
        if (states := design_states(c, law)).size:
            timeline.add(c["t"], states, 1.0)
    return design_plot(c, designs, "Coefficients", go.Figure())


def test_it_says_what_each_law_came_from_and_when() -> None:
    sources = [Source.FILE, Source.LEARNED, Source.LEARNED, Source.NOMINAL]
    plot = plotted(columns([*map(int, sources)]))
    assert plot is not None
    told = "Depth law: vehicle file, first values 1.0 s, all of it 2.0 s, back to the vehicle file 3.0 s."
    assert told in plot.note
    assert [trace.name for trace in plot.figure.data] == [
        *("depth: fins, over the vehicle file", "heading: fins, over the vehicle file", "caution")
    ]
    np.testing.assert_allclose(plot.figure.data[0].y, [1.0, 4 / 3, 5 / 3, 2.0], rtol=1e-6)


def test_where_nothing_was_adopted_there_is_none() -> None:
    assert plotted(columns([0, 0, 0, 0])) is None
    assert plotted({"t": np.arange(4.0)}) is None
