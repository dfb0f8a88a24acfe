"""Fence and rally points in a plan view, each for as long as it was in force."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from firmware_py.records.fence import Area, Disc, Fence, Place, fence_from_plain, rally_from_plain
from firmware_py.records.order import Change, FenceChange, RallyChange
from sternplane.logs.run import Run
from sternplane.logs.tracking import Array
from sternplane.report.drawing import rgb

T = TypeVar("T")
_INCLUSION, _EXCLUSION, _RALLY = "#15803d", "#dc2626", "#7c3aed"
_AROUND = np.linspace(0.0, 2.0 * np.pi, 73)
_WIDE = 3.0
"""The view reaches so many times as far as the vehicle and its legs do, for a fence that is larger."""
_LEAST = 20.0
"""From the middle of a view to its edge, m, at least."""


class InForce(NamedTuple, Generic[T]):
    """A fence or rally points, and its time of validity as text; "" is all the time."""

    what: T
    when: str


def fences(log: Run) -> list[InForce[Fence]]:
    """Return every fence of a run: the configuration's, and those that stations sent meanwhile."""
    first = fence_from_plain(log.header.get("configuration", {}).get("fence", {}))
    return _in_force(log, first, lambda change: change.fence if isinstance(change, FenceChange) else None)


def rally_points(log: Run) -> list[InForce[tuple[Place, ...]]]:
    """All rally points of a run, in the same way."""
    first = rally_from_plain(log.header.get("configuration", {}).get("rally", {}))
    return _in_force(log, first, lambda change: change.points if isinstance(change, RallyChange) else None)


def _in_force(log: Run, first: T, of: Callable[[Change], T | None]) -> list[InForce[T]]:
    found = [(0.0, first)]
    for t_ns, changes in log.changes.items():
        for what in map(of, changes):
            if what is not None and what != found[-1][1]:
                found.append((t_ns * 1e-9, what))
    ends = [f"until {t:.1f} s" for t, _ in found[1:]] + [""]
    begins = ["", *(f"from {t:.1f} s" for t, _ in found[1:])]
    times = [" ".join(part for part in parts if part) for parts in zip(begins, ends, strict=True)]
    return [InForce(what, when) for (_, what), when in zip(found, times, strict=True)]


def draw(figure: Any, log: Run) -> bool:
    """Draw them into a plan view that has everything else already; return True if some of it is beyond the view."""
    view = _view(figure)
    lines: list[tuple[Array, Array]] = []
    for fence, when in fences(log):
        for name, areas, colour in (("inclusion", fence.within, _INCLUSION), ("exclusion", fence.without, _EXCLUSION)):
            if areas:
                lines.append(_outline(areas))
                _area(figure, *lines[-1], f"fence, {name}", when, colour)
    for points, when in rally_points(log):
        if points:
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
    fill: dict[str, Any] = {"fill": "toself", "fillcolor": f"rgba({rgb(colour)}, {0.10 if outside else 0.05})"}
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
