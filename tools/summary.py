"""A run in a dozen figures, for people: degrees, percent and rpm where they think in them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.table import Table

from firmware_py.records.order import Mode
from tools.log import Columns, Log

Array = npt.NDArray[Any]
Summary = dict[str, Any]

_HELD = (Mode.HOLD, Mode.MISSION)

_ROWS: tuple[tuple[str, str, str], ...] = (
    # key, words, format with the unit
    ("vehicle_time_s", "vehicle time", "{:.1f} s"),
    ("wall_time_s", "wall time", "{:.1f} s"),
    ("speed_up", "speed-up", "{:.1f} ×"),
    ("distance_m", "distance travelled", "{:.0f} m"),
    ("depth_max_m", "greatest depth", "{:.2f} m"),
    ("depth_error_rms_m", "depth error, RMS", "{:.3f} m"),
    ("heading_error_rms_deg", "heading error, RMS", "{:.2f}°"),
    ("cross_track_rms_m", "cross-track error, RMS", "{:.2f} m"),
    ("cross_track_max_m", "cross-track error, greatest", "{:.2f} m"),
    ("navigation_error_end_m", "navigation error, at the end", "{:.2f} m"),
    ("navigation_error_max_m", "navigation error, greatest", "{:.2f} m"),
    ("fin_travel_deg_s", "fin travel", "{:.2f} °/s"),
    ("late_cycles", "late cycles", "{:d}"),
)


def summarise(log: Log) -> Summary:
    """The figures of a run; None where the log cannot say.

    completed, reason: from the log's end record, as the run's scenario judged; False for a log that was cut off.
    vehicle_time_s: time of the last cycle plus one step. wall_time_s: from the end record. speed_up: their quotient.
    distance_m: length of the path over the ground, x, y and z. depth_max_m: greatest z.
    depth_error_rms_m, heading_error_rms_deg: of z_d - z and psi_d - psi (the short way) over all armed cycles in hold
    and mission. z and psi are the truth where it was logged, else the estimate; `against` says which.
    cross_track_rms_m, cross_track_max_m: of the reference's `cross_track` over the same cycles, where there is a leg.
    navigation_error_end_m, navigation_error_max_m: horizontal distance from the estimate to the truth.
    fin_travel_deg_s: the way a fin's applied angle covers, over the time armed, mean of all fins.
    waypoints_passed, waypoints_total: legs flown to their end, of how many.
    late_cycles: those that began more than one step after their deadline. cycles, complete, lost, events: of the log.
    """
    c = log.columns
    dt = float(c["tick.dt_ns"][-1]) * 1e-9
    vehicle_time, wall = float(c["t"][-1]) + dt, log.end.get("wall_s")
    truth = true_columns(log)
    state = truth or {name: c[f"state.{name}"] for name in ("eta.x", "eta.y", "eta.z", "eta.psi")}
    armed = c["applied.armed"]
    held = armed & np.isin(c["mode.mode"], _HELD)
    cross_track = c["reference.cross_track"][held & np.isfinite(c["reference.cross_track"])]
    steps = np.abs(np.diff(c["applied.fins"], axis=0))[armed[1:]]
    away = navigation_error(log)
    passed, total = _waypoints(log)
    reason = log.end.get("reason") or (f"the log is {log.lost}" if log.lost else "the run was ended")
    summary: Summary = {
        "completed": bool(log.end.get("completed", False)),
        "reason": reason,
        "vehicle_time_s": vehicle_time,
        "wall_time_s": wall,
        "speed_up": vehicle_time / wall if wall else None,
        "distance_m": float(np.sum(np.sqrt(sum(np.diff(state[f"eta.{axis}"]) ** 2 for axis in "xyz")))),
        "depth_max_m": float(np.max(state["eta.z"])),
        "against": "truth" if truth else "estimate",
        "depth_error_rms_m": _rms((c["reference.z_d"] - state["eta.z"])[held]),
        "heading_error_rms_deg": _rms(wrapped_deg(c["reference.psi_d"] - state["eta.psi"])[held]),
        "cross_track_rms_m": _rms(cross_track),
        "cross_track_max_m": float(np.max(np.abs(cross_track))) if cross_track.size else None,
        "navigation_error_end_m": float(away[-1]) if away.size else None,
        "navigation_error_max_m": float(np.max(away)) if away.size else None,
        "fin_travel_deg_s": math.degrees(float(np.mean(steps))) / dt if steps.size else None,
        "waypoints_passed": passed,
        "waypoints_total": total,
        "late_cycles": int(np.sum(c["tick.late_ns"] > c["tick.dt_ns"])),
        "cycles": len(c["t"]),
        "complete": log.complete,
        "lost": log.lost,
        "events": [[t, text] for t, text in log.events],
    }
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in summary.items()}


def table(summary: Summary) -> Table:
    """The summary as the terminal shows it."""
    rows = Table(show_header=False, box=None, padding=(0, 2))
    rows.add_row("mission", verdict(summary))
    for words, value in figures(summary):
        rows.add_row(words, value)
    return rows


def verdict(summary: Summary) -> str:
    """One phrase: did it do what it should, and if not, why not."""
    return "completed" if summary["completed"] else f"not completed: {summary['reason']}"


def figures(summary: Summary) -> list[tuple[str, str]]:
    """(words, figure with its unit), without what the log cannot say."""
    found = [(words, form.format(summary[key])) for key, words, form in _ROWS if summary[key] is not None]
    if summary["waypoints_total"]:
        found.append(("waypoints", f"{summary['waypoints_passed']} of {summary['waypoints_total']}"))
    return found


def true_columns(log: Log) -> Columns:
    """The plant's state at each cycle: the last one logged at or before it. Empty when there is none."""
    truth, t = log.truth, log.columns["t"]
    if not truth or truth["t"][0] > t[0]:
        return {}
    at = np.searchsorted(truth["t"], t, side="right") - 1
    return {name: column[at] for name, column in truth.items()}


def navigation_error(log: Log) -> Array:
    """Horizontal distance from the estimate to the truth, m, at each cycle; empty without truth."""
    c, truth = log.columns, true_columns(log)
    if not truth:
        return np.empty(0)
    away: Array = np.hypot(c["state.eta.x"] - truth["eta.x"], c["state.eta.y"] - truth["eta.y"])
    return away


def wrapped_deg(angle: Array) -> Array:
    """Radians to degrees in [-180, 180)."""
    degrees: Array = (np.degrees(angle) + 180.0) % 360.0 - 180.0
    return degrees


def _waypoints(log: Log) -> tuple[int, int]:
    total = len(log.header.get("mission", {}).get("waypoints", ()))
    c = log.columns
    if c["mode.mission_done"].any():
        return total, total
    flown = c["reference.waypoint"][c["mode.mode"] == Mode.MISSION]
    return (min(int(flown.max()), total) if flown.size else 0), total


def _rms(values: Array) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if values.size else None
