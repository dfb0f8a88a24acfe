"""Where injected faults begin and end, as lines across the plots over time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from sternplane.logs.true_coefficients import faults_of

_COLOUR = "#dc2626"
_NEAR = 0.04
"""Nearer to the begin of a plot than this share of it there is no room for words before a line."""
_MOST = 40
"""More lines than these hide what they cross."""


class Mark(NamedTuple):
    """A time, s, at which faults begin or end; `text` is the first of them, and how many more; `ends`: none begins."""

    t: float
    ends: bool
    text: str


def fault_marks(header: Mapping[str, Any], t_end: float) -> list[Mark]:
    """Return the marks of a log's faults up to a time, s; what this version does not know is left out."""
    found: dict[float, list[tuple[bool, str]]] = {}
    for fault in faults_of(header):
        name = fault.text.partition("@")[0]
        for t, ends, words in ((fault.t, False, name), (fault.t + fault.duration, True, f"{name} ends")):
            if t <= t_end:
                found.setdefault(t, []).append((ends, words))
    marks = []
    for t, those in sorted(found.items()):
        (ends, first), *others = sorted(those, key=lambda one: one[0])
        marks.append(Mark(t, ends, f"{first} +{len(others)}" if others else first))
    return marks[:_MOST]


def draw(figure: Any, marks: Iterable[Mark]) -> None:
    """Draw them into a plot over time, each with its name; the legend has one entry for all that begin or end."""
    in_legend: set[bool] = set()
    begin, end = figure.layout.xaxis.range
    for mark in marks:
        group = "fault ends" if mark.ends else "fault begins"
        figure.add_shape(
            type="line",
            x0=mark.t,
            x1=mark.t,
            y0=0,
            y1=1,
            yref="y domain",
            line={"color": _COLOUR, "width": 1, "dash": "dot" if mark.ends else "solid"},
            label={
                "text": mark.text,
                "textangle": -90,
                "textposition": "end",
                "xanchor": "right",
                "yanchor": "top" if mark.t - begin < _NEAR * (end - begin) else "bottom",
                "font": {"size": 9, "color": _COLOUR},
            },
            name=group,
            legendgroup=group,
            showlegend=mark.ends not in in_legend,
        )
        in_legend.add(mark.ends)
