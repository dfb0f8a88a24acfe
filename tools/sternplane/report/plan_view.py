"""The plan view of a flight: its track, the legs of its mission with their numbers, fence and rally points."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import plotly.graph_objects as go

from sternplane.logs.reading import Columns
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array
from sternplane.report import areas
from sternplane.report.drawing import ESTIMATE, PALE_ESTIMATE, REFERENCE, TRUTH, Plot, line
from sternplane.report.thinning import Drawn

_MOST_NUMBERS = 60
"""More waypoints than these are not all numbered."""
_AWAY_PX = 26.0
"""From a waypoint to its number."""
_WIDER = 1.5
"""A flight so many times as far to the east and west as to the north and south is seen in the whole width of a page."""


def plan_view(log: Run, drawn: Drawn) -> Plot:
    """North over east, with the legs of the mission that was flown last; waypoints lie above the track.

    Begin and end are where the vehicle truly was, where that is known.
    """
    c, truth, waypoints, figure = drawn.plan, drawn.plan_truth, drawn.mission.waypoints, go.Figure()
    track = truth or c
    if truth:
        line(figure, truth["eta.y"], truth["eta.x"], "truth", TRUTH, width=3)
    note = _estimate(figure, c)
    if len(waypoints):
        marker = {"size": 10, "symbol": "diamond", "color": REFERENCE, "line": {"color": "#ffffff", "width": 1.5}}
        legs: dict[str, Any] = {"dash": "dot", "mode": "lines+markers", "marker": marker}
        line(figure, waypoints[:, 1], waypoints[:, 0], "legs", REFERENCE, **legs)
        _number(figure, waypoints[:, :2], np.array([[track[f"eta.{axis}"][0] for axis in "xy"]]))
    for name, at, symbol in (("begin", 0, "circle"), ("end", -1, "square")):
        marker = {"size": 10, "symbol": symbol, "color": TRUTH}
        x, y = track["eta.y"][at : at + 1 or None], track["eta.x"][at : at + 1 or None]
        figure.add_scatter(x=x, y=y, name=name, mode="markers", marker=marker)
    wide = is_wide(np.column_stack((c["eta.x"], c["eta.y"])), waypoints[:, :2])
    figure.update_xaxes(title="east, m")
    figure.update_yaxes(title="north, m", scaleanchor="x", scaleratio=1)
    beyond = " The fence or a rally point is beyond the plot." if areas.draw(figure, log) else ""
    return Plot("Plan view", f"Local frame; scales are equal.{note}{beyond}", figure, over_time=False, tall=not wide)


def _estimate(figure: Any, c: Columns) -> str:
    """Draw the estimated track, and what fixes put right of it as no way that it went; return a sentence on that."""
    north, east, jumps = c["eta.x"], c["eta.y"], np.flatnonzero(np.diff(c["jumps"])) + 1
    line(figure, np.insert(east, jumps, np.nan), np.insert(north, jumps, np.nan), "estimate", ESTIMATE)
    if not jumps.size:
        return ""
    ends, gap = (jumps - 1, jumps), np.full(len(jumps), np.nan)
    x, y = (np.column_stack((*(values[at] for at in ends), gap)).ravel() for values in (east, north))
    line(figure, x, y, "estimate, put right by fixes", PALE_ESTIMATE, dash="dot")
    size = float(np.hypot(*(values[jumps] - values[jumps - 1] for values in (north, east))).max())
    if len(jumps) == 1:
        return f" At {c['t'][jumps[0]]:.1f} s a fix put the estimate right by {size:.0f} m (dotted)."
    return f" Fixes put the estimate right by up to {size:.0f} m (dotted), first at {c['t'][jumps[0]]:.1f} s."


def is_wide(*places: Array) -> bool:
    """Return whether places (n, 2), north and east, want a wide plot rather than a tall one."""
    spans = np.ptp(np.vstack(places), axis=0)
    return bool(spans[1] > _WIDER * spans[0])


def _number(figure: Any, places: Array, begin: Array) -> None:
    """Number waypoints (n, 2), each on the outer side of the corner there, where no leg and no track is."""
    path = np.vstack((begin, places))
    step = math.ceil(len(places) / _MOST_NUMBERS)
    for i in range(0, len(places), step):
        north, east = _outside(path, i + 1)
        figure.add_annotation(
            x=float(places[i, 1]),
            y=float(places[i, 0]),
            ax=_AWAY_PX * east,
            ay=-_AWAY_PX * north,
            text=f"<b>{i + 1}</b>",
            font={"size": 13, "color": "#334155"},
            bgcolor="#ffffff",
            bordercolor=REFERENCE,
            borderpad=2,
            arrowcolor=REFERENCE,
            arrowwidth=1,
            arrowhead=0,
            standoff=5,
        )


def _outside(path: Array, i: int) -> tuple[float, float]:
    """Return the direction, north and east, that points away from both legs at a corner of a path, (n, 2)."""
    here = path[i]
    back, on = _unit(path[i - 1] - here), _unit(path[i + 1] - here) if i + 1 < len(path) else np.zeros(2)
    away = -(back + on)
    if i + 1 == len(path) or np.hypot(*away) < 0.05:  # beside a straight way, to the right of it
        away = np.array((back[1], -back[0])) if back.any() else np.array((1.0, 0.0))
    north, east = _unit(away)
    return float(north), float(east)


def _unit(vector: Array) -> Array:
    length = float(np.hypot(*vector))
    return vector / length if length > 0.0 else np.zeros(2)
