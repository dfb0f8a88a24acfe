"""The plots of a report: what was wanted, what was believed, what was true."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import plotly.graph_objects as go

from firmware_py.records.order import Mode
from tools.log import Log
from tools.summary import Array, navigation_error, true_columns, wrapped_deg

TRUE, BELIEVED, WANTED = "#0f172a", "#2563eb", "#f59e0b"
_PAIRS = ("#2563eb", "#dc2626", "#059669", "#9333ea", "#d97706", "#0891b2", "#be185d", "#4d7c0f")
_MODES = {
    Mode.DISARMED: "#94a3b8",
    Mode.MANUAL: "#f97316",
    Mode.HOLD: "#22c55e",
    Mode.MISSION: "#3b82f6",
    Mode.SURFACE: "#eab308",
}
_MOST_HZ, _MOST_POINTS = 10.0, 4000


class Plot(NamedTuple):
    """A figure with its title and a sentence on what is in it; `over_time` if its x axis is the vehicle's time."""

    title: str
    note: str
    figure: Any
    over_time: bool = True


class Bands(NamedTuple):
    """From when to when (s) the vehicle was in a mode."""

    begin: float
    end: float
    mode: Mode


class Figures:
    """All plots of one log. What they draw is thinned to every `stride`-th cycle; `rate` is what is left, Hz."""

    def __init__(self, log: Log) -> None:
        c = log.columns
        dt = float(c["tick.dt_ns"][0]) * 1e-9
        self.stride = max(1, round(1.0 / dt / _MOST_HZ), -(-len(c["t"]) // _MOST_POINTS))
        self.rate = 1.0 / dt / self.stride
        self.bands = _bands(c["t"], c["mode.mode"], dt)
        self._log = log
        self._c = {name: column[:: self.stride] for name, column in c.items()}
        self._truth = {name: column[:: self.stride] for name, column in true_columns(log).items()}
        self._away = navigation_error(log)[:: self.stride]
        self._t = self._c["t"].astype(np.float32)

    def __iter__(self) -> Iterator[Plot]:
        c, truth = self._c, self._truth
        yield self.plan()
        yield self.depth()
        psi_d, psi, true_psi = c["reference.psi_d"], c["state.eta.psi"], truth.get("eta.psi")
        yield self._three(
            "Heading", "degrees", _compass(psi_d), _compass(psi), None if true_psi is None else _compass(true_psi)
        )
        yield self._three(
            "Speed", "m/s", c["reference.u_d"], c["state.nu.u"], truth.get("nu.u"), "Surge over the ground."
        )
        yield self.attitude()
        yield self.fins()
        yield self.propeller()
        yield from self.tracking()
        yield from self.navigation()

    def plan(self) -> Plot:
        """North over east, with the legs."""
        c, truth, figure = self._c, self._truth, go.Figure()
        waypoints = np.array(self._log.header.get("mission", {}).get("waypoints", ()), dtype=float).reshape(-1, 4)
        if len(waypoints):
            numbers = [str(i + 1) for i in range(len(waypoints))]
            label: dict[str, Any] = {
                "text": numbers,
                "textposition": "top center",
                "marker": {"size": 9, "symbol": "diamond-open"},
            }
            _line(
                figure, waypoints[:, 1], waypoints[:, 0], "legs", WANTED, mode="lines+markers+text", dash="dot", **label
            )
        if truth:
            _line(figure, truth["eta.y"], truth["eta.x"], "truth", TRUE, width=3)
        _line(figure, c["state.eta.y"], c["state.eta.x"], "estimate", BELIEVED)
        for name, at, symbol in (("begin", 0, "circle"), ("end", -1, "square")):
            marker = {"size": 10, "symbol": symbol, "color": TRUE}
            x, y = c["state.eta.y"][at : at + 1 or None], c["state.eta.x"][at : at + 1 or None]
            figure.add_scatter(x=x, y=y, name=name, mode="markers", marker=marker)
        figure.update_xaxes(title="east, m")
        figure.update_yaxes(title="north, m", scaleanchor="x", scaleratio=1)
        return Plot("Plan view", "Local frame; scales are equal.", figure, over_time=False)

    def depth(self) -> Plot:
        """Depth, downwards, with the bottom where the vehicle hears it and the events where they happened."""
        c, truth = self._c, self._truth
        plot = self._three(
            "Depth", "m", c["reference.z_d"], c["state.eta.z"], truth.get("eta.z"), "Diamonds are events."
        )
        bottom = c["state.eta.z"] + c["state.altitude"]
        if np.isfinite(bottom).any():
            _line(plot.figure, self._t, bottom, "bottom", "#a16207", width=1, visible="legendonly")
        if events := self._log.events:
            times, texts = zip(*events, strict=True)
            marker = {"symbol": "diamond", "size": 9, "color": "#be185d"}
            z = np.interp(times, self._log.columns["t"], self._log.columns["state.eta.z"])
            plot.figure.add_scatter(x=times, y=z, text=texts, name="events", mode="markers", marker=marker)
        plot.figure.update_yaxes(autorange="reversed")
        return plot

    def attitude(self) -> Plot:
        """Roll and pitch."""
        figure = self._figure("degrees")
        for name, colour in (("phi", "#059669"), ("theta", BELIEVED)):
            words = {"phi": "roll", "theta": "pitch"}[name]
            _line(figure, self._t, np.degrees(self._c[f"state.eta.{name}"]), words, colour)
        return Plot("Attitude", "Estimates; bow up and starboard down are positive.", figure)

    def fins(self) -> Plot:
        """Every fin: commanded and reported."""
        figure = self._figure("degrees")
        commanded, reported = (np.degrees(self._c[name]) for name in ("applied.fins", "frame.fins.value"))
        for i, name in enumerate(_fin_names(self._log, commanded.shape[1])):
            colour = _PAIRS[i % len(_PAIRS)]
            _line(figure, self._t, commanded[:, i], name, colour, legendgroup=name)
            _line(figure, self._t, reported[:, i], f"{name}, reported", colour, dash="dot", legendgroup=name)
        return Plot("Fins", "Commanded, and what the servos report.", figure)

    def propeller(self) -> Plot:
        """Propeller: commanded and reported."""
        figure = self._figure("rpm")
        _line(figure, self._t, 60.0 * self._c["applied.n"], "commanded", BELIEVED)
        _line(figure, self._t, 60.0 * self._c["frame.n.value"], "reported", "#dc2626", dash="dot")
        return Plot("Propeller", "Commanded, and what its controller reports.", figure)

    def tracking(self) -> Iterator[Plot]:
        """Reference minus what was true, or believed where nobody knew."""
        c, truth = self._c, self._truth
        against = "the truth" if truth else "the estimate"
        z, psi = (truth.get(f"eta.{name}", c[f"state.eta.{name}"]) for name in ("z", "psi"))
        figure = self._figure("m")
        _line(figure, self._t, c["reference.z_d"] - z, "depth", BELIEVED)
        _line(figure, self._t, c["reference.cross_track"], "cross-track", "#059669")
        yield Plot("Tracking error", f"Depth against {against}; cross-track as guidance has it.", figure)
        figure = self._figure("degrees")
        _line(figure, self._t, wrapped_deg(c["reference.psi_d"] - psi), "heading", BELIEVED)
        yield Plot("Heading error", f"Against {against}.", figure)

    def navigation(self) -> Iterator[Plot]:
        """Estimate minus truth, and what the estimate thinks of itself."""
        c, truth = self._c, self._truth
        figure = self._figure("m")
        _band(figure, self._t, np.zeros_like(self._t), 3.0 * c["state.position_std"])
        if truth:
            _line(figure, self._t, self._away, "error", BELIEVED)
        yield Plot("Navigation error, horizontal", "Distance from estimate to truth." * bool(truth), figure)
        figure = self._figure("m")
        _band(figure, self._t, -3.0 * c["state.depth_std"], 3.0 * c["state.depth_std"])
        if truth:
            _line(figure, self._t, c["state.eta.z"] - truth["eta.z"], "error", BELIEVED)
        yield Plot("Navigation error, depth", "Estimate minus truth." * bool(truth), figure)

    def _three(self, title: str, unit: str, wanted: Array, believed: Array, true: Array | None, note: str = "") -> Plot:
        figure = self._figure(unit)
        if true is not None:
            _line(figure, self._t, true, "truth", TRUE, width=3)
        _line(figure, self._t, believed, "estimate", BELIEVED)
        _line(figure, self._t, wanted, "reference", WANTED, dash="dash")
        return Plot(title, note, figure)

    def _figure(self, unit: str) -> Any:
        figure = go.Figure()
        for begin, end, mode in self.bands:
            figure.add_vrect(begin, end, fillcolor=_MODES[mode], opacity=0.09, line_width=0, layer="below")
        figure.update_xaxes(title="vehicle time, s", range=[self.bands[0].begin, self.bands[-1].end])
        figure.update_yaxes(title=unit)
        return figure


def mode_colours(bands: list[Bands]) -> list[tuple[str, str]]:
    """(mode, colour) of the modes that occur, for the key."""
    return [(mode.name.lower(), colour) for mode, colour in _MODES.items() if any(b.mode is mode for b in bands)]


def _line(
    figure: Any, x: Array, y: Array, name: str, colour: str, width: float = 1.8, dash: str = "solid", **other: Any
) -> None:
    other = {"mode": "lines", **other}
    line = {"color": colour, "width": width, "dash": dash}
    figure.add_scatter(x=x.astype(np.float32), y=y.astype(np.float32), name=name, line=line, **other)


def _band(figure: Any, t: Array, low: Array, high: Array) -> None:
    hidden = {"mode": "lines", "line": {"width": 0}, "hoverinfo": "skip"}
    figure.add_scatter(x=t, y=low.astype(np.float32), showlegend=False, **hidden)
    fill = {"fill": "tonexty", "fillcolor": "rgba(37, 99, 235, 0.15)"}
    figure.add_scatter(x=t, y=high.astype(np.float32), name="3 σ", **hidden, **fill)


def _compass(psi: Array) -> Array:
    """Degrees in [0, 360), with a gap where the line would run across the plot."""
    degrees: Array = np.degrees(psi) % 360.0
    degrees[1:][np.abs(np.diff(degrees)) > 180.0] = np.nan
    return degrees


def _bands(t: Array, modes: Array, dt: float) -> list[Bands]:
    edges = [0, *(np.flatnonzero(np.diff(modes)) + 1), len(modes)]
    pairs = itertools.pairwise(edges)
    return [Bands(float(t[a]), float(t[b - 1]) + dt, Mode(int(modes[a]))) for a, b in pairs]


def _fin_names(log: Log, count: int) -> list[str]:
    fins = log.header.get("configuration", {}).get("vehicle", {}).get("fins", ())
    names = [str(fin["name"]).replace("_", " ") for fin in fins if "name" in fin]
    return names if len(names) == count else [f"fin {i + 1}" for i in range(count)]
