"""Where injected faults begin and end: numbered lines across the plots over time, and what each number means."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from sternplane.logs.true_coefficients import faults_of

_COLOUR = "#dc2626"
_NEAR = 0.025
"""Nearer to the mark before it than this share of a plot a number stands higher, so that neither hides the other."""
_RAISED_PX = 15
_LEGEND = 1.13
"""Where the legend begins, to leave room for the numbers: heights of the plot above its foot."""
_MOST = 40
"""More lines than these hide what they cross."""


class Mark(NamedTuple):
    """A time, s, at which faults begin or end: its number, from 1, and which; `ends`: none begins."""

    number: int
    t: float
    ends: bool
    text: str

    @property
    def told(self) -> str:
        """Return what happens, with the time."""
        return f"{self.t:g} s: {self.text}"


def fault_marks(header: Mapping[str, Any], t_end: float) -> list[Mark]:
    """Return the marks of a log's faults up to a time, s; what this version does not know is left out."""
    found: dict[float, list[tuple[bool, str]]] = {}
    for fault in faults_of(header):
        name = fault.text.partition("@")[0]
        for t, ends, words in ((fault.t, False, name), (fault.t + fault.duration, True, f"{name} ends")):
            if t <= t_end:
                found.setdefault(t, []).append((ends, words))
    marks = []
    for number, (t, those) in enumerate(sorted(found.items())[:_MOST], 1):
        those.sort(key=lambda one: one[0])
        marks.append(Mark(number, t, those[0][0], ", ".join(words for _, words in those)))
    return marks


def key(marks: Iterable[Mark]) -> list[tuple[str, str]]:
    """Return (number, what happens) of each, for the page."""
    return [(str(mark.number), mark.told) for mark in marks]


def draw(figure: Any, marks: Sequence[Mark]) -> None:
    """Draw them into a plot over time, each with its number above the plot; the pointer shows what it means."""
    begin, end = figure.layout.xaxis.range
    before, raised = -float("inf"), False
    for mark in marks:
        raised = not raised and mark.t - before < _NEAR * (end - begin)
        before = mark.t
        figure.add_shape(
            type="line",
            x0=mark.t,
            x1=mark.t,
            y0=0,
            y1=1,
            yref="y domain",
            line={"color": _COLOUR, "width": 1, "dash": "dot" if mark.ends else "solid"},
            name="fault ends" if mark.ends else "fault begins",
        )
        figure.add_annotation(
            x=mark.t,
            y=1,
            yref="y domain",
            yanchor="bottom",
            yshift=_RAISED_PX * raised,
            text=str(mark.number),
            hovertext=mark.told,
            showarrow=False,
            borderpad=1,
            bgcolor="#fee2e2",
            font={"size": 10, "color": "#991b1b"},
        )
    if marks:
        figure.update_layout(legend={"y": _LEGEND})
