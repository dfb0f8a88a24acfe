"""Fence and rally points in a plan view, each for as long as it was in force."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from firmware_py.records.fence import Area, Disc, from_plain, rally_from_plain
from sternplane.logs.reading import Log
from sternplane.logs.tracking import Array

_INCLUSION, _EXCLUSION, _RALLY = "#15803d", "#dc2626", "#7c3aed"
_AROUND = np.linspace(0.0, 2.0 * np.pi, 73)
_WIDE = 3.0
"""The view reaches so many times as far as the vehicle and its legs do, for a fence that is larger."""
_LEAST = 20.0
"""From the middle of a view to its edge, m, at least."""


class Validity(NamedTuple):
    """The table of a fence or of rally points, and its time of validity as text; "" is all the time."""

    table: Mapping[str, Any]
    when: str


def versions(log: Log, kind: str) -> list[Validity]:
    """Return every "fence", or "rally", of a run: the configuration's, and those that stations sent meanwhile."""
    tables = [(0.0, log.header.get("configuration", {}).get(kind, {}))]
    for t_ns, documents in log.changes.items():
        for document in map(json.loads, documents):
            if kind in document and document[kind] != tables[-1][1]:
                tables.append((t_ns * 1e-9, document[kind]))
    ends = [f"until {t:.1f} s" for t, _ in tables[1:]] + [""]
    begins = ["", *(f"from {t:.1f} s" for t, _ in tables[1:])]
    times = [" ".join(part for part in parts if part) for parts in zip(begins, ends, strict=True)]
    return [Validity(table, when) for (_, table), when in zip(tables, times, strict=True)]


def draw(figure: Any, log: Log) -> bool:
    """Draw them into a plan view that has everything else already; return True if some of it is beyond the view."""
    view = _view(figure)
    lines: list[tuple[Array, Array]] = []
    for table, when in versions(log, "fence"):
        fence = from_plain(table)
        for name, areas, colour in (("inclusion", fence.within, _INCLUSION), ("exclusion", fence.without, _EXCLUSION)):
            if areas:
                lines.append(_outline(areas))
                _area(figure, *lines[-1], f"fence, {name}", when, colour)
    for table, when in versions(log, "rally"):
        if points := rally_from_plain(table):
            north, east = np.array(points).T
            lines.append((north, east))
            marker = {"symbol": "star", "size": 12, "color": _RALLY, "opacity": _opacity(when)}
            figure.add_scatter(x=east, y=north, name=_named("rally points", when), mode="markers", marker=marker)
    if not lines or view is None:
        return False
    beyond = False
    for axis, (low, high), values in zip("yx", view, zip(*lines, strict=True), strict=True):
        ends = np.concatenate(values)
        beyond |= bool(np.nanmin(ends) < low or np.nanmax(ends) > high)
        figure.update_layout({f"{axis}axis": {"autorangeoptions": {"clipmin": low, "clipmax": high}}})
    return beyond


def _area(figure: Any, north: Array, east: Array, name: str, when: str, colour: str) -> None:
    """An exclusion is hatched, so that it is told from an inclusion without its colour too."""
    outside = name.endswith("exclusion")
    fill: dict[str, Any] = {"fill": "toself", "fillcolor": f"rgba({_rgb(colour)}, {0.10 if outside else 0.05})"}
    if outside:
        fill["fillpattern"] = {"shape": "/", "size": 8, "solidity": 0.15, "fgcolor": colour}
    figure.add_scatter(
        x=east.astype(np.float32),
        y=north.astype(np.float32),
        name=_named(name, when),
        mode="lines",
        line={"color": colour, "width": 1.5, "dash": "solid" if outside else "dash"},
        opacity=_opacity(when),
        hoverinfo="skip",
        **fill,
    )


def _named(name: str, when: str) -> str:
    return f"{name}, {when}" if when else name


def _opacity(when: str) -> float:
    """What no longer stood at the end is pale."""
    return 0.5 if "until" in when else 1.0


def _rgb(colour: str) -> str:
    return ", ".join(str(int(colour[i : i + 2], 16)) for i in (1, 3, 5))


def _outline(areas: Iterable[Area]) -> tuple[Array, Array]:
    """North and east of the edges, m, NaN between one and the next."""
    rings = []
    for area in areas:
        if isinstance(area, Disc):
            ring = np.column_stack((area.x + area.radius * np.cos(_AROUND), area.y + area.radius * np.sin(_AROUND)))
        else:
            ring = np.array((*area.corners, area.corners[0]))
        rings += [ring, np.full((1, 2), np.nan)]
    north, east = np.vstack(rings[:-1]).T
    return north, east


def _view(figure: Any) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """How far north and east a view may reach, by what is drawn; None where nothing is."""
    boxes = []
    for name in "yx":
        values = np.concatenate([np.asarray(trace[name], dtype=float) for trace in figure.data] or [np.empty(0)])
        if not np.isfinite(values).any():
            return None
        boxes.append((float(np.nanmin(values)), float(np.nanmax(values))))
    half = _WIDE * max(_LEAST, *(0.5 * (high - low) for low, high in boxes))
    north, east = ((0.5 * (low + high) - half, 0.5 * (low + high) + half) for low, high in boxes)
    return north, east
