"""What a log is exported as in MCAP files of others: topics, each with the message of a cycle, in the frames of ROS.

Times are those of the ticks, from 0 at the begin of the flight; the stamp of a measurement is when it was true. What is
not known, such as a pose before attitude was heard, has no message.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from firmware_py import config_files
from firmware_py.marine import Origin, local_to_geodetic
from firmware_py.records.event import Severity
from firmware_py.records.event_text import sentences
from sternplane.logs.export.ros_frames import Quaternion, Vector, orientation, world_vector
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import missions

Stamp = tuple[int, int]
"""Seconds, and nanoseconds within [0, 1e9)."""
Row = Callable[[int], tuple[Any, ...] | None]
_NS = 1_000_000_000
_PLACES_HZ = 10.0
"""So often a map is told where the vehicle is."""


class Stream(NamedTuple):
    """A topic: which message it has, and what is in it in a row of a piece; None: there is none."""

    topic: str
    message: str
    row: Row


def stamp(t_ns: int) -> Stamp:
    """Return a time of the flight, ns, as messages have it."""
    return divmod(t_ns, _NS)


def stamp_of(t: float) -> Stamp:
    """Return a time of the flight, s, as messages have it."""
    return stamp(round(t * 1e9))


class Pose(NamedTuple):
    """Where a body is in ENU, m, and how it lies there, from FLU."""

    position: Vector
    orientation: Quaternion


class Rows:
    """The columns of a piece, row by row."""

    def __init__(self, piece: Piece) -> None:
        self._columns, self.truth = piece.columns, piece.truth
        ticks = zip(piece.columns["tick.k"].tolist(), piece.columns["tick.dt_ns"].tolist(), strict=True)
        self.t_ns: list[int] = [k * dt_ns for k, dt_ns in ticks]
        self.stamps = [stamp(t) for t in self.t_ns]
        self.places_every = max(1, round(1e9 / _PLACES_HZ / float(piece.columns["tick.dt_ns"][0])))

    def of(self, *paths: str) -> list[tuple[Any, ...]]:
        """Return the numbers of some fields together, for each row."""
        return _together(self._columns, paths)

    def of_truth(self, *paths: str) -> list[tuple[Any, ...]]:
        """Return those of the truth."""
        return _together(self.truth, paths)

    def poses(self, *, true: bool = False) -> list[Pose | None]:
        """Return the estimated or true pose in each row; None where it is not known."""
        names = [f"eta.{one}" for one in ("x", "y", "z", "phi", "theta", "psi")]
        rows = self.of_truth(*names) if true else self.of(*(f"state.{name}" for name in names))
        return [_pose(row) if all(map(math.isfinite, row)) else None for row in rows]

    def heard(self, sensor: str, *values: str) -> list[tuple[Stamp, tuple[float, ...]] | None]:
        """Return when it was true and what a sensor measured, in the rows in which it was heard and vouched for it.

        `values` are the names of its numbers, none for one that has a single one. The other rows have None.
        """
        paths = [f"frame.{sensor}.value.{name}" for name in values] or [f"frame.{sensor}.value"]
        rows = self.of(*(f"frame.{sensor}.{name}" for name in ("fresh", "ok", "t_valid")), *paths)
        return [
            (stamp_of(t), tuple(measured)) if fresh and ok and all(map(math.isfinite, (t, *measured))) else None
            for fresh, ok, t, *measured in rows
        ]


def _together(columns: Columns, paths: Sequence[str]) -> list[tuple[Any, ...]]:
    return list(zip(*(columns[path].tolist() for path in paths), strict=True))


def _pose(eta: Sequence[float]) -> Pose:
    x, y, z, phi, theta, psi = eta
    return Pose(world_vector(x, y, z), orientation(phi, theta, psi))


class World:
    """The local frame on the earth."""

    def __init__(self, log: Run) -> None:
        params = config_files.autopilot_params(log.header["configuration"])
        self._origin = Origin(params.origin.latitude, params.origin.longitude)
        self.surface = params.mavlink.telemetry.surface_altitude

    def degrees(self, x: float, y: float) -> tuple[float, float]:
        """Return latitude and longitude, degrees, of a place in the local frame, m."""
        latitude, longitude = local_to_geodetic(self._origin, x, y)
        return math.degrees(latitude), math.degrees(longitude)


class Told(NamedTuple):
    """An event for people."""

    t_ns: int
    text: str
    severity: Severity


def events_of(log: Run) -> list[Told]:
    """Return the events of a log in their order."""
    return [Told(round(t * 1e9), *sentence) for t, events in log.events for sentence in sentences(events)]


def plans_of(log: Run) -> dict[int, list[tuple[float, float, float]]]:
    """Return the waypoints (x, y, z), m, of each mission by the cycle from which on it stands."""
    return {begin: [(x, y, z) for x, y, z, _ in points.tolist()] for begin, _, points in missions(log) if len(points)}
