"""What was lost on wires and links in a run, and when."""

from __future__ import annotations

from sternplane.logs.run import Run


def losses(log: Run) -> dict[str, int]:
    """Return all counts: of the end record, or those logged last if the log was cut off."""
    last: dict[str, int] = {}
    for _, counts in log.losses:
        last |= counts
    return {**last, **log.end.get("losses", {})}


def times(log: Run) -> dict[str, list[float]]:
    """Return by name the times at which a count was first and last seen to have risen, s."""
    seen: dict[str, list[float]] = {}
    for t, counts in log.losses:
        for name in counts:
            seen.setdefault(name, [t, t])[1] = t
    return seen
