"""What is drawn of a run: as many points as a screen shows, with the least and the greatest value of those left out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from firmware_py.records.order import Mode
from sternplane.logs.adoption import design_states
from sternplane.logs.health_record import HealthRecord, Timeline
from sternplane.logs.lateness_histogram import LatenessHistogram, LatenessRecord
from sternplane.logs.learned import LearnedFigures
from sternplane.logs.learning_reasons import LearningReasons
from sternplane.logs.mean import Mean
from sternplane.logs.reading import Columns, Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import (
    Array,
    FlownMissions,
    PathError,
    Planned,
    UnwrappedHeading,
    ahrs_heading_error,
    depth_flown,
    heading_estimate_error,
    navigation_error,
    pose_of,
    surplus_turns,
    wrapped_deg,
)

_MOST_HZ = 10.0
_PLAN_FINER, _LONG = 4, 40
"""A plan view has so many times the points of the other plots, where a stride is longer than that."""
_REFERENCES = ("reference.z_d", "reference.psi_d", "reference.u_d")
"""What is a reference only while somebody steers by it; in MANUAL and DISARMED it goes along with the vehicle."""
_DEPTH = "reference.z_d"
"""Of these the one that is none in SURFACE either."""
_LINES = ("state.eta.z", "state.eta.phi", "state.eta.theta", "state.nu.u", "reference.z_d", "reference.u_d")
_TRUE_LINES = ("eta.z", "eta.phi", "eta.theta", "nu.u")
_COMMANDED, _REPORTED = ("applied.fins", "applied.n"), ("frame.fins", "frame.n")
_SILENT = 1.0
"""What an actuator reported so long ago, s, is no longer drawn."""
_SAMPLED = ("t", "mode.mode", "state.position_std", "state.depth_std")
_PLACE = ("eta.x", "eta.y")
_JUMP = 5.0
"""A place that is so far from that of the cycle before, m, was put right: no vehicle makes such a way."""


class Stride(NamedTuple):
    """A point is drawn for each `cycles`; with `envelope` two points for each twice as many, the least and greatest.

    In a plan view there is one for each `plan` cycles.
    """

    cycles: int
    envelope: bool
    plan: int


def stride_of(count: int, dt: float, most: int) -> Stride:
    """Return the stride of a run of so many cycles of dt, s: 10 Hz, or no more than so many points."""
    base, needed = max(1, round(1.0 / dt / _MOST_HZ)), -(-count // most)
    if needed <= base:
        return Stride(base, False, base)
    if needed > _LONG:
        needed += -needed % _PLAN_FINER
    finer = next(n for n in range(max(needed // _PLAN_FINER, base), needed + 1) if needed % n == 0)
    return Stride(needed, True, finer)


def envelope(values: Array, cycles: int) -> Array:
    """Return the least and the greatest of each twice `cycles` values, along the first axis, as they came; NaN is none.

    A single sample that stands out is among them whatever the stride.
    """
    width = 2 * cycles
    values = np.concatenate((values, np.repeat(values[-1:], -len(values) % width, axis=0)))
    groups = values.reshape(-1, width, *values.shape[1:])
    unknown = np.isnan(groups)
    low, high = (np.where(unknown, end, groups) for end in (np.inf, -np.inf))
    ends = np.sort(np.stack((low.argmin(axis=1), high.argmax(axis=1)), axis=1), axis=1)
    found: Array = np.take_along_axis(groups, ends, axis=1)
    return found.reshape(-1, *values.shape[1:])


class Drawn:
    """The data of a flight's plots, in one pass over its log.

    Attributes:
        stride: see `Stride`; `rate` is that of the points, Hz; `dt` the step, s.
        c: columns of the cycles at the points; and "psi", "psi_d", "psi_estimate" (degrees, without jumps), "z_known",
            "z_unknown" (m, the estimated depth while it is known, and while it is not), "bottom" (m), and the errors
            "depth_error", "path_error", "away", "depth_off" (m), "heading_error" (degrees).
        truth: columns of the truth at the points; empty where nobody knew it.
        plan, plan_truth: columns of the place, at more points; of the plan also "t" and "jumps", how many times the
            estimate was put right by metres up to there.
        steered: whether it ever was by laws.
        learned, reasons, mission, late, health, modes: of all cycles.
        heading_off, ahrs_off: of all cycles in which the heading is held, by the truth, where it is known: how far the
            estimate is off, and what the AHRS told then, degrees.
        designs: by law, over all cycles, what it was designed from (`adoption.design_states`).
        events: vehicle time, s, and estimated depth, m, of each event.
    """

    def __init__(self, log: Run, most: int) -> None:
        self.dt, self.steered = _step(log), False
        self.stride = stride_of(log.count, self.dt, most)
        self.rate = 1.0 / self.dt / self.stride.cycles
        self.modes, self.health, self.learned = Timeline(), HealthRecord(log), LearnedFigures(log)
        self._place, self._jumps = np.full((1, 2), np.nan), 0
        self.reasons = LearningReasons(log)
        self._path, self._psi, self._points = PathError(log), UnwrappedHeading(), _Points(self.stride)
        self.heading_off, self.ahrs_off = Mean(), Mean()
        self.designs = {law: Timeline() for law in ("depth", "heading")}
        late, missions, moments = LatenessRecord(), FlownMissions(log), np.array([t for t, _ in log.sentences])
        events = [np.empty((2, 0))]
        for piece in log.pieces(2 * self.stride.cycles):  # a group of points never spans two pieces
            for part in (self.health, self.learned, self.reasons, late, missions):
                part.add(piece)
            t, z = piece.columns["t"], piece.columns["state.eta.z"]
            self.modes.add(t, piece.columns["mode.mode"], self.dt)
            self.heading_off.add(heading_estimate_error(piece))
            self.ahrs_off.add(ahrs_heading_error(piece))
            for law, timeline in self.designs.items():
                if (states := design_states(piece.columns, law)).size:
                    timeline.add(t, states, self.dt)
            here = moments[(moments >= t[0]) & (moments < t[-1] + 0.5 * self.dt)]
            events.append(np.stack((here, np.interp(here, t, z))))
            self._draw(piece)
        self.c, self.truth, self.plan, self.plan_truth = map(self._points.joined, ("c", "truth", "plan", "plan_truth"))
        turns = surplus_turns(self.c["psi"])
        self.c |= {name: self.c[name] - turns for name in ("psi", "psi_d", "psi_estimate")}
        self.events: Array = np.concatenate(events, axis=1)
        self.mission: Planned = missions.last
        self.late: LatenessHistogram | None = late.histogram()

    def _draw(self, piece: Piece) -> None:
        c, truth, pose, points = piece.columns, piece.truth, pose_of(piece), self._points
        steered = ~np.isin(c["mode.mode"], (Mode.DISARMED, Mode.MANUAL))
        self.steered = self.steered or bool(steered.any())
        wanted = {name: np.where(steered, c[name], np.nan) for name in _REFERENCES}
        wanted[_DEPTH] = np.where(depth_flown(c), c[_DEPTH], np.nan)
        z_known, z_unknown = (np.where(c["state.depth_ok"] == ok, c["state.eta.z"], np.nan) for ok in (True, False))
        psi = self._psi.of(pose["eta.psi"])
        lines = {name: c[name] for name in (*_LINES, *_COMMANDED)} | wanted
        lines |= {name: _reported(c, name) for name in _REPORTED}
        lines |= {
            "psi": psi,
            "psi_d": psi + wrapped_deg(wanted["reference.psi_d"] - pose["eta.psi"]),
            "psi_estimate": psi + wrapped_deg(c["state.eta.psi"] - pose["eta.psi"]),
            "z_known": z_known,
            "z_unknown": z_unknown,
            "bottom": z_known + c["state.altitude"],
            "depth_error": wanted["reference.z_d"] - pose["eta.z"],
            "heading_error": wrapped_deg(wanted["reference.psi_d"] - pose["eta.psi"]),
            "path_error": self._path.of(piece),
        }
        if truth:
            lines |= {"away": navigation_error(piece), "depth_off": c["state.eta.z"] - truth["eta.z"]}
            points.lines("truth", {name: truth[name] for name in _TRUE_LINES})
            points.samples("truth", {"current": truth["current"]})
            points.plan("plan_truth", {name: truth[name] for name in _PLACE})
        points.lines("c", lines)
        learned = [name for name in c if name.startswith(("state.learned.", "adopted."))]
        points.samples("c", {name: c[name] for name in (*_SAMPLED, *learned)})
        points.plan("plan", {name: c[f"state.{name}"] for name in _PLACE} | {"t": c["t"], "jumps": self._jumped(c)})

    def _jumped(self, c: Columns) -> Array:
        """Return how many times the estimated place has jumped, up to each cycle of the next piece."""
        places = np.column_stack([c[f"state.{name}"] for name in _PLACE])
        steps = np.diff(places, axis=0, prepend=self._place)
        jumps: Array = self._jumps + np.cumsum(np.hypot(*steps.T) > _JUMP)
        self._place, self._jumps = places[-1:].copy(), int(jumps[-1])
        return jumps


class _Points:
    """Collects points of columns, by the name of what they belong to."""

    def __init__(self, stride: Stride) -> None:
        self._stride = stride
        self._kept: dict[str, dict[str, list[Array]]] = {}

    def lines(self, of: str, columns: Columns) -> None:
        """Add lines, of which nothing that stands out is lost."""
        cycles = self._stride.cycles
        for name, values in columns.items():
            self._add(of, name, envelope(values, cycles) if self._stride.envelope else values[::cycles])

    def samples(self, of: str, columns: Columns) -> None:
        """Add single cycles, for what belongs together."""
        for name, values in columns.items():
            found = values[:: self._stride.cycles]
            if self._stride.envelope and len(found) % 2:
                found = np.concatenate((found, values[-1:]))  # as many as the lines have
            self._add(of, name, found)

    def plan(self, of: str, columns: Columns) -> None:
        """Add places."""
        for name, values in columns.items():
            self._add(of, name, values[:: self._stride.plan])

    def joined(self, of: str) -> Columns:
        """Return what was added."""
        return {name: np.concatenate(parts) for name, parts in self._kept.get(of, {}).items()}

    def _add(self, of: str, name: str, points: Array) -> None:
        self._kept.setdefault(of, {}).setdefault(name, []).append(points.copy())


def _reported(c: Columns, name: str) -> Array:
    """Return what an actuator reports; no number while it is silent."""
    value, t_valid = c[f"{name}.value"], c[f"{name}.t_valid"]
    silent = (c["t"] - t_valid.T).T > _SILENT
    return np.where(silent, np.nan, value)


def _step(log: Run) -> float:
    for piece in log.pieces():
        return float(piece.columns["tick.dt_ns"][0]) * 1e-9
    return 1.0
