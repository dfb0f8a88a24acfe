"""What is wrong after a kill: with the next start, its position, the logs that are left."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from firmware_py.app import build
from sternplane.kill.processes import Process
from sternplane.logs.reading import Columns, Log, read
from sternplane.logs.replay import replay
from sternplane.logs.tracking import Array

_LOST_MAX = 1.0
"""So much of a log may be lost, s."""
_SIGMAS_MAX = 3.0
_RESTART_S = 6.0
"""A vehicle that is under water for so long after the next start comes up by itself, if it was armed before."""
_SURELY_UNDER, _UP = 1.5, 1.0
"""Depths, m: one that is surely under water, and one less than which is up."""


def no_start(process: Process) -> dict[str, Any]:
    """Return the figures of a trial whose next process does not work."""
    return {"wrong": ["the next start does not work"], "said": process.said}


def wrong(*logs: Log, lost: float, sigmas: float = 0.0) -> list[str]:
    """Return what is wrong; nothing for a trial as it should be. What is not a number is wrong.

    Args:
        logs: each must replay to the bit.
        lost: how much of the killed one's log is lost, s.
        sigmas: how far off the next one is, in its own sigma; 0 where that is not judged.
    """
    found = ["confidently lost"] if not sigmas <= _SIGMAS_MAX else []
    if not lost <= _LOST_MAX:
        found.append("more of the log is lost")
    results = [replay(log, build) for log in logs]
    return found + [str(result) for result in results if not result.equal]


def left_down(armed: bool, t: Array, z: Array, moved: bool) -> list[str]:
    """Return what is wrong with where the next start leaves the vehicle.

    Args:
        armed: whether it was, when its program was killed.
        t: since the next start, s.
        z: true depths then, m.
        moved: whether the vehicle armed itself.
    """
    begun = z[t <= _RESTART_S]
    if armed and not begun.min() <= _SURELY_UNDER:
        return [] if moved and z[-1] < _UP else [f"stays under water, at {z[-1]:.1f} m"]
    return ["moves at the surface"] if moved and begun.max() < _UP else []


class Off(NamedTuple):
    """How far off an estimate is: in its own sigma, and both in m."""

    sigmas: float
    error: float
    sigma: float


def worst_of(found: Iterable[Off]) -> Off:
    """Return the one that is off by most in its own sigma; first of all one that is not a number."""
    return max(found, key=lambda one: (math.isnan(one.sigmas), one.sigmas))


def distance(truth: Columns, t: float, x: float, y: float) -> float:
    """Return how far a place is from the true one at a time of the plant, s."""
    true_x, true_y = (float(np.interp(t, truth["t"], truth[f"eta.{axis}"])) for axis in "xy")
    return math.hypot(x - true_x, y - true_y)


def last_time(log: Log) -> float:
    """Return the time of the last cycle, s."""
    return float(log.columns["t"][-1])


def read_log(folder: Path) -> Log:
    """Read the only log below a folder."""
    (path,) = folder.rglob("log.mcap")
    return read(path)
