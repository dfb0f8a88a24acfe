"""The witness of a flight whose disk is full: it tells what the log cannot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.event_text import texts
from sternplane.logs.after_log import AfterLog, place_of

_UNWRITTEN = 1.0
"""A log loses more than what comes after its disk is full: what was not written by then, s."""


class UnloggedFlight:
    """What happens from shortly before a disk is full, s.

    Args:
        full_at: when it is, s.
        why: what is said of it, behind "because".
    """

    def __init__(self, full_at: float, why: str) -> None:
        self._begin, self._why = full_at - _UNWRITTEN, why
        self._last: tuple[Cycle, float] | None = None
        self._deepest = (-math.inf, math.nan)
        self._deepest_estimate = -math.inf
        self._passed = 0
        self._events: list[tuple[float, str]] = []

    def see(self, cycle: Cycle, true_depth: float | None = None) -> None:
        """Take a cycle in, and the true depth at its tick, m, if it is known."""
        t, estimate = cycle.tick.t, cycle.state.eta.z
        for event in cycle.events:
            if event.kind is EventKind.WAYPOINT_PASSED:
                self._passed = round(event.numbers[0])
        if t < self._begin:
            return
        depth = estimate if true_depth is None else true_depth
        self._last = cycle, depth
        self._events += [(t, text) for text in texts(cycle.events)]
        if depth > self._deepest[0]:
            self._deepest = depth, t
        self._deepest_estimate = max(self._deepest_estimate, estimate)

    def leave(self, log: Path, end: Mapping[str, Any]) -> None:
        """Write it beside a log whose end record would have been `end`.

        Raises:
            OSError: it cannot be written.
        """
        if self._last is None:
            return
        cycle, depth = self._last
        found = AfterLog(
            why=self._why,
            end=dict(end),
            t_end=cycle.tick.t + cycle.tick.dt_ns * 1e-9,
            mode=cycle.mode.mode.name.lower(),
            depth=depth,
            depth_max=self._deepest[0],
            depth_max_at=self._deepest[1],
            depth_max_estimate=self._deepest_estimate,
            waypoints_passed=self._passed,
            events=self._events,
        )
        write_atomically(place_of(log), found.text().encode())
