"""A run in a dozen figures: degrees, percent and rpm where people think in them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from firmware_py.records.order import Mode
from sternplane.logs import after_log, health_record, lateness_histogram, losses, standard_manoeuvres
from sternplane.logs.adoption import AdoptionFigures
from sternplane.logs.findings import findings
from sternplane.logs.learned import LearnedFigures, with_none
from sternplane.logs.learning_reasons import LearningReasons, with_reasons
from sternplane.logs.manoeuvrability import LimitFigures
from sternplane.logs.mean import Mean
from sternplane.logs.reading import Piece
from sternplane.logs.run import Run
from sternplane.logs.tracking import (
    Array,
    FirstFix,
    FlownMissions,
    PathError,
    depth_estimate_error,
    heading_estimate_error,
    held_cycles,
    navigation_error,
    pose_of,
    wrapped_deg,
)
from sternplane.logs.true_coefficients import faults_of
from sternplane.logs.true_end import TrueEnd

Summary = dict[str, Any]


def summarise(log: Run) -> Summary:
    """Return the figures of a run; None where the log cannot say.

    completed, reason: from the log's end record, as the run's scenario judged; None where there was
    none to judge; False for a log that was cut off. surfaced: True if it was not, but a rule brought the vehicle safely
    to the surface, where it lies disarmed. judged_by: "truth", or "estimate" where the plant was elsewhere.
    after_log: None; of a flight that went on when its log had ended (`after_log.AfterLog`): why it ended, and in which
    mode and depth_m the flight. Then what is said above and vehicle_time_s, depth_max_*, waypoints_passed, losses and
    events are of the whole flight; all else is of the `logged_s` in the log.
    vehicle_time_s: time of the last cycle plus one step; logged_s: of the last in the log. wall_time_s: from the end
    record. speed_up: their quotient.
    distance_m: length of the path over the ground, x, y and z. depth_max_m, depth_max_at_s: greatest z, and when;
    depth_max_estimate_m: greatest estimated z, which a sensor at fault may hold far from the truth.
    depth_tracking_error_rms_m, heading_tracking_error_rms_deg: how far the vehicle is off its reference, z_d - z and
    psi_d - psi (the short way), over all armed cycles in which depth and heading are held: hold, mission, loiter,
    guided, return. z and psi are the truth where it was logged, else the estimate; `against` says which.
    depth_estimate_error_rms_m, depth_estimate_error_max_m: of the distance from the estimated depth to the true one
    over all cycles, armed or not. None without a logged truth.
    path_error_rms_m, path_error_max_m: of the horizontal distance from the vehicle (truth or estimate, as above) to the
    planned path over the cycles in MISSION; the path is the straight lines from where MISSION was entered through the
    waypoints, the last of them without an end (`tracking.PathError`). None if no mission was flown.
    heading_estimate_error_mean_deg: mean of the estimated heading minus the true one over the cycles in which it is
    held: what the AHRS's heading is off. None without a logged truth.
    navigation_error_end_m, navigation_error_max_m: horizontal distance from the estimate to the truth, at the end and
    at most since the first fix was taken (first_fix_s), or in all if none was; navigation_error_before_fix_m: at most
    before it, where the position was what an earlier flight had left, or what the vehicle began with.
    position_std_end_m: what the estimate says of itself at the end, 1 sigma of the horizontal position.
    ended: mode, north_m, east_m and depth_m at the end (truth or estimate, as above); of a flight that went on without
    its log the place is None.
    turning_diameter_m, turning_rate_deg_s (positive to starboard): of a run steered by hand in a circle.
    overshoot_first_deg, overshoot_second_deg, zigzag_period_s: of one steered by hand in a zigzag (`manoeuvres`).
    fin_travel_deg_s: the way a fin's applied angle covers, over the time armed, mean of all fins.
    waypoints_passed, waypoints_total: legs flown to their end, of how many, of the mission that was flown last.
    late_cycles: those that began more than one step after their deadline. lateness: `LatenessHistogram` by
    name, None for a run that was not in real time. losses: by name, what was lost, as the log's end record counts, or
    as was logged last; losses_seen_s: by name, the times at which a count was first and last seen to have risen;
    NODE_missed: messages of a node that did not come, or were not believed; received: those that did, by source;
    two_senders: nodes under whose id a second sender was noticed;
    gcs_N_*: of the N-th link to ground stations, what came unsigned, malformed or too fast (flooding, overrun), what
    was not taken for want of room, and what was not said or sent to them.
    health: sensors and actuators that were ever not good, and the ascent: see `HealthRecord.document`.
    by_truth: up_s, from when a simulated vehicle truly was at the surface until the end of the log, and weight_gone_s,
    when its drop weight truly went, whether it knew of it or not; each None where it did not; None without a truth.
    found: what rules and monitor of the bus found: by ("rule", "bus"), text, key, known (a rule warns of a sensor or an
    actuator that is in health), first_s, times (`findings`).
    learned: None if nothing was; else of the last cycle, by coefficient, value, std, valid, believed, and truth (with
    what faults have left of the fins: `true_coefficients`), error_pct and error_sigmas where the truth was logged;
    mean_square_error_sigmas over them, correlations left out; nis by sensor, current_m_s and current_std_m_s (north,
    east), turbulence_m_s, rejected, dropped, resets; and taught: when each learning manoeuvre was over (s), and the
    sentence on what it taught and what not. not_valid_because: of each coefficient, and of all that are not valid in
    one line (`LearningReasons`). not_learned_because: why learned is None, None where it is not known.
    adoption: None if no law ever used what was learned; else by law, depth and heading: earlier_s, from when it was
    designed from what an earlier flight learned (None: never), first_s, from when some of its
    values were learned in this flight, adopted_s, from when its design was of such values alone (None: never),
    rms_before and rms_after, of the tracking errors as above (m, deg) up to then and from then on, rms_moving_before
    and rms_moving_after of those while the reference dives or turns (None: too little or too unlike, and
    not_compared_because says which), and the design by_file and in_force at the end; by coefficient: file, adopted_s
    (when its value first left the file's), in_force at the end, and truth (at the end, as above), error_before_pct (of
    the file) and error_after_pct (of what is in force), both against it, where the truth was logged.
    adoption_refused: by law, why it is designed from the vehicle file alone at the end; {} where it is not.
    limits: by name what the vehicle could do, by the coefficients in force and what was left of its fins: at the
    begin, at its worst and at the end (`manoeuvrability.LimitFigures`).
    scenario, seed: of the flight, None where it has none.
    settings: what was set upon the files (--set), key to value. cycles, complete, lost, events: of the log.
    notes: sentences on the state of an earlier run.
    """
    figures, learned, late = _Figures(log), LearnedFigures(log), lateness_histogram.LatenessRecord()
    manoeuvres, health = standard_manoeuvres.StandardManoeuvres(), health_record.HealthRecord(log)
    received, adoption, limits = losses.Received(), AdoptionFigures(log), LimitFigures()
    reasons, true_end = LearningReasons(log), TrueEnd()
    parts = (figures, learned, reasons, adoption, limits, late, manoeuvres, health, received, true_end)
    for piece in log.pieces():
        for part in parts:
            part.add(piece)
    after = after_log.after_log(log)
    end = log.end if after is None else after.end
    t_end = figures.t_end if after is None else after.t_end
    wall, lateness = end.get("wall_s"), late.histogram()
    circle, zigzag = manoeuvres.circle(), manoeuvres.zigzag()
    reason = end.get("reason") or (f"the log is {log.lost}" if log.lost else "the run was ended")
    summary: Summary = {
        **{key: log.header.get(key) for key in ("scenario", "seed")},
        "completed": end.get("completed", False),
        "reason": reason,
        "surfaced": end.get("surfaced", False),
        "judged_by": end.get("judged_by"),
        "vehicle_time_s": t_end,
        "wall_time_s": wall,
        "speed_up": t_end / wall if wall else None,
        **figures.document(),
        "turning_diameter_m": circle.diameter if circle else None,
        "turning_rate_deg_s": math.degrees(circle.rate) if circle else None,
        "overshoot_first_deg": math.degrees(zigzag.first_overshoot) if zigzag else None,
        "overshoot_second_deg": math.degrees(zigzag.second_overshoot) if zigzag else None,
        "zigzag_period_s": zigzag.period if zigzag else None,
        "lateness": lateness._asdict() if lateness else None,
        "losses": {**losses.losses(log), **end.get("losses", {})},
        "losses_seen_s": losses.times(log),
        "received": received.counts,
        "two_senders": losses.two_senders(log.events),
        "health": (known := health.document()),
        "by_truth": true_end.document(),
        "found": findings(log.events, {*known["sensors"], *known["actuators"]}, health.actuators),
        "learned": with_reasons(learned.summary, reasons.of(learned)),
        "not_learned_because": reasons.nothing or None,
        "adoption": adoption.summary,
        "adoption_off": _is_off(log.header),
        "adoption_refused": adoption.refused,
        "limits": limits.summary,
        "after_log": None,
        "complete": log.complete,
        "lost": log.lost,
        "settings": log.header.get("settings", {}),
        "faults": log.header.get("faults", []),
        "faults_not_begun": [fault.text for fault in faults_of(log.header) if fault.t >= t_end],
        "notes": log.header.get("notes", []),
        "events": [[t, text] for t, text in log.sentences],
        **({} if after is None else after.in_summary(log.sentences, figures.document())),
    }
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in summary.items()}


def _is_off(header: Mapping[str, Any]) -> bool:
    """Return whether the configuration switches off that laws are designed from what is learned."""
    control = header.get("configuration", {}).get("autopilot", {}).get("control", {})
    return control.get("adoption", {}).get("enabled", True) is False


class _Figures:
    """The figures of all cycles; it is shown the pieces of the log one after the other."""

    def __init__(self, log: Run) -> None:
        self._path, self._missions = PathError(log), FlownMissions(log)
        self._depth, self._heading, self._off = Mean(), Mean(), Mean()
        self._travel = Mean()
        self._away, self._misjudged, self._turned = Mean(), Mean(), Mean()
        self._fix, self._before_fix, self._since_fix = FirstFix(), Mean(), Mean()
        self._end: Summary = {}
        self._before: tuple[Array, Array] | None = None
        self._distance, self._late, self._cycles, self._true = 0.0, 0, 0, False
        self._deepest, self._deepest_estimate = _Deepest(), _Deepest()
        self._dt = self.t_end = 0.0
        self._sigma = math.nan

    def add(self, piece: Piece) -> None:
        """Take a piece in."""
        c, pose = piece.columns, pose_of(piece)
        self._true = bool(piece.truth)
        self._dt = float(c["tick.dt_ns"][-1]) * 1e-9
        self.t_end = float(c["t"][-1]) + self._dt
        self._cycles += len(c["t"])
        armed, held = c["applied.armed"], held_cycles(c)
        self._depth.add((c["reference.z_d"] - pose["eta.z"])[held])
        self._heading.add(wrapped_deg(c["reference.psi_d"] - pose["eta.psi"])[held])
        off = self._path.of(piece)
        self._off.add(off[np.isfinite(off)])
        away, told = navigation_error(piece), self._fix.taken(piece)
        self._away.add(away)
        if away.size:
            self._before_fix.add(away[~told])
            self._since_fix.add(away[told])
        self._misjudged.add(depth_estimate_error(piece))
        self._turned.add(heading_estimate_error(piece))
        self._end = {
            "mode": Mode(int(c["mode.mode"][-1])).name,
            "north_m": float(pose["eta.x"][-1]),
            "east_m": float(pose["eta.y"][-1]),
            "depth_m": float(pose["eta.z"][-1]),
        }
        self._sigma = float(c["state.position_std"][-1])
        self._missions.add(piece)
        self._late += int(np.sum(c["tick.late_ns"] > c["tick.dt_ns"]))
        self._deepest.add(c["t"], pose["eta.z"])
        self._deepest_estimate.add(c["t"], c["state.eta.z"])
        place, fins = np.column_stack([pose[f"eta.{axis}"] for axis in "xyz"]), c["applied.fins"]
        if self._before is not None:
            place, fins = np.vstack((self._before[0], place)), np.vstack((self._before[1], fins))
            armed = np.concatenate(([False], armed))
        self._before = place[-1:].copy(), fins[-1:].copy()
        self._distance += float(np.sum(np.sqrt(np.sum(np.diff(place, axis=0) ** 2, axis=1))))
        self._travel.add(np.abs(np.diff(fins, axis=0))[armed[1:]].ravel())

    def document(self) -> Summary:
        """Return them by their names in summary.json."""
        passed, total = self._missions.passed
        travel, fixed = self._travel.mean, math.isfinite(self._fix.t)
        return {
            "logged_s": self.t_end,
            "distance_m": self._distance,
            "depth_max_m": self._deepest.z,
            "depth_max_at_s": self._deepest.t,
            "depth_max_estimate_m": self._deepest_estimate.z,
            "against": "truth" if self._true else "estimate",
            "depth_tracking_error_rms_m": self._depth.rms,
            "heading_tracking_error_rms_deg": self._heading.rms,
            "path_error_rms_m": self._off.rms,
            "path_error_max_m": self._off.greatest,
            "depth_estimate_error_rms_m": self._misjudged.rms,
            "depth_estimate_error_max_m": self._misjudged.greatest,
            "heading_estimate_error_mean_deg": self._turned.mean,
            "navigation_error_end_m": self._away.last,
            "navigation_error_max_m": self._since_fix.greatest if fixed else self._away.greatest,
            "navigation_error_before_fix_m": self._before_fix.greatest if fixed else None,
            "first_fix_s": self._fix.t if fixed else None,
            "position_std_end_m": self._sigma,
            "ended": with_none(self._end),
            "fin_travel_deg_s": None if travel is None else math.degrees(travel) / self._dt,
            "waypoints_passed": passed,
            "waypoints_total": total,
            "late_cycles": self._late,
            "cycles": self._cycles,
        }


class _Deepest:
    """The greatest depth, m, and when, s; NaN if one is not known."""

    def __init__(self) -> None:
        self.z, self.t = -math.inf, math.nan

    def add(self, t: Array, z: Array) -> None:
        """Take some in."""
        at = int(np.argmax(z))  # of a NaN, if there is one
        if not z[at] <= self.z and not math.isnan(self.z):
            self.z, self.t = float(z[at]), float(t[at])
