"""The page of `sternplane vehicle check`: findings, what the vehicle can hold, and four plots."""

from __future__ import annotations

import math

import numpy as np
import plotly.graph_objects as go

from sternplane.report.drawing import ESTIMATE, REFERENCE, TRUTH, Plot, line
from sternplane.report.page import Cell, Page, Section, Table, plot_section, render
from sternplane.vehicles.check import Checked
from sternplane.vehicles.finding import Grade
from sternplane.vehicles.limits import Files

_PLANES = (("diving", "diving", ESTIMATE), ("steering", "course", REFERENCE), ("rolling", "roll", TRUTH))
_STATE = {Grade.PASS: "good", Grade.WARN: "warn", Grade.FAIL: "bad"}
_COLOURS = ("#93c5fd", "#60a5fa", "#3b82f6", "#1d4ed8", "#0f172a")


def page(files: Files, found: Checked) -> str:
    """Return the page as HTML."""
    rows = [[Cell(f.grade.value, _STATE[f.grade]), f.topic, f.text] for f in found.findings]
    plots = [_poles(found), _levels(found), *([_circles(files, found), _radii(found)] if found.turns else [])]
    warned = any(finding.grade is Grade.WARN for finding in found.findings)
    status, mood = ("something failed", "bad") if found.failed else ("can be flown", "warn" if warned else "good")
    sections = [
        Section("What was found", tables=[Table(rows)], wide=True),
        Section("What the vehicle can hold", tables=[Table([list(pair) for pair in found.abilities])]),
        *(plot_section(plot) for plot in plots),
    ]
    about = f"By the files in {files.folder}, and by the simulated vehicle, swum without its autopilot in still water."
    return render(Page(f"{files.vehicle.name}: what it can do", status, mood, sections, about))


def _poles(found: Checked) -> Plot:
    figure, u = go.Figure(), np.array([one.u for one in found.poles])
    for plane, name, colour in _PLANES:
        line(figure, u, np.array([one.worst(plane) for one in found.poles]), name, colour)
    figure.add_hline(y=0.0, line={"color": "#dc2626", "width": 1, "dash": "dot"})
    figure.update_xaxes(title="speed, m/s")
    figure.update_yaxes(title="slowest pole, 1/s")
    return Plot("Stability of the hull without its laws", "Above the dotted line a motion grows.", figure, False)


def _levels(found: Checked) -> Plot:
    held = [one for one in found.levels if one.share <= 1.5 and abs(one.theta) < math.radians(45.0)]
    figure, u = go.Figure(), np.array([one.u for one in held])
    line(figure, u, np.degrees([one.theta for one in held]), "pitch", ESTIMATE)
    line(figure, u, np.degrees([one.delta_s for one in held]), "stern planes", REFERENCE)
    figure.update_xaxes(title="speed, m/s")
    figure.update_yaxes(title="deg")
    return Plot("Level flight", "What holds depth against weight and buoyancy.", figure, False)


def _circles(files: Files, found: Checked) -> Plot:
    figure = go.Figure()
    for colour, (angle, turn) in zip(_COLOURS, found.turns.items(), strict=False):
        every = max(len(turn.track) // 800, 1)
        track = turn.track[::every]
        line(figure, track[:, 1], track[:, 0], f"{math.degrees(angle):.0f} deg", colour)
    figure.update_xaxes(title="east, m")
    figure.update_yaxes(title="north, m", scaleanchor="x")
    cruise = files.autopilot.guidance.cruise_speed
    note = f"Of the simulated vehicle, from {cruise:g} m/s, by rudder."
    return Plot("Turning circles", note, figure, False, tall=True)


def _radii(found: Checked) -> Plot:
    figure = go.Figure()
    angles = np.degrees(list(found.turns))
    line(figure, angles, np.array([turn.radius for turn in found.turns.values()]), "radius, m", ESTIMATE)
    line(figure, angles, np.degrees([abs(turn.rate) for turn in found.turns.values()]), "turn rate, deg/s", REFERENCE)
    figure.update_xaxes(title="rudder, deg")
    figure.update_yaxes(rangemode="tozero")
    return Plot("Turn by rudder", "", figure, False)
