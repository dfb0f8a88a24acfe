"""The plots of what sensors of one's own said: one for each key."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from sternplane.logs.run import Run
from sternplane.logs.tracking import Array
from sternplane.report.drawing import ESTIMATE, Plot, line

SECTION = "Payload"
_MOST_KEYS = 24
"""So many keys are drawn, those that came first."""
_MOST_POINTS = 4000


class _Line:
    """The numbers of a key over time; of more than `_MOST_POINTS` the least and the greatest of neighbours are kept."""

    def __init__(self) -> None:
        self._t: list[float] = []
        self._values: list[float] = []

    def add(self, t: float, value: float) -> None:
        """Take one in."""
        self._t.append(t)
        self._values.append(value)
        if len(self._t) >= 2 * _MOST_POINTS:
            self._thin()

    @property
    def points(self) -> tuple[Array, Array]:
        """Times, s, and values."""
        return np.array(self._t), np.array(self._values)

    def _thin(self) -> None:
        """Keep two of each four: the least and the greatest, in their order; what is no number is neither."""
        t, values = (one.reshape(-1, 4) for one in self.points)
        unknown = np.isnan(values)
        low, high = (np.where(unknown, end, values) for end in (np.inf, -np.inf))
        ends = np.sort(np.stack((low.argmin(axis=1), high.argmax(axis=1)), axis=1), axis=1)
        self._t, self._values = (np.take_along_axis(one, ends, axis=1).ravel().tolist() for one in (t, values))


def payload_plots(log: Run, figure: Callable[[str], Any]) -> Iterator[Plot]:
    """Yield them; none where no such sensor was heard.

    Args:
        log: the flight.
        figure: makes an empty plot over time with a y axis of that name.
    """
    lines: dict[str, _Line] = {}
    more = False
    for _, readings in log.payload_messages():
        for key, value, t in readings:
            if key in lines or len(lines) < _MOST_KEYS:
                lines.setdefault(key, _Line()).add(t, value)
            else:
                more = True
    for key, drawn in lines.items():
        plot = figure("value")
        line(plot, *drawn.points, "value", ESTIMATE, mode="lines+markers", marker={"size": 3})
        note = "As a sensor of one's own sent it, in the unit that belongs to it; by the time at which it was true."
        left_out = " The log has more keys than are drawn." if more else ""
        yield Plot(key, f"{note}{left_out}", plot, section=SECTION)
