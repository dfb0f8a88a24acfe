"""The figures on the page, by plotly."""

from __future__ import annotations

import json
from typing import Any

import plotly.graph_objects as go

from sternplane.paper.figures import Panel

_AXIS = {"gridcolor": "#e2e8f0", "zerolinecolor": "#cbd5e1", "linecolor": "#cbd5e1", "ticks": "outside", "ticklen": 3}
_LAYOUT: dict[str, Any] = {
    "template": "none",
    "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#94a3b8", "activecolor": "#2563eb"},
    "margin": {"l": 64, "r": 12, "t": 30, "b": 42},
    "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
    "font": {"family": "system-ui, DejaVu Sans, sans-serif", "size": 12, "color": "#334155"},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
}


def content(panel: Panel) -> tuple[Any, Any]:
    """What plotly.js draws: (data, layout)."""
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
    figure.update_layout(_LAYOUT)
    if panel.lines[0].z is None:
        figure.update_layout(hovermode="x unified")
        figure.update_xaxes(_AXIS, title=panel.labels[0])
        figure.update_yaxes(_AXIS, title=panel.labels[1])
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
    drawn = json.loads(figure.to_json())
    return drawn["data"], drawn["layout"]
