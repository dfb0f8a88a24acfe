"""A run in a dozen figures, for people: degrees, percent and rpm where they think in them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rich.console import Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from firmware_py.records.order import Mode
from sternplane.logs import lateness_histogram, learned, standard_manoeuvres
from sternplane.logs.reading import Log
from sternplane.logs.tracking import (
    Array,
    believed_columns,
    flown_last,
    navigation_error,
    path_error,
    true_columns,
    wrapped_deg,
)

Summary = dict[str, Any]

_HELD = (Mode.HOLD, Mode.MISSION, Mode.LOITER, Mode.GUIDED, Mode.RETURN)

_ROWS: tuple[tuple[str, str, str], ...] = (
    # key, label, format with the unit
    ("vehicle_time_s", "vehicle time", "{:.1f} s"),
    ("wall_time_s", "wall time", "{:.1f} s"),
    ("speed_up", "speed-up", "{:.1f} ×"),
    ("distance_m", "distance travelled", "{:.0f} m"),
    ("depth_max_m", "greatest depth", "{:.2f} m"),
    ("depth_error_rms_m", "depth error, RMS", "{:.3f} m"),
    ("heading_error_rms_deg", "heading error, RMS", "{:.2f}°"),
    ("path_error_rms_m", "path error, RMS", "{:.2f} m"),
    ("path_error_max_m", "path error, greatest", "{:.2f} m"),
    ("navigation_error_end_m", "navigation error, at the end", "{:.2f} m"),
    ("navigation_error_max_m", "navigation error, greatest", "{:.2f} m"),
    ("turning_diameter_m", "turning diameter, steady", "{:.1f} m"),
    ("turning_rate_deg_s", "turning rate, steady", "{:.2f} °/s"),
    ("overshoot_first_deg", "first overshoot", "{:.1f}°"),
    ("overshoot_second_deg", "second overshoot", "{:.1f}°"),
    ("zigzag_period_s", "zigzag period", "{:.1f} s"),
    ("fin_travel_deg_s", "fin travel", "{:.2f} °/s"),
    ("late_cycles", "late cycles", "{:d}"),
)


def summarise(log: Log) -> Summary:
    """Return the figures of a run; None where the log cannot say.

    completed, reason: from the log's end record, as the run's scenario judged; None where there was
    none to judge; False for a log that was cut off.
    vehicle_time_s: time of the last cycle plus one step. wall_time_s: from the end record. speed_up: their quotient.
    distance_m: length of the path over the ground, x, y and z. depth_max_m: greatest z.
    depth_error_rms_m, heading_error_rms_deg: of z_d - z and psi_d - psi (the short way) over all armed cycles in which
    depth and heading are held: hold, mission, loiter, guided, return. z and psi are the truth where it was logged,
    else the estimate; `against` says which.
    path_error_rms_m, path_error_max_m: of the horizontal distance from the vehicle (truth or estimate, as above) to the
    planned path over the cycles in MISSION; the path is the straight lines from where MISSION was entered through the
    waypoints, the last of them without an end (`tracking.path_error`). None if no mission was flown.
    navigation_error_end_m, navigation_error_max_m: horizontal distance from the estimate to the truth.
    turning_diameter_m, turning_rate_deg_s (positive to starboard): of a run steered by hand in a circle.
    overshoot_first_deg, overshoot_second_deg, zigzag_period_s: of one steered by hand in a zigzag (`manoeuvres`).
    fin_travel_deg_s: the way a fin's applied angle covers, over the time armed, mean of all fins.
    waypoints_passed, waypoints_total: legs flown to their end, of how many, of the mission that was flown last.
    late_cycles: those that began more than one step after their deadline. lateness: `LatenessHistogram` by
    name, None for a run that was not in real time. losses: by name, what was lost, as the log's end record counts;
    gcs_N_*: of the N-th link to ground stations, what came unsigned, malformed or too fast (flooding, overrun), what
    was not taken for want of room, and what was not said or sent to them.
    learned: None if nothing was; else of the last cycle, by coefficient, value, std, valid, believed, and truth,
    error_pct and error_sigmas where the truth was logged; mean_square_error_sigmas over them, correlations left out;
    nis by sensor, current_m_s and current_std_m_s (north, east), turbulence_m_s, rejected, dropped, resets; and taught:
    when each learning manoeuvre was over (s), and the sentence on what it taught and what not.
    cycles, complete, lost, events: of the log. notes: sentences on the state of an earlier run.
    """
    c = log.columns
    dt = float(c["tick.dt_ns"][-1]) * 1e-9
    vehicle_time, wall = float(c["t"][-1]) + dt, log.end.get("wall_s")
    truth = true_columns(log)
    pose = truth or believed_columns(log)
    armed = c["applied.armed"]
    held = armed & np.isin(c["mode.mode"], _HELD)
    off = path_error(log, pose)
    off = off[np.isfinite(off)]
    steps = np.abs(np.diff(c["applied.fins"], axis=0))[armed[1:]]
    away = navigation_error(log, truth)
    passed, total = _waypoints(log)
    late = lateness_histogram.of_log(log)
    circle, zigzag = standard_manoeuvres.circle(c, pose), standard_manoeuvres.zigzag(c, pose)
    reason = log.end.get("reason") or (f"the log is {log.lost}" if log.lost else "the run was ended")
    summary: Summary = {
        "completed": log.end.get("completed", False),
        "reason": reason,
        "vehicle_time_s": vehicle_time,
        "wall_time_s": wall,
        "speed_up": vehicle_time / wall if wall else None,
        "distance_m": float(np.sum(np.sqrt(sum(np.diff(pose[f"eta.{axis}"]) ** 2 for axis in "xyz")))),
        "depth_max_m": float(np.max(pose["eta.z"])),
        "against": "truth" if truth else "estimate",
        "depth_error_rms_m": _rms((c["reference.z_d"] - pose["eta.z"])[held]),
        "heading_error_rms_deg": _rms(wrapped_deg(c["reference.psi_d"] - pose["eta.psi"])[held]),
        "path_error_rms_m": _rms(off),
        "path_error_max_m": float(np.max(off)) if off.size else None,
        "navigation_error_end_m": float(away[-1]) if away.size else None,
        "navigation_error_max_m": float(np.max(away)) if away.size else None,
        "turning_diameter_m": circle.diameter if circle else None,
        "turning_rate_deg_s": math.degrees(circle.rate) if circle else None,
        "overshoot_first_deg": math.degrees(zigzag.first_overshoot) if zigzag else None,
        "overshoot_second_deg": math.degrees(zigzag.second_overshoot) if zigzag else None,
        "zigzag_period_s": zigzag.period if zigzag else None,
        "fin_travel_deg_s": math.degrees(float(np.mean(steps))) / dt if steps.size else None,
        "waypoints_passed": passed,
        "waypoints_total": total,
        "late_cycles": int(np.sum(c["tick.late_ns"] > c["tick.dt_ns"])),
        "lateness": late._asdict() if late else None,
        "losses": dict(log.end.get("losses", {})),
        "learned": learned.learned_summary(log),
        "cycles": len(c["t"]),
        "complete": log.complete,
        "lost": log.lost,
        "faults": log.header.get("faults", []),
        "notes": log.header.get("notes", []),
        "events": [[t, text] for t, text in log.sentences],
    }
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in summary.items()}


def summary_table(summary: Summary) -> Group:
    """The summary as the terminal shows it: the outcome in a line of its own, then the figures."""
    rows = Table(show_header=False, box=None, padding=(0, 2))
    for label, value in key_figures(summary):
        rows.add_row(label, value)
    if summary["faults"]:
        rows.add_row("faults", ", ".join(summary["faults"]))
    return Group(Padding(Text(outcome(summary)), (0, 2)), rows)


def outcome(summary: Summary) -> str:
    """Return one phrase: whether the run was completed, and if not, why."""
    if summary["completed"] is None:
        return str(summary["reason"])
    return "completed" if summary["completed"] else f"not completed: {summary['reason']}"


def key_figures(summary: Summary) -> list[tuple[str, str]]:
    """Return (label, figure with its unit), without what the log cannot say."""
    found = [(label, form.format(summary[key])) for key, label, form in _ROWS if summary[key] is not None]
    if summary["waypoints_total"]:
        found.append(("waypoints", f"{summary['waypoints_passed']} of {summary['waypoints_total']}"))
    if late := summary["lateness"]:
        found.append(("lateness, median", lateness_histogram.with_unit(late["median_us"])))
        found.append(("lateness, 99 % within", lateness_histogram.with_unit(late["p99_us"])))
        found.append(("lateness, greatest", lateness_histogram.with_unit(late["max_us"])))
    if learned := summary["learned"]:
        valid = {name: one for name, one in learned["coefficients"].items() if one["valid"]}
        found.append(("coefficients valid", f"{len(valid)} of {len(learned['coefficients'])}"))
        errors = {name: one["error_pct"] for name, one in valid.items() if one["error_pct"] is not None}
        if errors:
            worst = max(errors, key=lambda name: abs(errors[name]))
            sigmas = abs(valid[worst]["error_sigmas"])
            text = f"{worst} {errors[worst]:+.2g} % ({sigmas:.1f} σ)"
            found.append(("largest error of the valid coefficients", text))
    found += [(str(name).replace("_", " "), str(count)) for name, count in summary["losses"].items() if count]
    return found


def _waypoints(log: Log) -> tuple[int, int]:
    begin, end, waypoints = flown_last(log)
    total = len(waypoints)
    c = {name: log.columns[name][begin:end] for name in ("mode.mode", "mode.mission_done", "reference.waypoint")}
    if c["mode.mission_done"].any():
        return total, total
    flown = c["reference.waypoint"][c["mode.mode"] == Mode.MISSION]
    return (min(int(flown.max()), total) if flown.size else 0), total


def _rms(values: Array) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if values.size else None
