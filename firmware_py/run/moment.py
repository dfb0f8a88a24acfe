"""The present moment as the computer's clocks tell it, and how long ago another one was."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

TIMES = {"utc_s": (0.0, 1e11), "uptime_s": (0.0, 1e11)}
"""Bounds of the numbers of a moment that a file tells."""
_CLOCK_SET = 1_704_067_200.0
"""2024-01-01 in UTC; a clock that shows less was never set."""


class Moment(NamedTuple):
    """The time, as the computer's clocks tell it: UTC, s; which start of the computer this is; time since it, s."""

    utc_s: float
    boot: str
    uptime_s: float


def moment() -> Moment:
    """Return the present moment."""
    return Moment(time.time(), _boot(), time.clock_gettime(time.CLOCK_BOOTTIME))


def time_since(found: Mapping[str, Any], clock_kept: bool, now: Moment) -> float:
    """Return the time since a moment that was kept, s; NaN if it is not known, as after one whose clock was set back.

    Args:
        found: with the moment's fields; without, it is not known.
        clock_kept: whether the computer's clock goes on without power.
        now: the present moment.
    """
    if "boot" not in found:
        return math.nan
    if now.boot and found["boot"] == now.boot:  # its clock may have been set meanwhile, from 1970 to now
        passed = float(now.uptime_s - found["uptime_s"])
        return passed if passed >= 0.0 else math.nan
    gap: float = now.utc_s - found["utc_s"]
    return gap if gap >= 0.0 and clock_kept and found["utc_s"] > _CLOCK_SET else math.nan


@functools.cache
def _boot() -> str:
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return ""
