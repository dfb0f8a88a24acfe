"""The plot of what the laws were designed from: effect of the fins over that of the vehicle file, and the caution."""

from __future__ import annotations

from typing import Any

import numpy as np

from firmware_py.records.adoption import Source
from sternplane.logs.reading import Columns
from sternplane.logs.tracking import Array
from sternplane.report.drawing import ESTIMATE, Plot, line, minimum_height

TITLE = "Design of the laws"
_LAWS = (("depth", ESTIMATE), ("heading", "#059669"))
_CAUTION = "#94a3b8"
_MOST = 8
"""So many changes are told."""
_WORDS = {
    Source.FILE: "vehicle file",
    Source.PASSPORT: "earlier flight",
    Source.LEARNED: "learned",
    Source.LAST_GOOD: "learned earlier",
    Source.NOMINAL: "back to the vehicle file",
}


def design_plot(c: Columns, section: str, figure: Any) -> Plot | None:
    """Return what was in force over the run; None for a log that does not tell, or where nothing was ever adopted."""
    sources = {law: c.get(f"adopted.{law}.source", np.empty(0)) for law, _ in _LAWS}
    if not any((source != Source.FILE).any() for source in sources.values()):
        return None
    t, told = c["t"].astype(np.float32), []
    for law, colour in _LAWS:
        authority = c[f"adopted.{law}.authority"]
        line(figure, t, authority / authority[0], f"{law}: fins, over the vehicle file", colour)
        told.append(f"{law.capitalize()} law: {_history(t, sources[law])}")
    line(figure, t, c["adopted.caution"], "caution", _CAUTION, dash="dot")
    minimum_height(figure, 1.0)
    note = (
        "What the fins do to the vehicle's rate of turn, as the laws have it: 1 is the vehicle file. "
        "Caution slows references and widens turns. "
    )
    return Plot(TITLE, note + ". ".join(told) + ".", figure, section=section)


def _history(t: Array, source: Array) -> str:
    """Return what the design came from, one after the other, with the times."""
    begins = [0, *(np.flatnonzero(np.diff(source)) + 1).tolist()]
    words = [f"{_WORDS[Source(int(source[i]))]}{f' from {t[i]:.1f} s' if i else ''}" for i in begins]
    return ", ".join(words[:_MOST]) + (f", and {len(words) - _MOST} more changes" if len(words) > _MOST else "")
