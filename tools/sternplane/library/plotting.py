"""A figure of one flight, or of several on top of each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from firmware_py.records.order import Mode
from firmware_py.run.usage_error import UsageError
from sternplane.library.flights import FlightResult
from sternplane.library.recordings import Array, Recording
from sternplane.logs.tracking import FlownMissions, depth_flown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Flown = Recording | FlightResult


def plot(flown: _Flown | Mapping[str, _Flown]) -> Figure:
    """Return a matplotlib figure: the track, and over time depth, heading and fins; `.savefig("flight.png")` keeps it.

    Lines are the truth where it is known, else the estimate; what was asked for is dashed, the legs of a mission are
    dotted.

    Args:
        flown: a flight, or several by the names that the legend shows.

    Raises:
        UsageError: there is no flight, or matplotlib is not installed.
    """
    several = flown if isinstance(flown, Mapping) else {"": flown}
    if not several:
        raise UsageError("there is nothing to plot: give a flight, or several by their names")
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise UsageError("a figure needs matplotlib: pip install 'sternplane[report]'") from None
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    axes = figure.subplot_mosaic([["track", "depth"], ["track", "heading"], ["planes", "rudder"]])
    for i, (name, one) in enumerate(several.items()):
        _draw(axes, one.recording if isinstance(one, FlightResult) else one, name, f"C{i}")
    for name, label in (
        ("depth", "depth, m"),
        ("heading", "heading, deg"),
        ("planes", "stern planes, deg"),
        ("rudder", "rudder, deg"),
    ):
        axes[name].set(xlabel="t, s", ylabel=label)
    axes["track"].set(xlabel="east, m", ylabel="north, m", aspect="equal")
    axes["track"].set_adjustable("datalim")
    axes["depth"].invert_yaxis()
    if len(several) > 1:
        axes["depth"].legend()
    return figure


def _draw(axes: Mapping[str, Any], recording: Recording, name: str, colour: str) -> None:
    t, state, columns = recording.t, recording.truth or recording.estimate, recording.columns
    flown = {"depth": depth_flown(columns), "heading": columns["mode.mode"] != 0}
    legs = _legs(recording, state)
    axes["track"].plot(legs[:, 1], legs[:, 0], ":o", color="0.6", markersize=4.0, zorder=1.0)
    axes["track"].plot(state["y"], state["x"], color=colour)
    axes["depth"].plot(t, state["z"], color=colour, label=name)
    axes["heading"].plot(t, np.degrees(np.unwrap(state["psi"])), color=colour)
    desired = np.degrees(np.unwrap(columns["reference.psi_d"]))
    desired += 360.0 * np.round((np.degrees(np.unwrap(state["psi"])) - desired) / 360.0)
    for axis, values in (("depth", columns["reference.z_d"]), ("heading", desired)):
        axes[axis].plot(t, np.where(flown[axis], values, np.nan), "--", color=colour, linewidth=0.8)
    axes["planes"].plot(t, np.degrees(columns["demand.delta_s"]), color=colour, linewidth=0.8)
    axes["rudder"].plot(t, np.degrees(columns["demand.delta_r"]), color=colour, linewidth=0.8)


def _legs(recording: Recording, state: Mapping[str, Array]) -> Array:
    """Return where the mission was taken up, and its waypoints, (n, 2); nothing where none was flown."""
    missions = FlownMissions(recording.log)
    for piece in recording.log.pieces():
        missions.add(piece)
    flying = np.flatnonzero(recording.columns["mode.mode"] == Mode.MISSION)
    if not flying.size:
        return np.empty((0, 2))
    begin = flying[flying >= missions.last.begin][0]
    return np.vstack(([state["x"][begin], state["y"][begin]], missions.last.waypoints[:, :2]))
