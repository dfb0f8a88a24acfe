"""Which flights of a sweep were the worst: those that failed, and then those of the greatest error."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from typing import Any

from firmware_py.run.usage_error import UsageError

Row = Mapping[str, Any]
_JUDGED = ("path_error_rms_m", "depth_tracking_error_rms_m", "heading_tracking_error_rms_deg", "navigation_error_end_m")
"""What flights are judged by, unless a person says otherwise: the first that any flight has."""


USEFUL = (
    *_JUDGED,
    *("path_error_max_m", "depth_estimate_error_max_m", "navigation_error_max_m", "fin_travel_deg_s", "vehicle_time_s"),
    *("overshoot_first_deg", "turning_diameter_m", "learned.mean_square_error_sigmas"),
)
"""Columns that people judge by; `--help` names them."""


def judged_by(rows: Sequence[Row], wanted: str | None) -> str:
    """Return the column that flights are judged by, the greater the worse; "" if there is none.

    Raises:
        UsageError: no flight has the one that is wanted.
    """
    if wanted is None:
        return next((name for name in _JUDGED if any(row.get(name) is not None for row in rows)), "")
    if not any(isinstance(row.get(wanted), int | float) for row in rows):
        raise _unknown(rows, wanted)
    return wanted


def refuse_unknown(rows: Sequence[Row], wanted: str | None) -> None:
    """Refuse a column to judge by that the flights so far do not have, before any more are flown.

    One that is empty so far may have a number in another flight, and so may what stands below an empty one: a flight in
    which nothing was adopted has no figures of its laws.

    Raises:
        UsageError: with those that are meant, perhaps.
    """
    flown = [row for row in rows if not row["error"]]
    if wanted is None or not flown:
        return
    parts = wanted.split(".")
    names = {".".join(parts[:i]) for i in range(1, len(parts) + 1)}
    if not any(name in row and (row[name] is None or _is_number(row, name, wanted)) for row in flown for name in names):
        raise _unknown(flown, wanted)


def _is_number(row: Row, name: str, wanted: str) -> bool:
    return name == wanted and isinstance(row[name], int | float)


def _unknown(rows: Sequence[Row], wanted: str) -> UsageError:
    known = sorted({name for row in rows for name, value in row.items() if isinstance(value, float)})
    near = difflib.get_close_matches(wanted, known, n=3, cutoff=0.5) or [name for name in known if wanted in name][:3]
    meant = f"did you mean {', '.join(near)}?" if near else f"such as {', '.join(n for n in USEFUL[:5] if n in known)}"
    return UsageError(f"--judge {wanted}: no flight has such a number; {meant}; sternplane sweep --help tells more")


def worst(rows: Sequence[Row], judge: str, most: int) -> list[Row]:
    """Return the worst flights, the worst first, of equals the first: `most` with an error, and `most` that flew."""
    ordered = sorted(rows, key=lambda row: (-badness(row), -figure_of(row, judge), row["flight"]))
    return [row for row in ordered if row["error"]][:most] + [row for row in ordered if not row["error"]][:most]


def badness(row: Row) -> int:
    """Return 0 for a completed flight, 1 for one that came up safely, 2 for one that did not, 3 for an error."""
    if row["error"]:
        return 3
    return 0 if row["completed"] else 1 if row.get("surfaced") else 2


def outcome_text(row: Row) -> str:
    """Return how a flight ended."""
    if row["error"]:
        return f"error: {row['error']}"
    if row["completed"]:
        return "completed"
    return f"{'came up: ' if row.get('surfaced') else 'failed: '}{row.get('reason', '')}"


def figure_of(row: Row, judge: str) -> float:
    """Return the figure of a flight that it is judged by; -inf where it has none."""
    value = row.get(judge)
    return float(value) if isinstance(value, int | float) else -math.inf
