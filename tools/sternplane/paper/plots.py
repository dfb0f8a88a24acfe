"""The figures on the page, by plotly."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go

from sternplane.paper.figures import Panel
from sternplane.report.drawing import Plot


def plot(panel: Panel) -> Plot:
    """Return the plot of a pair (or three) of axes."""
    figure = go.Figure()
    for line in panel.lines:
        colour, width, dash = line.style
        pen = {"color": colour, "width": width, "dash": dash}
        if line.z is None:
            figure.add_scatter(x=line.x.tolist(), y=line.y.tolist(), name=line.name, mode="lines", line=pen)
        else:
            x, y, z = line.x.tolist(), line.y.tolist(), line.z.tolist()
            figure.add_scatter3d(x=x, y=y, z=z, name=line.name, mode="lines", line={**pen, "width": 2.0 * width})
            dot = {"color": "#0f172a", "size": 4}
            figure.add_scatter3d(x=x[:1], y=y[:1], z=z[:1], name="start", mode="markers", marker=dot)
    if panel.lines[0].z is None:
        figure.update_layout(hovermode="x unified")
        figure.update_xaxes(title=panel.labels[0])
        figure.update_yaxes(title=panel.labels[1])
        if panel.log:
            figure.update_yaxes(type="log", exponentformat="power")
        if panel.downwards:
            figure.update_yaxes(autorange="reversed")
    else:
        names = zip(("xaxis", "yaxis", "zaxis"), panel.labels, strict=True)
        axes: dict[str, Any] = {name: {"title": {"text": label}} for name, label in names}
        axes["zaxis"]["autorange"] = "reversed"
        camera = {"eye": {"x": 1.7, "y": -1.8, "z": 0.8}, "center": {"x": 0.0, "y": 0.0, "z": -0.15}}
        figure.update_layout(scene={**axes, "aspectmode": "data", "camera": camera})
    return Plot(panel.title, "", figure, over_time=False)
