"""The plots of a flight's report: reference, estimate and truth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go

from firmware_py import config_files
from firmware_py.params import ParamError
from firmware_py.records.event import Cause
from firmware_py.records.order import Mode
from sternplane.logs.health_record import Timeline, fin_names
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array
from sternplane.report import fault_marks
from sternplane.report.coefficient_plots import plots
from sternplane.report.drawing import COLOURS, ESTIMATE, PALE_ESTIMATE, REFERENCE, TRUTH, Plot, line, minimum_height
from sternplane.report.error_plots import error_plots
from sternplane.report.health_plot import health_plot
from sternplane.report.lateness_plot import histogram
from sternplane.report.payload_plots import payload_plots
from sternplane.report.plan_view import plan_view
from sternplane.report.steering_text import speed_text
from sternplane.report.thinning import Drawn

_MODES = {
    Mode.DISARMED: "#94a3b8",
    Mode.MANUAL: "#f97316",
    Mode.HOLD: "#22c55e",
    Mode.MISSION: "#3b82f6",
    Mode.SURFACE: "#eab308",
    Mode.LOITER: "#14b8a6",
    Mode.GUIDED: "#8b5cf6",
    Mode.RETURN: "#ec4899",
}
_MOST_POINTS = 4000
_MOST_EVENTS = 1000
"""So many events are marked."""
_NEAR_LIMIT = 2.0
"""Depth limit and bottom are drawn at once less than so many times the greatest depth down; else from the legend."""
_LIMITS = (Cause.DEPTH_LIMIT, Cause.ALTITUDE_LIMIT, Cause.BOTTOM_UNSEEN)
"""Where a rule told one of these, they are drawn in any case."""
_SAME_DEG = 1.0
"""Fins that are commanded alike and report angles no further apart are one line."""


class Bands(NamedTuple):
    """From when to when (s) the vehicle was in a mode."""

    begin: float
    end: float
    mode: Mode


class Figures:
    """All plots of one log; `stride` and `rate` say how their data are thinned (`thinning.Drawn`)."""

    def __init__(self, log: Run) -> None:
        self._log = log
        self._drawn = Drawn(log, _MOST_POINTS)
        self.stride, self.envelope, _ = self._drawn.stride
        self.rate = self._drawn.rate
        self.bands = _bands(self._drawn.modes)
        self.marks = fault_marks.fault_marks(log.header, self.bands[-1].end)
        self._c, self._truth = self._drawn.c, self._drawn.truth
        self._t = self._c["t"].astype(np.float32)

    def __iter__(self) -> Iterator[Plot]:
        for plot in self._plots():
            if plot.over_time:
                fault_marks.draw(plot.figure, self.marks)
            yield plot

    def _plots(self) -> Iterator[Plot]:
        c, truth, drawn = self._c, self._truth, self._drawn
        yield plan_view(self._log, drawn)
        yield self.depth()
        yield self.heading()
        u, u_d, true = c["state.nu.u"], c["reference.u_d"], truth.get("nu.u")
        note = speed_text(self._log.header, u if true is None else true, u_d)
        yield self._three("Speed", "surge, m/s", 0.2, u_d, u, true, note)
        yield self.attitude()
        yield self.fins()
        yield self.propeller()
        if timeline := health_plot(drawn.health, self._figure("")):
            yield timeline
        yield from error_plots(drawn, self._figure)
        if drawn.late:
            yield histogram(drawn.late, drawn.dt * 1e6)
        yield from payload_plots(self._log, self._figure)
        yield from plots(self._log, drawn, truth.get("current"), self._figure)

    def depth(self) -> Plot:
        """Depth, downwards, with the bottom where the vehicle hears it and the events where they happened."""
        c, truth = self._c, self._truth
        note = "Diamonds are events."
        plot = self._three("Depth", "depth, m", 0.5, c["reference.z_d"], c["z_known"], truth.get("eta.z"), note)
        line(plot.figure, self._t, c["z_unknown"], "estimate, not known", PALE_ESTIMATE, dash="dot")
        depths = [c["z_known"], *([truth["eta.z"]] if truth else [])]
        deepest = max(float(np.nanmax(z, initial=0.0)) for z in depths)
        if np.isfinite(c["bottom"]).any():
            shown = self._shown(float(np.nanmin(c["bottom"])), deepest)
            line(plot.figure, self._t, c["bottom"], "bottom", "#a16207", width=1, **shown)
        if events := self._log.sentences[:_MOST_EVENTS]:
            texts, (times, z) = [text for _, text in events], self._drawn.events[:, :_MOST_EVENTS]
            marker = {"symbol": "diamond", "size": 9, "color": "#be185d"}
            plot.figure.add_scatter(x=times, y=z, text=texts, name="events", mode="markers", marker=marker)
        limit = _depth_limit(self._log)
        if limit is not None:
            ends, shown = self._t[[0, -1]], self._shown(limit, deepest)
            line(plot.figure, ends, np.full(2, limit), f"depth limit, {limit:g} m", "#dc2626", dash="dot", **shown)
        plot.figure.update_yaxes(autorange="reversed")
        return plot

    def _shown(self, z: float, deepest: float) -> dict[str, Any]:
        """Return how a line at a depth is shown: at once if the vehicle was near it, or a rule spoke of it."""
        told = any(event.cause in _LIMITS for _, events in self._log.events for event in events)
        return {} if told or z < _NEAR_LIMIT * deepest else {"visible": "legendonly"}

    def heading(self) -> Plot:
        """Heading without jumps at north; all of it on the turn that the vehicle is on."""
        c = self._c
        return self._three(
            "Heading", "heading, degrees", 5.0, c["psi_d"], c["psi_estimate"], c["psi"] if self._truth else None
        )

    def attitude(self) -> Plot:
        """Roll and pitch: the estimates, and the truth where it was logged."""
        figure = self._figure("angle, degrees")
        for name, label, colour, pale in (
            ("eta.phi", "roll", "#059669", "#a7f3d0"),
            ("eta.theta", "pitch", ESTIMATE, "#bfdbfe"),
        ):
            if self._truth:
                line(figure, self._t, np.degrees(self._truth[name]), f"{label}, truth", pale, width=4)
            line(figure, self._t, np.degrees(self._c[f"state.{name}"]), label, colour)
        minimum_height(figure, 2.0)
        return Plot("Attitude", "Bow up and starboard down are positive.", figure)

    def fins(self) -> Plot:
        """Every fin: commanded and reported; those that do the same are one line."""
        figure = self._figure("fin angle, degrees")
        commanded, reported = (np.degrees(self._c[name]) for name in ("applied.fins", "frame.fins"))
        names, drawn = fin_names(self._log.header, commanded.shape[1]), np.zeros(0, np.int64)
        note = "Commanded; dotted: what the servos report."
        for group in _alike(commanded, reported):
            i, name = group[0], _listed([names[k] for k in group])
            colour, hidden = COLOURS[i % len(COLOURS)], (commanded[:, i] == commanded[:, drawn].T).mean(axis=1) > 0.5
            dash = "dash" if hidden.any() else "solid"  # over the line that it would hide
            line(figure, self._t, commanded[:, i], name, colour, dash=dash, legendgroup=name)
            pen: dict[str, Any] = {"dash": "dot", "legendgroup": name, "showlegend": False}
            line(figure, self._t, reported[:, i], f"{name}, reported", colour, **pen)
            drawn = np.append(drawn, i)
        minimum_height(figure, 4.0)
        return Plot("Fins", note, figure)

    def propeller(self) -> Plot:
        """Propeller: commanded and reported."""
        figure = self._figure("propeller speed, rpm")
        line(figure, self._t, 60.0 * self._c["applied.n"], "commanded", ESTIMATE)
        line(figure, self._t, 60.0 * self._c["frame.n"], "reported", "#dc2626", dash="dot")
        minimum_height(figure, 20.0)
        return Plot("Propeller", "Commanded, and what its controller reports.", figure)

    def _three(
        self, title: str, unit: str, least: float, wanted: Array, believed: Array, true: Array | None, note: str = ""
    ) -> Plot:
        figure = self._figure(unit)
        if true is not None:
            line(figure, self._t, true, "truth", TRUTH, width=3)
        line(figure, self._t, believed, "estimate", ESTIMATE)
        line(figure, self._t, wanted, "reference", REFERENCE, dash="dash")
        minimum_height(figure, least)
        return Plot(title, note, figure)

    def _figure(self, unit: str) -> Any:
        figure = go.Figure()
        figure.update_layout(shapes=[_shade(band) for band in self.bands])
        figure.update_xaxes(title="vehicle time, s", range=[self.bands[0].begin, self.bands[-1].end])
        figure.update_yaxes(title=unit)
        return figure


def _alike(commanded: Array, reported: Array) -> list[list[int]]:
    """Return the fins, columns of both, in groups that were commanded and moved alike."""
    groups: list[list[int]] = []
    for i in range(commanded.shape[1]):
        for group in groups:
            same = np.array_equal(commanded[:, i], commanded[:, group[0]], equal_nan=True)
            if same and np.allclose(reported[:, i], reported[:, group[0]], rtol=0.0, atol=_SAME_DEG, equal_nan=True):
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _listed(names: list[str]) -> str:
    """Return names as words: "a", "a and b", "a, b and c"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def mode_colours(bands: list[Bands]) -> list[tuple[str, str]]:
    """Return (colour, mode) of the modes that occur."""
    return [(colour, mode.name.lower()) for mode, colour in _MODES.items() if any(b.mode is mode for b in bands)]


def _shade(band: Bands) -> dict[str, Any]:
    """Return the shape behind a plot that shows a mode."""
    ends = {"x0": band.begin, "x1": band.end, "y0": 0, "y1": 1, "xref": "x", "yref": "y domain"}
    return {
        "type": "rect",
        **ends,
        "fillcolor": _MODES[band.mode],
        "opacity": 0.09,
        "line": {"width": 0},
        "layer": "below",
    }


def _bands(modes: Timeline) -> list[Bands]:
    return [Bands(begin, end, Mode(mode)) for begin, end, mode in modes.spans]


def _depth_limit(log: Run) -> float | None:
    """The configured limit, m; None where the header has none that this version can read."""
    try:
        return float(config_files.autopilot_params(log.header["configuration"]).safety.depth_max)
    except (KeyError, TypeError, ParamError):
        return None
