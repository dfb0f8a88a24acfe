"""Where the vehicle was, and how far that is from where it believed to be and from where it was to go."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firmware_py.records.order import MissionChange, Mode
from sternplane.logs.reading import Columns, Log, Piece
from sternplane.logs.run import Run

Array = npt.NDArray[Any]


class Planned(NamedTuple):
    """The waypoints (x, y, z, u) of a mission, (n, 4), and the cycles from `begin` up to `end` in which it stood."""

    begin: int
    end: int
    waypoints: Array


def missions(log: Run) -> list[Planned]:
    """Every mission of a run: the header's, and those that stations sent meanwhile."""
    found = [(0, log.header.get("mission", {}).get("waypoints", ()))]
    for t_ns, changes in log.changes.items():
        at = log.row(t_ns)
        flown = [change.mission for change in changes if isinstance(change, MissionChange)]
        found += [(at, [waypoint[:4] for waypoint in mission.waypoints]) for mission in flown]
    ends = [begin for begin, _ in found[1:]] + [log.count]
    return [
        Planned(begin, end, np.array(waypoints, dtype=float).reshape(-1, 4))
        for (begin, waypoints), end in zip(found, ends, strict=True)
    ]


class FlownMissions:
    """Which of a run's missions were flown, and how far; it is shown the pieces of the log one after the other."""

    def __init__(self, log: Run) -> None:
        self._planned = missions(log)
        self._flown = [False] * len(self._planned)
        self._done = [False] * len(self._planned)
        self._passed = [0] * len(self._planned)

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        c = piece.columns
        flying = c["mode.mode"] == Mode.MISSION
        for i, (begin, end, _) in enumerate(self._planned):
            part = slice(max(begin - piece.begin, 0), max(end - piece.begin, 0))
            self._done[i] |= bool(c["mode.mission_done"][part].any())
            if flying[part].any():
                self._flown[i] = True
                passed = c["reference.waypoint"][part][flying[part]]
                self._passed[i] = max(self._passed[i], int(passed.max()))

    @property
    def last(self) -> Planned:
        """The mission that was flown last; where none was, the one that stood at the end."""
        return self._planned[self._last]

    @property
    def passed(self) -> tuple[int, int]:
        """How many legs of it were flown to their end, of how many."""
        total = len(self.last.waypoints)
        return (total if self._done[self._last] else min(self._passed[self._last], total)), total

    @property
    def _last(self) -> int:
        return next((i for i in reversed(range(len(self._flown))) if self._flown[i]), len(self._planned) - 1)


_HELD = (Mode.HOLD, Mode.MISSION, Mode.LOITER, Mode.GUIDED, Mode.RETURN)


def depth_flown(c: Columns) -> Array:
    """Return in which cycles a depth is flown: coming up is steered by pitch, towards a reference above the water."""
    flown: Array = np.isin(c["mode.mode"], _HELD)
    return flown


def held_cycles(c: Columns) -> Array:
    """Return in which cycles the vehicle is armed, and depth and heading are held."""
    held: Array = c["applied.armed"] & depth_flown(c)
    return held


def pose_of(piece: Piece) -> Columns:
    """The true pose at each cycle, or where nobody knew it the estimated one by the names that the truth has."""
    return piece.truth or {name: piece.columns[f"state.{name}"] for name in ("eta.x", "eta.y", "eta.z", "eta.psi")}


def navigation_error(piece: Piece) -> Array:
    """Horizontal distance from the estimate to the truth, m, at each cycle; empty without truth."""
    c, truth = piece.columns, piece.truth
    if not truth:
        return np.empty(0)
    away: Array = np.hypot(c["state.eta.x"] - truth["eta.x"], c["state.eta.y"] - truth["eta.y"])
    return away


class FirstFix:
    """Since when fixes have told the position; it is shown the pieces of the log one after the other.

    Attributes:
        t: when the first fix was taken, s: one came, and the position's sigma fell. NaN before that.
    """

    def __init__(self) -> None:
        self.t = math.nan
        self._std = math.nan

    def taken(self, piece: Piece) -> Array:
        """Return in which cycles of the next piece a fix has been taken, or was before."""
        c = piece.columns
        falls = np.diff(c["state.position_std"], prepend=self._std) < 0.0
        self._std = float(c["state.position_std"][-1])
        told = np.flatnonzero(falls & c["frame.fix.fresh"])
        if math.isnan(self.t) and told.size:
            self.t = float(c["t"][told[0]])
        since: Array = c["t"] >= self.t
        return since


def depth_estimate_error(piece: Piece) -> Array:
    """Distance from the estimated depth to the true one, m, at each cycle; empty without truth."""
    if not piece.truth:
        return np.empty(0)
    off: Array = np.abs(piece.columns["state.eta.z"] - piece.truth["eta.z"])
    return off


def heading_estimate_error(piece: Piece) -> Array:
    """Estimated heading minus the true one, degrees, in the cycles in which it is held; empty without truth."""
    return _heading_error(piece, "state.eta.psi", held_cycles(piece.columns))


def ahrs_heading_error(piece: Piece) -> Array:
    """What the AHRS tells minus the true heading, degrees, when it is heard in those cycles; empty without truth."""
    c = piece.columns
    return _heading_error(piece, "frame.ahrs.value.psi", held_cycles(c) & c["frame.ahrs.fresh"])


def _heading_error(piece: Piece, name: str, when: Array) -> Array:
    return wrapped_deg(piece.columns[name] - piece.truth["eta.psi"])[when] if piece.truth else np.empty(0)


class PathError:
    """The horizontal distance to the planned path, of one piece of a log after the other.

    The path runs straight from where the vehicle was when MISSION was entered, through the waypoints that were still
    to be passed, and on beyond the last. It is planned anew each time MISSION is entered, after each manoeuvre, and for
    each mission that a station sends. The distance is to the nearest point of any leg, so that rounding a corner counts
    as what it leaves out, and passing from leg to leg as nothing.
    """

    def __init__(self, log: Run) -> None:
        self._missions = missions(log)
        self._path: Array | None = None
        self._passed = 0

    def of(self, piece: Piece) -> Array:
        """Return the distance, m, at each cycle of the next piece; NaN while no leg of a mission is flown."""
        c, pose = piece.columns, pose_of(piece)
        flying = (c["mode.mode"] == Mode.MISSION) & np.isfinite(c["reference.cross_track"])
        places, waypoint = np.column_stack((pose["eta.x"], pose["eta.y"])), c["reference.waypoint"]
        away = np.full(len(places), np.nan)
        for first, last, points in self._missions:
            low, high = np.clip((first - piece.begin, last - piece.begin), 0, len(places))
            if low == high:
                continue
            if first >= piece.begin:
                self._path = None
            edges = np.flatnonzero(np.diff(flying[low:high], prepend=False, append=False)) + low
            for begin, end in edges.reshape(-1, 2) if len(points) else ():
                if begin > 0 or self._path is None:
                    before = int(waypoint[begin - 1]) if begin > 0 else self._passed
                    passed = before if begin + piece.begin > first else 0
                    self._path = np.vstack((places[begin], points[min(passed, len(points) - 1) :, :2]))
                away[begin:end] = distance(places[begin:end], self._path)
            if not flying[high - 1]:
                self._path = None
        self._passed = int(waypoint[-1])
        return away


def path_error(log: Run, columns: Columns, pose: Columns) -> Array:
    """Return the distance of `PathError` for all cycles of a log at once, with "eta.x" and "eta.y" at each cycle."""
    return PathError(log).of(Piece(0, columns, pose))


def true_columns(log: Log) -> Columns:
    """The plant's state at each cycle: the last one logged at or before it. Empty when there is none."""
    (piece,) = log.pieces()
    return piece.truth


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


class UnwrappedHeading:
    """Headings without jumps, degrees, from one piece of a log to the next; NaN stays."""

    def __init__(self) -> None:
        self._before: list[float] = []

    def of(self, psi: Array) -> Array:
        """Return those of the next piece, rad."""
        degrees: Array = np.degrees(psi)
        finite = np.isfinite(degrees)
        if finite.any():
            known = np.concatenate((self._before, degrees[finite]))
            degrees[finite] = np.unwrap(known, period=360.0)[len(self._before) :]
            self._before = [float(degrees[finite][-1])]
        return degrees


def surplus_turns(degrees: Array) -> float:
    """Return what has to be taken from headings without jumps so that most are in [-45, 315), degrees."""
    finite = degrees[np.isfinite(degrees)]
    return 360.0 * math.floor((float(np.median(finite)) + 45.0) / 360.0) if finite.size else 0.0


def unwrapped_deg(psi: Array) -> Array:
    """Radians to degrees without jumps, most of them in [-45, 315); NaN stays."""
    degrees = UnwrappedHeading().of(psi)
    return degrees - surplus_turns(degrees)
