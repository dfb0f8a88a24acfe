"""Where the vehicle was, and how far that is from where it believed to be and from where it was to go."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firmware_py.records.order import MissionChange, Mode
from sternplane.logs.reading import Columns, Log

Array = npt.NDArray[Any]


class Planned(NamedTuple):
    """The waypoints (x, y, z, u) of a mission, (n, 4), and the cycles from `begin` up to `end` in which it stood."""

    begin: int
    end: int
    waypoints: Array


def missions(log: Log) -> list[Planned]:
    """Every mission of a run: the header's, and those that stations sent meanwhile."""
    t, found = log.columns["t"], [(0, log.header.get("mission", {}).get("waypoints", ()))]
    for t_ns, changes in log.changes.items():
        at = int(np.searchsorted(t, t_ns * 1e-9))
        flown = [change.mission for change in changes if isinstance(change, MissionChange)]
        found += [(at, [waypoint[:4] for waypoint in mission.waypoints]) for mission in flown]
    ends = [begin for begin, _ in found[1:]] + [len(t)]
    return [
        Planned(begin, end, np.array(waypoints, dtype=float).reshape(-1, 4))
        for (begin, waypoints), end in zip(found, ends, strict=True)
    ]


def flown_last(log: Log) -> Planned:
    """The mission that was flown last; where none was, the one that stood at the end."""
    planned, flying = missions(log), log.columns["mode.mode"] == Mode.MISSION
    return next((it for it in reversed(planned) if flying[it.begin : it.end].any()), planned[-1])


def true_columns(log: Log) -> Columns:
    """The plant's state at each cycle: the last one logged at or before it. Empty when there is none."""
    truth, t = log.truth, log.columns["t"]
    if not truth or truth["t"][0] > t[0]:
        return {}
    at = np.searchsorted(truth["t"], t, side="right") - 1
    return {name: column[at] for name, column in truth.items()}


def believed_columns(log: Log) -> Columns:
    """The estimated pose at each cycle by the names that the truth has: "eta.x", "eta.y", "eta.z", "eta.psi"."""
    return {name: log.columns[f"state.{name}"] for name in ("eta.x", "eta.y", "eta.z", "eta.psi")}


def navigation_error(log: Log, truth: Columns) -> Array:
    """Horizontal distance from the estimate to the truth, m, at each cycle; empty without truth."""
    if not truth:
        return np.empty(0)
    c = log.columns
    away: Array = np.hypot(c["state.eta.x"] - truth["eta.x"], c["state.eta.y"] - truth["eta.y"])
    return away


def path_error(log: Log, pose: Columns) -> Array:
    """Return the horizontal distance to the planned path, m, at each cycle; NaN while no leg of a mission is flown.

    The path runs straight from where the vehicle was when MISSION was entered, through the waypoints that were still
    to be passed, and on beyond the last. It is planned anew each time MISSION is entered, after each manoeuvre, and for
    each mission that a station sends. The distance is to the nearest point of any leg, so that rounding a corner counts
    as what it leaves out, and passing from leg to leg as nothing.

    Args:
        log: the run.
        pose: "eta.x" and "eta.y" at each cycle, true or believed.
    """
    c = log.columns
    flying = (c["mode.mode"] == Mode.MISSION) & np.isfinite(c["reference.cross_track"])
    places = np.column_stack((pose["eta.x"], pose["eta.y"]))
    away = np.full(len(places), np.nan)
    for first, last, points in missions(log):
        waypoints = points[:, :2]
        legs = np.flatnonzero(np.diff(flying[first:last], prepend=False, append=False)) + first
        for begin, end in legs.reshape(-1, 2) if len(waypoints) else ():
            passed = int(c["reference.waypoint"][begin - 1]) if begin > first else 0
            path = np.vstack((places[begin], waypoints[min(passed, len(waypoints) - 1) :]))
            away[begin:end] = distance(places[begin:end], path)
    return away


def distance(places: Array, path: Array) -> Array:
    """How far places (n, 2) are from a path through at least two points (m, 2); its last leg has no end."""
    nearest = np.full(len(places), np.nan)
    legs = np.diff(path, axis=0)
    for i, (start, leg) in enumerate(zip(path, legs, strict=False)):
        share = (places - start) @ leg / (leg @ leg or 1.0)
        foot = start + np.outer(np.clip(share, 0.0, 1.0 if i + 1 < len(legs) else np.inf), leg)
        nearest = np.fmin(nearest, np.hypot(*(places - foot).T))
    return nearest


def wrapped_deg(angle: Array) -> Array:
    """Radians to degrees in [-180, 180)."""
    degrees: Array = (np.degrees(angle) + 180.0) % 360.0 - 180.0
    return degrees


def unwrapped_deg(psi: Array) -> Array:
    """Radians to degrees without jumps, most of them in [-45, 315); NaN stays."""
    degrees: Array = np.degrees(psi)
    finite = np.isfinite(degrees)
    if finite.any():
        degrees[finite] = np.unwrap(degrees[finite], period=360.0)
        degrees -= 360.0 * np.floor((np.median(degrees[finite]) + 45.0) / 360.0)
    return degrees
