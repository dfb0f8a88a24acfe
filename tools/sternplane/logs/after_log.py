"""What became of a flight whose log had ended before it, as a small file beside the log tells."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from sternplane.logs.run import Run

_ROUNDED = 1e-6
"""A time may be rounded by so much, s."""


class AfterLog(NamedTuple):
    """The rest of a flight.

    Attributes:
        why: the reason for which the log ended, as words behind "because".
        end: what the log's end record would have been.
        t_end: when the flight ended, s.
        mode: in which mode it ended.
        depth: true depth at the end, m; the estimate where the plant was elsewhere.
        depth_max: greatest true (or estimated) depth; `depth_max_at`: when, s; `depth_max_estimate`: the estimate's.
        waypoints_passed: the last of them; 0 for none.
        events: (vehicle time, s; sentence), some of which the log may have too.
    """

    why: str
    end: dict[str, Any]
    t_end: float
    mode: str
    depth: float
    depth_max: float
    depth_max_at: float
    depth_max_estimate: float
    waypoints_passed: int
    events: list[tuple[float, str]]

    def text(self) -> str:
        """Return it as JSON."""
        return f"{json.dumps(self._asdict(), indent=1, ensure_ascii=False)}\n"

    def in_summary(self, logged: list[tuple[float, str]], figures: dict[str, Any]) -> dict[str, Any]:
        """Return what it tells, by the names in summary.json, with what the log tells: its events and figures."""
        t, deeper = figures["logged_s"], not self.depth_max <= figures["depth_max_m"]
        return {
            "after_log": {"why": self.why, "mode": self.mode, "depth_m": self.depth},
            "ended": {"mode": self.mode, "north_m": None, "east_m": None, "depth_m": self.depth},
            "depth_max_m": self.depth_max if deeper else figures["depth_max_m"],
            "depth_max_at_s": self.depth_max_at if deeper else figures["depth_max_at_s"],
            "depth_max_estimate_m": max(self.depth_max_estimate, figures["depth_max_estimate_m"]),
            "waypoints_passed": self.waypoints_passed,
            "events": [[t, text] for t, text in (*logged, *(one for one in self.events if one[0] >= t - _ROUNDED))],
        }


def place_of(log: Path) -> Path:
    """Return where it lies: beside the log, by its name."""
    return log.with_suffix(".after.json")


def after_log(log: Run) -> AfterLog | None:
    """Return what came after the end of a log that is not whole; None where nothing is known of it."""
    if not log.lost:
        return None
    try:
        return AfterLog(**json.loads(place_of(log.path).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
