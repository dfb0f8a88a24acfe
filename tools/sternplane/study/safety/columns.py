"""The columns of the matrix: how a flight may end, with the symbol and the colour of each; the marks beside them."""

from __future__ import annotations

from typing import NamedTuple

from sternplane.study.safety.judge import TOO_DEEP, Ending
from sternplane.study.safety.mission import DEPTH_MAX


class Column(NamedTuple):
    """An outcome in the matrix."""

    ending: Ending
    symbol: str
    head: str
    mood: str
    meaning: str


COLUMNS = (
    Column(Ending.FLOWN, "✓", "mission flown", "good", "the mission was flown to its end, and the vehicle came up"),
    Column(Ending.UP, "▲", "came up", "good", "a rule brought it up, with its weight"),
    Column(Ending.DROPPED, "△", "up, weight dropped", "fair", "it came up without its drop weight"),
    Column(
        Ending.BELOW,
        "◐",
        "below, told",
        "warn",
        "below the surface at the end; the weight is released, or it says that it does not come up",
    ),
    Column(
        Ending.LOST,
        "?",
        "below, not told",
        "bad",
        "unsafe: below the surface at the end, and it does not say why, or says that it has surfaced",
    ),
    Column(
        Ending.DEEP,
        "▼",
        "too deep",
        "bad",
        f"unsafe: deeper than {DEPTH_MAX + TOO_DEEP:g} m, the limit and {TOO_DEEP:g} m",
    ),
    Column(Ending.AGROUND, "⊥", "aground", "bad", "unsafe: it touched the bottom"),
    Column(Ending.NOT_FINITE, "∞", "not finite", "bad", "unsafe: a command was no number"),
)
COLUMN_OF = {column.ending: column for column in COLUMNS}
ACCUSED, ENDED = "≠", "⇡"
"""Marks of flights that name something sound, and of those that a rule ended without cause."""


def words(cause: str) -> str:
    """Return the name of a cause or fault as words."""
    return cause.lower().replace("_", " ")
