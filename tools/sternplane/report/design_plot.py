"""The plot of what the laws were designed from: effect of the fins over that of the vehicle file, and the caution."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from firmware_py.records.adoption import Source
from sternplane.logs.adoption import ALL_LEARNED
from sternplane.logs.health_record import Timeline
from sternplane.logs.reading import Columns
from sternplane.report.drawing import ESTIMATE, Plot, line, minimum_height

TITLE = "Design of the laws"
_LAWS = (("depth", ESTIMATE), ("heading", "#059669"))
_CAUTION = "#94a3b8"
_MOST = 8
"""So many changes are told."""
_WORDS = {
    Source.FILE: "vehicle file",
    Source.PASSPORT: "earlier flight",
    Source.LEARNED: "part of it",
    Source.LAST_GOOD: "what was learned earlier",
    Source.NOMINAL: "back to the vehicle file",
    ALL_LEARNED: "all of it",
}


def design_plot(c: Columns, designs: Mapping[str, Timeline], section: str, figure: Any) -> Plot | None:
    """Return what was in force over the run; None for a log that does not tell, or where nothing was ever adopted.

    Args:
        c: columns of the cycles that are drawn.
        designs: by law, over all cycles, what it was designed from (`adoption.design_states`).
        section: of the plot.
        figure: an empty plot over time.
    """
    if not any(map(was_adopted, designs.values())):
        return None
    t, told = c["t"].astype(np.float32), []
    for law, colour in _LAWS:
        authority = c[f"adopted.{law}.authority"]
        line(figure, t, authority / authority[0], f"{law}: fins, over the vehicle file", colour)
        told.append(f"{law.capitalize()} law: {_history(designs[law])}")
    line(figure, t, c["adopted.caution"], "caution", _CAUTION, dash="dot")
    minimum_height(figure, 1.0)
    note = (
        "What the fins do to the vehicle's rate of turn, as the laws have it: 1 is the vehicle file. "
        "Caution slows references and widens turns. "
    )
    return Plot(TITLE, note + ". ".join(told) + ".", figure, section=section)


def was_adopted(design: Timeline) -> bool:
    """Return whether a law ever was designed from anything else than the vehicle file."""
    return not design.durations.keys() <= {Source.FILE}


def _history(design: Timeline) -> str:
    """Return what the design came from, one after the other, with the times; the first values that were learned so."""
    words, known = [], False
    for span in design.spans:
        first = span.value == Source.LEARNED and not known
        known |= span.value in (Source.LEARNED, ALL_LEARNED)
        words.append(f"{'first values' if first else _WORDS[span.value]}{f' {span.begin:.1f} s' if span.begin else ''}")
    return ", ".join(words[:_MOST]) + (f", and {len(words) - _MOST} more changes" if len(words) > _MOST else "")
