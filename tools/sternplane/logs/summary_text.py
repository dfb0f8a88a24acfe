"""The summary of a run for people: the outcome in a line, then figures with their units, as people ask for them."""

from __future__ import annotations

from rich.console import Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from firmware_py.number_text import signed
from sim_bridge.completion import SURFACE
from sternplane.logs import findings, health_record, lateness_histogram, losses
from sternplane.logs.adoption import adopted_text
from sternplane.logs.summary import Summary

Rows = list[tuple[str, str]]
LABEL_WIDTH = 34
"""A label has no more characters, so that it stands in one line of a terminal of 80 columns, with its figure."""
_SIDES = {"north_m": ("north", "south"), "east_m": ("east", "west")}
_SOON = 1.0
"""A drop weight that truly went no longer than this, s, from when the vehicle knew of it adds nothing."""
_MOST_LOSSES = 10
"""So many lines tell of what was lost."""
_Formats = tuple[tuple[str, str, tuple[str, ...]], ...]
_TRAVELLED: _Formats = (
    # label, format with units, keys
    ("vehicle time", "{:.1f} s", ("vehicle_time_s",)),
    ("greatest depth", "{:.2f} m", ("depth_max_m",)),
)
_ACCURACY: _Formats = (
    ("off the planned path", "{:.2f} m RMS, {:.2f} m at most", ("path_error_rms_m", "path_error_max_m")),
    ("depth off its reference", "{:.3f} m RMS", ("depth_tracking_error_rms_m",)),
    ("heading off its reference", "{:.2f}° RMS", ("heading_tracking_error_rms_deg",)),
    (
        "depth estimate off",
        "{:.3f} m RMS, {:.2f} m at most",
        ("depth_estimate_error_rms_m", "depth_estimate_error_max_m"),
    ),
)
_POSITION: _Formats = (
    (
        "position estimate off",
        "{:.2f} m at the end, {:.2f} m at most",
        ("navigation_error_end_m", "navigation_error_max_m"),
    ),
)
_MANOEUVRES: _Formats = (
    ("turning diameter, steady", "{:.1f} m", ("turning_diameter_m",)),
    ("turning rate, steady", "{:.2f} °/s", ("turning_rate_deg_s",)),
    ("first overshoot", "{:.1f}°", ("overshoot_first_deg",)),
    ("second overshoot", "{:.1f}°", ("overshoot_second_deg",)),
    ("zigzag period", "{:.1f} s", ("zigzag_period_s",)),
    ("fin travel", "{:.2f} °/s, mean way of a fin while armed", ("fin_travel_deg_s",)),
)
_COMPUTER: _Formats = (
    ("wall time", "{:.1f} s", ("wall_time_s",)),
    ("speed-up", "{:.1f} ×", ("speed_up",)),
    ("late cycles", "{:d}", ("late_cycles",)),
)


def summary_table(summary: Summary) -> Group:
    """The summary as the terminal shows it: the outcome in a line of its own, then the figures in their groups."""
    groups = key_figures(summary)
    width = min(LABEL_WIDTH, max(len(label) for rows in groups.values() for label, _ in rows))
    parts = [Padding(Text(outcome(summary), style="bold"), (0, 2))]
    for title, rows in groups.items():
        table = Table(show_header=False, box=None, padding=(0, 2, 0, 0), pad_edge=False)
        table.add_column(width=width)
        table.add_column(overflow="fold")
        for label, value in rows:
            table.add_row(label, value)
        parts += [Padding(Text(title, style="dim"), (0, 2)), Padding(table, (0, 0, 0, 4))]
    return Group(*parts)


def outcome(summary: Summary) -> str:
    """Return one phrase: whether the run was completed, and if not, why, and whether it ended safely all the same."""
    if summary["completed"] is None:
        return str(summary["reason"])
    believed = ", by the vehicle's own estimate" if summary.get("judged_by") == "estimate" else ""
    if summary.get("surfaced"):
        how = f"not completed, but {summary['reason']}{believed}"
    elif summary["completed"]:
        dropped = summary["health"]["weight_released_s"] is not None
        how = f"completed{', without its drop weight' if dropped else ''}{believed}"
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
        f"and ended {_where(after['mode'], after['depth_m'])}"
    )


def _where(mode: str, depth: float) -> str:
    """Return in which mode and how deep, m, a vehicle is."""
    metres = f"{depth:.1f} m".removeprefix("-" if round(depth, 1) == 0.0 else "")
    return f"in mode {mode}, {f'at the surface ({metres})' if depth < SURFACE else f'{metres} deep'}"


def key_figures(summary: Summary) -> dict[str, Rows]:
    """Return (label, figure with its unit) by group, in the order in which people ask, without what the log cannot say.

    A group's title tells where its figures are of the logged part alone, and where they are of the estimate.
    """
    part = ", while logged" if summary.get("after_log") else ""
    believed = " by the estimate" if summary["against"] == "estimate" else ""
    groups = {
        "end of the flight": _ended(summary),
        f"found in flight{part}": _found(summary),
        f"learned{part}": [*_learned(summary), *_adopted(summary)],
        f"accuracy{believed}{part}": [
            *_rows(summary, _ACCURACY),
            *_heading(summary),
            *_rows(summary, _POSITION),
            *_before_fix(summary),
            *_sigma(summary),
            *_rows(summary, _MANOEUVRES),
        ],
        "computer and links": [*_rows(summary, _COMPUTER), *_lateness(summary), *_lost(summary)],
    }
    return {title: rows for title, rows in groups.items() if rows}


def _ended(summary: Summary) -> Rows:
    """Return where the vehicle was at the end, and how far it came."""
    end = summary["ended"]
    found = [] if end["depth_m"] is None else [("ended", _where(end["mode"], end["depth_m"]))]
    if None not in (end["north_m"], end["east_m"]):
        sides = [_side(end[key], *words) for key, words in _SIDES.items()]
        found.append(("ended, from the origin", ", ".join(filter(None, sides)) or "0 m"))
    truth = summary["by_truth"] or {}
    if truth.get("up_s") is not None and not (summary["completed"] or summary["surfaced"] or summary["after_log"]):
        found.append(("at the surface, by the truth", f"from {truth['up_s']:.1f} s on, less than {SURFACE:g} m deep"))
    if summary["waypoints_total"]:
        found.append(("waypoints", f"{summary['waypoints_passed']} of {summary['waypoints_total']}"))
    found += _rows(summary, _TRAVELLED)
    if summary.get("after_log"):
        found.append(("logged", f"{summary['logged_s']:.1f} s"))
    elif summary["lost"] and summary["lost"] not in summary["reason"]:
        found.append(("the log is", summary["lost"]))
    part = " while logged" if summary.get("after_log") else ""
    return [*found, ("distance travelled", f"{summary['distance_m']:.0f} m{part}")]


def _side(metres: float, positive: str, negative: str) -> str:
    """Return how far to which side; "" where it rounds to nothing."""
    whole = round(metres)
    return f"{abs(whole)} m {negative if whole < 0 else positive}" if whole else ""


def _found(summary: Summary) -> Rows:
    """Return what was wrong, as the vehicle found it, and what was made wrong on purpose."""
    found = health_record.key_figures(summary["health"], summary["logged_s"])
    found += [(loss.source, loss.text) for loss in losses.outliers(summary["losses"])]
    found += [*_true_weight(summary), *findings.key_figures(summary["found"])]
    if left := left_by_the_fins(summary):
        found.append(("left at the end", left))
    for label, key in (("faults injected", "faults"), ("of these not begun at the end", "faults_not_begun")):
        if summary[key]:
            found.append((label, ", ".join(summary[key])))
    return found


def _true_weight(summary: Summary) -> Rows:
    """Return what truly became of the drop weight, where the vehicle does not know it, or found it out later."""
    health, truth = summary["health"], summary["by_truth"]
    told = health["weight_commanded_s"], health["weight_released_s"]
    if truth is None or ((gone := truth["weight_gone_s"]) is None and told == (None, None)):
        return []
    if None not in (gone, told[1]) and abs(gone - told[1]) < _SOON:
        return []
    return [("drop weight, by the truth", "still aboard" if gone is None else f"gone at {gone:.1f} s")]


def left_by_the_fins(summary: Summary) -> str:
    """Return what of diving and turning is left at the end; "" where all is, and for a log that does not tell."""
    limits = summary["limits"] or {}
    names = {"dive_left_pct": "diving", "turn_left_pct": "turning"}
    shares = {word: limits[key]["end"] for key, word in names.items() if limits.get(key)}
    if all(share is None or share > 99.5 for share in shares.values()):
        return ""
    return ", ".join(f"{share:.0f} % of {word}" for word, share in shares.items() if share is not None)


def _lost(summary: Summary) -> Rows:
    """Return what was lost, the worst first."""
    told = losses.told(summary["losses"], summary["received"], summary["two_senders"])
    found = [(loss.source, loss.text) for loss in told[:_MOST_LOSSES]]
    more = len(told) - _MOST_LOSSES
    return [*found, ("other losses", f"and {more} more: see the report")] if more > 0 else found


def _rows(summary: Summary, formats: _Formats) -> Rows:
    return [
        (label, form.format(*(summary[key] for key in keys)))
        for label, form, keys in formats
        if all(summary[key] is not None for key in keys)
    ]


def _heading(summary: Summary) -> Rows:
    off = summary["heading_estimate_error_mean_deg"]
    return [] if off is None else [("heading estimate off, mean", f"{signed(off, '.2f')}°")]


def _before_fix(summary: Summary) -> Rows:
    """Return how far the position was off until a fix told it, if further than ever since."""
    before, since = summary["navigation_error_before_fix_m"], summary["navigation_error_max_m"]
    if before is None or since is None or before <= since:
        return []
    return [("position off before a first fix", f"{before:.2f} m at most, until {summary['first_fix_s']:.1f} s")]


def _sigma(summary: Summary) -> Rows:
    std = summary["position_std_end_m"]
    return [] if std is None else [("position 3 σ at the end", f"{3.0 * std:.2f} m")]


def _lateness(summary: Summary) -> Rows:
    late = summary["lateness"]
    if not late:
        return []
    names = (("median", "median_us"), ("99 % within", "p99_us"), ("greatest", "max_us"))
    return [(f"lateness, {name}", lateness_histogram.with_unit(late[key])) for name, key in names]


def _learned(summary: Summary) -> Rows:
    learned = summary["learned"]
    if not learned:
        why = summary["not_learned_because"]
        return [("coefficients", f"not learned: {why}")] if why else []
    valid = {name: one for name, one in learned["coefficients"].items() if one["valid"]}
    found = [("coefficients valid", f"{len(valid)} of {len(learned['coefficients'])}")]
    if why := learned.get("not_valid_because"):
        found.append(("why not the others" if valid else "why none", why))
    errors = {name: one["error_pct"] for name, one in valid.items() if one["error_pct"] is not None}
    if errors:
        worst = max(errors, key=lambda name: abs(errors[name]))
        sigmas = abs(valid[worst]["error_sigmas"])
        found.append(("worst valid coefficient", f"{worst} {_percent(errors[worst])} ({sigmas:.1f} σ)"))
    return found


def _percent(value: float) -> str:
    """Return a share in % with its sign and two digits, or all of those before the point."""
    return f"{signed(value, '.2g' if abs(value) < 9.95 else '.0f')} %"


def _adopted(summary: Summary) -> Rows:
    """Return from when the laws used what was learned, and errors before and after."""
    adoption = summary["adoption"]
    if not adoption:
        if summary["adoption_off"]:
            return [("laws designed from", "vehicle.toml: adoption is off")]
        refused = summary["adoption_refused"] if summary["learned"] else {}
        return [(f"{law} law designed from", f"vehicle.toml: {why}") for law, why in refused.items()]
    found = []
    for (law, one), form in zip(adoption["laws"].items(), ("{:.3f} m", "{:.2f}°"), strict=True):
        errors = (one["rms_moving_before"], one["rms_moving_after"])
        why = summary.get("adoption_refused", {}).get(law)
        found.append((f"{law} law learned", f"{adopted_text(one)}{f': {why}' if why else ''}"))
        label = f"{law} error in {'dives' if law == 'depth' else 'turns'} (RMS)"
        if one["adopted_s"] is not None and None in errors:
            found.append((label, f"not compared: {one['not_compared_because']}"))
        if None not in errors:
            before, after = map(form.format, errors)
            what = "it was confirmed" if one.get("earlier_s") is not None else "all was learned"
            found.append((label, f"{before} before {what}, {after} after"))
    known = [one for one in adoption["coefficients"].values() if one["error_before_pct"] is not None]
    if known:
        worst = [max(abs(one[key]) for one in known) for key in ("error_before_pct", "error_after_pct")]
        found.append(("laws' coefficients, worst error", "{:.3g} % by the file, {:.3g} % at the end".format(*worst)))
    return found
