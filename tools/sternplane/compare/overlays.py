"""Plots of several runs over each other: one colour a run, the truth of each where it is known, else its estimate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go

from sternplane.compare.compared_run import ComparedRun
from sternplane.logs.learned import Coefficient, coefficients
from sternplane.logs.tracking import Array
from sternplane.report.drawing import COLOURS, TRUTH, Plot, line, minimum_height
from sternplane.report.plan_view import is_wide
from sternplane.report.thinning import Drawn

_MOST_POINTS = 3000
_COEFFICIENTS = "Coefficients"


class _Line(NamedTuple):
    """A run as it is drawn."""

    run: ComparedRun
    drawn: Drawn
    colour: str

    @property
    def t(self) -> Array:
        """Times of the points, s."""
        times: Array = self.drawn.c["t"].astype(np.float32)
        return times

    def pose(self, name: str) -> Array:
        """Return the true values at the points, or where nobody knew them the estimated ones."""
        found: Array = self.drawn.truth.get(name, self.drawn.c[f"state.{name}"])
        return found


def overlays(runs: Sequence[ComparedRun]) -> Iterator[Plot]:
    """Yield all plots: track, depth, heading, speed, errors, coefficients."""
    lines = [_Line(run, Drawn(run.log, _MOST_POINTS), COLOURS[i]) for i, run in enumerate(runs)]
    yield _track(lines)
    yield _with_reference(
        "Depth", "depth, m", 0.5, [(one, one.pose("eta.z"), "reference.z_d") for one in lines], down=True
    )
    yield _with_reference("Heading", "heading, degrees", 5.0, [(one, one.drawn.c["psi"], "psi_d") for one in lines])
    yield _with_reference("Speed", "surge, m/s", 0.2, [(one, one.pose("nu.u"), "reference.u_d") for one in lines])
    for title, unit, least, name, note in (
        ("Depth error", "error, m", 0.1, "depth_error", "Reference minus depth, while a law holds it."),
        ("Heading error", "error, degrees", 1.0, "heading_error", "Reference minus heading, the short way."),
        ("Path error", "distance, m", 0.5, "path_error", "Horizontal distance to the legs of the mission."),
    ):
        if plot := _errors(title, unit, least, [(one, one.drawn.c[name]) for one in lines], note):
            yield plot
    yield from _coefficients(lines)


def _figure(lines: Sequence[_Line], unit: str) -> Any:
    figure = go.Figure()
    figure.update_xaxes(title="vehicle time, s", range=[0.0, max(one.run.length for one in lines)])
    figure.update_yaxes(title=unit)
    return figure


def _track(lines: Sequence[_Line]) -> Plot:
    """Return the plan view; the legs of a mission that several runs have are drawn once."""
    figure, missions, extents = go.Figure(), dict[bytes, list[_Line]](), list[Array]()
    for one in lines:
        places, name = one.drawn.plan_truth or one.drawn.plan, one.run.name
        extents += [np.column_stack((places["eta.x"], places["eta.y"])), one.drawn.mission.waypoints[:, :2]]
        line(figure, places["eta.y"], places["eta.x"], name, one.colour, legendgroup=name)
        ends: dict[str, Any] = {"mode": "markers", "marker": {"size": 9, "symbol": "square", "color": one.colour}}
        ends |= {"legendgroup": name, "showlegend": False, "name": f"{name}, end"}
        figure.add_scatter(x=places["eta.y"][-1:], y=places["eta.x"][-1:], **ends)
        if len(one.drawn.mission.waypoints):
            missions.setdefault(one.drawn.mission.waypoints.tobytes(), []).append(one)
    for group in missions.values():
        points = group[0].drawn.mission.waypoints
        colour = TRUTH if len(missions) == 1 else group[0].colour
        name = "legs" if len(missions) == 1 else f"legs of {', '.join(one.run.name for one in group)}"
        pen: dict[str, Any] = {"mode": "lines+markers", "dash": "dot", "width": 1.2}
        line(figure, points[:, 1], points[:, 0], name, colour, marker={"symbol": "diamond-open", "size": 9}, **pen)
    figure.update_xaxes(title="east, m")
    figure.update_yaxes(title="north, m", scaleanchor="x", scaleratio=1)
    note = "Local frame; scales are equal. Squares are where the runs end."
    tall = not is_wide(*extents)
    return Plot("Plan view", note, figure, over_time=False, tall=tall)


def _with_reference(
    title: str, unit: str, least: float, values: Sequence[tuple[_Line, Array, str]], down: bool = False
) -> Plot:
    """Return a plot of what the runs did, and thin what they were to do."""
    figure = _figure([one for one, _, _ in values], unit)
    for one, flown, wanted in values:
        name = one.run.name
        line(figure, one.t, flown, name, one.colour, legendgroup=name)
        pen: dict[str, Any] = {"dash": "dot", "width": 1.0, "legendgroup": name, "showlegend": False}
        line(figure, one.t, one.drawn.c[wanted], f"{name}, reference", one.colour, **pen)
    minimum_height(figure, least)
    if down:
        figure.update_yaxes(autorange="reversed")
    return Plot(title, "Dotted: the reference of each run.", figure)


def _errors(title: str, unit: str, least: float, values: Sequence[tuple[_Line, Array]], note: str) -> Plot | None:
    figure = _figure([one for one, _ in values], unit)
    for one, error in values:
        line(figure, one.t, error, one.run.name, one.colour)
    if not figure.data:
        return None
    minimum_height(figure, least)
    return Plot(title, note, figure)


def _coefficients(lines: Sequence[_Line]) -> Iterator[Plot]:
    """Yield a plot of each coefficient that a run learned."""
    learned = {one.run.name: {c.name: c for c in coefficients(one.run.log.header, one.drawn.c)} for one in lines}
    for name in dict.fromkeys(name for found in learned.values() for name in found):
        figure, values = _figure(lines, f"{name}, nondimensional"), list[Array]()
        known = [(one, learned[one.run.name][name]) for one in lines if name in learned[one.run.name]]
        for one, coefficient in known:
            values += [*_estimate(figure, one, coefficient)]
        for run, colour, true in _truths(known):
            named = f"{run.run.name}, truth" if colour else "truth"
            line(figure, run.t[[0, -1]], np.full(2, true), named, colour or TRUTH, dash="dash")
            values.append(np.array([true]))
        _fit(figure, values)
        note = "Thick: valid. Thin: not yet, or no longer. Dotted: the vehicle file of each run."
        yield Plot(name, note, figure, section=_COEFFICIENTS)


def _estimate(figure: Any, one: _Line, coefficient: Coefficient) -> Iterator[Array]:
    """Draw what a run learned of a coefficient, and yield what its axis must show."""
    name = one.run.name
    own: dict[str, Any] = {"legendgroup": name}
    line(figure, one.t, coefficient.value, name, one.colour, width=1.0, **own)
    valid = np.where(coefficient.valid, coefficient.value, np.nan)
    line(figure, one.t, valid, f"{name}, valid", one.colour, width=2.6, showlegend=False, **own)
    ends = one.t[[0, -1]]
    file = f"{name}, vehicle file"
    line(figure, ends, np.full(2, coefficient.believed), file, one.colour, 1.0, "dot", showlegend=False, **own)
    yield valid[np.isfinite(valid)] if np.isfinite(valid).any() else coefficient.value[-1:]
    yield np.array([coefficient.believed])


def _truths(known: Sequence[tuple[_Line, Coefficient]]) -> Iterator[tuple[_Line, str, float]]:
    """Yield the truth at the end of each run that knows it, with its colour; of runs that agree once, without."""
    true = [(one, float(coefficient.truth[-1])) for one, coefficient in known if np.isfinite(coefficient.truth[-1])]
    if len({value for _, value in true}) == 1:
        longest = max(true, key=lambda pair: pair[0].run.length)
        yield longest[0], "", longest[1]
        return
    for one, value in true:
        yield one, one.colour, value


def _fit(figure: Any, values: Sequence[Array]) -> None:
    """Make the axis as high as what is valid, true and believed; what was tried at first goes on beyond it."""
    finite = np.concatenate([value[np.isfinite(value)] for value in values])
    if finite.size:
        low, high = float(finite.min()), float(finite.max())
        half = max(0.6 * (high - low), 0.05 * abs(high), 1e-9)
        figure.update_yaxes(range=[0.5 * (low + high) - half, 0.5 * (low + high) + half])
