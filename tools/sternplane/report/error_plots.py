"""The plots of errors: how far the vehicle was off what it was to do, and its estimate off the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from firmware_py.number_text import signed
from sternplane.logs.tracking import Array
from sternplane.report.drawing import ESTIMATE, REFERENCE, Plot, band, line, minimum_height
from sternplane.report.thinning import Drawn

_HELD = 20.0
"""A band of up to so many times the greatest error is held by the plot whole; more would hide the error."""
_MUCH_DEG = 0.05
"""A heading estimate that is off by less in the mean needs no words."""


def error_plots(drawn: Drawn, figure: Callable[[str], Any]) -> Iterator[Plot]:
    """Yield them: of tracking where somebody steered by laws, of navigation where the truth was known.

    Args:
        drawn: the data.
        figure: makes an empty plot over time with a y axis of that name.
    """
    c, t = drawn.c, drawn.c["t"].astype(np.float32)
    if drawn.steered:
        off = np.isfinite(c["depth_error"]).any() or np.isfinite(c["path_error"]).any()
        if off:
            yield _tracking(drawn, t, figure("error, m"))
        heading = _heading(drawn, t, figure("error, degrees"))
        yield heading if off else heading._replace(note=f"{heading.note} No depth and no path was to be kept.")
    if drawn.truth:
        horizontal, vertical = 3.0 * c["state.position_std"], 3.0 * c["state.depth_std"]
        said, nothing = "Distance from estimate to truth, without a sign.", 0.0 * horizontal
        yield _within("Navigation error, horizontal", said, (c["away"], nothing, horizontal), t, 1.0, figure)
        said = "Estimate minus truth."
        yield _within("Navigation error, depth", said, (c["depth_off"], -vertical, vertical), t, 0.1, figure)


def _tracking(drawn: Drawn, t: Array, figure: Any) -> Plot:
    """Return what was wanted minus what was true, or believed where nobody knew; and the distance to the path."""
    c = drawn.c
    line(figure, t, c["depth_error"], "depth", ESTIMATE)
    line(figure, t, c["path_error"], "path", "#059669")
    minimum_height(figure, 0.1)
    flown = np.isfinite(c["path_error"]).any()
    path = " Path: horizontal distance to the planned path, in MISSION, without a sign." if flown else ""
    note = f"Against {'the truth' if drawn.truth else 'the estimate'}. Depth: reference minus actual.{path}"
    return Plot("Tracking error", note, figure)


def _heading(drawn: Drawn, t: Array, figure: Any) -> Plot:
    """Return the same of the heading; against the truth it has the part that the law cannot see, the estimate's."""
    c, note = drawn.c, f"Reference minus actual, against {'the truth' if drawn.truth else 'the estimate'}."
    line(figure, t, c["heading_error"], "heading", ESTIMATE)
    if drawn.truth:
        line(figure, t, c["psi_d"] - c["psi_estimate"], "by the estimate", REFERENCE, width=1.2)
    minimum_height(figure, 1.0)
    off, sensor = drawn.heading_off.mean, drawn.ahrs_off.mean
    if off is not None and abs(off) > _MUCH_DEG:
        note += f" The vehicle steers by its estimate, which is {off:+.2f}° off the truth in the mean"
        note += f"; the heading of its AHRS is {signed(sensor, '.2f')}° off." if sensor is not None else "."
    return Plot("Heading error", note, figure)


def _within(
    title: str, note: str, lines: tuple[Array, Array, Array], t: Array, least: float, figure_of: Callable[[str], Any]
) -> Plot:
    """Return an error in the band where it should be, from low to high; `least` is the least height of the axis, m."""
    (error, low, high), figure = lines, figure_of("error, m")
    band(figure, t, low, high, "3 σ")
    line(figure, t, error, "error", ESTIMATE)
    known, size = _known_from(high), np.abs(error)
    first, worst = (float(np.nanmax(part, initial=0.0)) for part in (size[:known], size[known:]))
    if first <= _HELD * worst:
        worst = max(worst, first)
    top, reach = max(2.0 * worst, least), float(np.nanmax(high[known:], initial=0.0))
    if reach <= _HELD * worst:
        top = max(top, reach)
    bottom = -top if low.min() < 0.0 else 0.0
    figure.update_yaxes(autorangeoptions={"include": [bottom, top], "clipmin": 1.05 * bottom, "clipmax": 1.05 * top})
    note += f" 3 σ is up to {reach:.3g} m"
    if reach > top:
        note += ", beyond the plot"
    elif high.max() > top:
        note += f"; at first {high.max():.3g} m, beyond the plot"
    if first > top:
        note += f". The error was {first:.3g} m before the first measurement, beyond the plot"
    note += "."
    return Plot(title, note, figure)


def _known_from(sigma: Array) -> int:
    """Return from where on a sigma has been told of a measurement: where it first falls; else from the begin on."""
    falls = np.flatnonzero(np.diff(sigma) < 0.0)
    return int(falls[0]) + 1 if falls.size else 0
