"""The summary of a run for people: the outcome in a line, the figures with their units."""

from __future__ import annotations

from rich.console import Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from sternplane.logs import health_record, lateness_histogram, losses
from sternplane.logs.summary import Summary

_MOST_LOSSES = 10
"""So many lines tell of what was lost."""
_TRACKED = ("depth_tracking_error", "heading_tracking_error", "path_error")
"""How the keys begin whose figures are of the true vehicle, or of the estimated one where the truth is not known."""
_WHOLE: tuple[tuple[str, str, str], ...] = (
    # key, label, format with the unit; of the whole flight, also where it went on without a log
    ("vehicle_time_s", "vehicle time", "{:.1f} s"),
    ("wall_time_s", "wall time", "{:.1f} s"),
    ("speed_up", "speed-up", "{:.1f} ×"),
    ("depth_max_m", "greatest depth", "{:.2f} m"),
)
_LOGGED: tuple[tuple[str, str, str], ...] = (
    ("distance_m", "distance travelled", "{:.0f} m"),
    ("depth_tracking_error_rms_m", "depth off its reference, RMS", "{:.3f} m"),
    ("heading_tracking_error_rms_deg", "heading off its reference, RMS", "{:.2f}°"),
    ("path_error_rms_m", "off the planned path, RMS", "{:.2f} m"),
    ("path_error_max_m", "off the planned path, greatest", "{:.2f} m"),
    ("depth_estimate_error_rms_m", "error of the depth estimate, RMS", "{:.3f} m"),
    ("depth_estimate_error_max_m", "error of the depth estimate, greatest", "{:.2f} m"),
    ("navigation_error_end_m", "error of the horizontal position estimate, at the end", "{:.2f} m"),
    ("navigation_error_max_m", "error of the horizontal position estimate, greatest", "{:.2f} m"),
    ("turning_diameter_m", "turning diameter, steady", "{:.1f} m"),
    ("turning_rate_deg_s", "turning rate, steady", "{:.2f} °/s"),
    ("overshoot_first_deg", "first overshoot", "{:.1f}°"),
    ("overshoot_second_deg", "second overshoot", "{:.1f}°"),
    ("zigzag_period_s", "zigzag period", "{:.1f} s"),
    ("fin_travel_deg_s", "fin travel", "{:.2f} °/s"),
    ("late_cycles", "late cycles", "{:d}"),
)


def summary_table(summary: Summary) -> Group:
    """The summary as the terminal shows it: the outcome in a line of its own, then the figures."""
    rows = Table(show_header=False, box=None, padding=(0, 2))
    for label, value in key_figures(summary):
        rows.add_row(label, value)
    if summary["faults"]:
        rows.add_row("faults", ", ".join(summary["faults"]))
    if summary["faults_not_begun"]:
        rows.add_row("faults that had not begun at the end", ", ".join(summary["faults_not_begun"]))
    return Group(Padding(Text(outcome(summary)), (0, 2)), rows)


def outcome(summary: Summary) -> str:
    """Return one phrase: whether the run was completed, and if not, why, and whether it ended safely all the same."""
    if summary["completed"] is None:
        return str(summary["reason"])
    believed = ", by the vehicle's own estimate" if summary.get("judged_by") == "estimate" else ""
    if summary.get("surfaced"):
        how = f"not completed, but {summary['reason']}{believed}"
    elif summary["completed"]:
        how = f"completed{believed}"
    else:
        how = f"not completed: {summary['reason']}"
    return f"{how}; {unlogged(summary)}" if summary.get("after_log") else how


def unlogged(summary: Summary) -> str:
    """Return what became of a flight that went on without its log; "" for one that did not."""
    after = summary.get("after_log")
    if not after:
        return ""
    more = summary["vehicle_time_s"] - summary["logged_s"]
    return (
        f"the log ends at {summary['logged_s']:.1f} s, because {after['why']}: the vehicle flew on for {more:.1f} s, "
        f"and ended in mode {after['mode']}, {after['depth_m']:.1f} m deep"
    )


def key_figures(summary: Summary) -> list[tuple[str, str]]:
    """Return (label, figure with its unit), without what the log cannot say; labels tell what it says of a part."""
    part = ", while logged" if summary.get("after_log") else ""
    whole = _rows(summary, _WHOLE)
    if summary["waypoints_total"]:
        whole.append(("waypoints", f"{summary['waypoints_passed']} of {summary['waypoints_total']}"))
    if part:
        whole.append(("logged", f"{summary['logged_s']:.1f} s"))
    logged = [*_rows(summary, _LOGGED), *_lateness(summary), *_learned(summary), *_adopted(summary)]
    logged += health_record.key_figures(summary["health"])
    return [*whole, *((f"{label}{part}", text) for label, text in logged), *_lost(summary)]


def _lost(summary: Summary) -> list[tuple[str, str]]:
    """Return what was lost, the worst first."""
    told = losses.told(summary["losses"], summary["received"])
    found = [(loss.source, loss.text) for loss in told[:_MOST_LOSSES]]
    more = len(told) - _MOST_LOSSES
    return [*found, ("other losses", f"and {more} more: see the report")] if more > 0 else found


def _rows(summary: Summary, rows: tuple[tuple[str, str, str], ...]) -> list[tuple[str, str]]:
    believed = ", by the estimate" if summary["against"] == "estimate" else ""
    return [
        (f"{label}{believed if key.startswith(_TRACKED) else ''}", form.format(summary[key]))
        for key, label, form in rows
        if summary[key] is not None
    ]


def _lateness(summary: Summary) -> list[tuple[str, str]]:
    late = summary["lateness"]
    if not late:
        return []
    names = (("median", "median_us"), ("99 % within", "p99_us"), ("greatest", "max_us"))
    return [(f"lateness, {name}", lateness_histogram.with_unit(late[key])) for name, key in names]


def _learned(summary: Summary) -> list[tuple[str, str]]:
    learned = summary["learned"]
    if not learned:
        return []
    valid = {name: one for name, one in learned["coefficients"].items() if one["valid"]}
    found = [("coefficients valid", f"{len(valid)} of {len(learned['coefficients'])}")]
    errors = {name: one["error_pct"] for name, one in valid.items() if one["error_pct"] is not None}
    if errors:
        worst = max(errors, key=lambda name: abs(errors[name]))
        sigmas = abs(valid[worst]["error_sigmas"])
        text = f"{worst} {errors[worst]:+.2g} % ({sigmas:.1f} σ)"
        found.append(("largest error of the valid coefficients", text))
    return found


def _adopted(summary: Summary) -> list[tuple[str, str]]:
    """Return from when the laws used what was learned, and errors before and after."""
    adoption = summary["adoption"]
    if not adoption:
        return [("laws designed from", "vehicle.toml: adoption is off")] if summary["adoption_off"] else []
    found = []
    for (law, one), form in zip(adoption["laws"].items(), ("{:.3f} m", "{:.2f}°"), strict=True):
        t, errors = one["adopted_s"], (one["rms_before"], one["rms_after"])
        found.append((f"{law} law designed from what is learned alone", "never" if t is None else f"from {t:.1f} s"))
        if None not in errors:
            found.append((f"{law} off its reference, before and after that, RMS", ", ".join(map(form.format, errors))))
    known = [one for one in adoption["coefficients"].values() if one["error_before_pct"] is not None]
    if known:
        worst = [max(abs(one[key]) for one in known) for key in ("error_before_pct", "error_after_pct")]
        found.append(
            ("coefficients of the laws, greatest error", "{:.3g} % by the file, {:.3g} % at the end".format(*worst))
        )
    return found
