"""The page of a flight: its key figures, its events, how the vehicle was set up, and the plots."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from firmware_py.control.control import LawKind
from firmware_py.control.sliding_mode_params import PAPER_DEPTH_GAINS, PAPER_HEADING_GAINS, GainSet
from firmware_py.params import dump, to_toml_value
from firmware_py.part_name import PartName
from firmware_py.records.event import Cause, Severity
from firmware_py.records.event_text import texts
from firmware_py.records.health_text import sensor_text
from sternplane.logs import losses
from sternplane.logs.event_list import listed_events
from sternplane.logs.health_record import actuator_text, faults_text
from sternplane.logs.run import Run
from sternplane.logs.summary import Summary
from sternplane.logs.summary_text import key_figures, left_by_the_fins, outcome, unlogged
from sternplane.report import fault_marks, health_plot
from sternplane.report.adoption_table import adoption_section
from sternplane.report.figures import Figures, mode_colours
from sternplane.report.limits_table import limits_section
from sternplane.report.page import Cell, Heading, Page, Section, Table, made_by, plot_section, render
from sternplane.report.steering_text import control_of, steering_text

_MOST_EVENTS = 500
"""So many from the begin and so many from the end are listed."""
_STATES = {
    **dict.fromkeys((Severity.EMERGENCY, Severity.ALERT, Severity.CRITICAL, Severity.ERROR), "bad"),
    Severity.WARNING: "warn",
}
"""How severities are shown that stand out."""
_GAINS = {
    GainSet.CONFIGURED: "of the configuration: control.depth and control.heading, as below",
    GainSet.PAPER: "the paper's poles, switching angles and boundary layers",
}
_IDENTITY = (("seed", "seed"), ("faults", "faults"), ("revision", "git"), ("recorded", "stamp"))


def flight_page(log: Run, summary: Summary) -> str:
    """Return the report of a flight as HTML."""
    header, figures = log.header, Figures(log)
    shown = [(plot, not plot.tall and (i == 0 or plot.title == health_plot.TITLE)) for i, plot in enumerate(figures)]
    sections: list[Section | Heading] = [plot_section(plot, wide=wide) for plot, wide in shown if not plot.section]
    sections.append(Section("Events", tables=(Table(_events(log), style="log"),), wide=True, anchor="events"))
    sections += adoption_section(summary)
    sections += limits_section(summary)
    group = ""
    for plot, wide in shown:
        if plot.section and plot.section != group:
            group = plot.section
            sections.append(Heading(group, anchor=group.lower()))
        if plot.section:
            sections.append(plot_section(plot, wide=wide))
    sections += _losses(summary)
    sections.append(Heading("Set-up", anchor="setup"))
    if settings := [*_settings(header)]:
        sections.append(Section("Law, gains and configuration", tables=(Table(settings, style="log"),), wide=True))
    sections.append(Section("Made by", tables=(Table(made_by(header), style="log"),), wide=True))
    page = Page(
        title=str(header.get("scenario", "run")),
        status=outcome(summary),
        mood="warn" if summary["surfaced"] else {True: "good", False: "bad"}.get(summary["completed"], "neutral"),
        description=_description(header),
        identity=[line for line in (_identity(header), steering_text(header)) if line],
        warnings=_warnings(log, summary),
        key_figures=key_figures(summary),
        colours=mode_colours(figures.bands),
        marks=fault_marks.key(figures.marks),
        sections=sections,
        footnote=_footnote(figures),
    )
    return render(page)


def _description(header: Mapping[str, Any]) -> str:
    """Return the scenario's words, with what was set upon the simulated vehicle and sea, which they do not know."""
    laid = [
        f"{k} = {_value(v)}" for k, v in header.get("settings", {}).items() if k.startswith(("truth.", "scenario."))
    ]
    words = str(header.get("description", ""))
    return f"{words} Other than that: {', '.join(laid)}." if words and laid else words


def _events(log: Run) -> list[tuple[Any, ...]]:
    """Return the rows of the events' table: time, severity in its colour, sentence."""
    rows: list[tuple[Any, ...]] = []
    for event in listed_events(log):
        state = "" if event.severity is None else _STATES.get(event.severity, "note")
        rows.append((f"{event.t:.2f} s", Cell(event.severity_word or "", state), event.text))
    if len(rows) > 2 * _MOST_EVENTS:
        left_out = ("", "", f"{len(rows) - 2 * _MOST_EVENTS} more: see summary.json")
        return [*rows[:_MOST_EVENTS], left_out, *rows[-_MOST_EVENTS:]]
    return rows or [("", "", "none")]


def _losses(summary: Summary) -> Iterator[Section]:
    """Yield what was lost on wires and links and what was refused of what came, for people, and every count."""
    told = losses.told(summary["losses"], summary["received"], summary["two_senders"])
    told += losses.outliers(summary["losses"])
    if not told:
        return
    seen = summary["losses_seen_s"]
    counts = [
        [name.replace("_", " "), str(count), *(f"{t:.1f}" for t in seen.get(name, ()))]
        for name, count in summary["losses"].items()
        if count
    ]
    tables = (
        Table([[loss.source, loss.text] for loss in told], style="words"),
        Table(counts, head=("count", "", "first, s", "last, s"), style="numbers"),
    )
    yield Section("Losses and refused values", tables=tables, wide=True, anchor="losses")


def _warnings(log: Run, summary: Summary) -> list[str]:
    faults = [*_doubts(summary), *_damage(log, summary)]
    if summary["after_log"]:
        part = f"Plots and figures are of a part of the flight alone: {unlogged(summary)}. Events are of all of it."
        return [part, *faults]
    return [f"The log is {log.lost}.", *faults] if log.lost else faults


def _doubts(summary: Summary) -> list[str]:
    """Return one warning of all sensors that were not believed; none if all were."""
    sensors = summary["health"]["sensors"].items()
    told = "; ".join(f"{sensor_text(name)}: {faults_text(one)}" for name, one in sensors)
    return [f"Sensors not believed: {told}."] if told else []


def _damage(log: Run, summary: Summary) -> list[str]:
    """Return one warning of all that was wrong with fins and propeller, with what they can still do; none if nothing.

    Where the motion told of an axis alone the event says so.
    """
    faulty = summary["health"]["actuators"]
    found = [f"{name} {actuator_text(one, summary['logged_s'])}" for name, one in faulty.items()]
    damage = ((t, event) for t, events in log.events for event in events if event.cause is Cause.DAMAGED)
    found += [
        f"at {t:.1f} s {text}"
        for t, event in damage
        if not faulty.keys() & set(event.names)
        for text in texts((event,))
    ]
    if not found:
        return []
    left = left_by_the_fins(summary)
    return [f"Fins and propeller: {'; '.join(found)}.{f' At the end {left} are left.' if left else ''}"]


def _identity(header: Mapping[str, Any]) -> str:
    known = [
        f"{name} {', '.join(map(str, header[key])) if isinstance(header[key], list) else header[key]}"
        for name, key in _IDENTITY
        if header.get(key) not in (None, [])
    ]
    settings = [f"{key} = {_value(value)}" for key, value in header.get("settings", {}).items()]
    return " · ".join([*known, f"set {', '.join(settings)}"] if settings else known)


def _settings(header: Mapping[str, Any]) -> Iterator[list[str]]:
    """Yield the files that the vehicle was made from, what it began with, its laws and their gains."""
    for name, path in header.get("configuration", {}).get("files", {}).items():
        yield [f"{name} file", str(path)]
    if factors := header.get("vehicle_factors"):
        yield ["vehicle file times, by the scenario", ", ".join(_multiplied(factors))]
    for key, value in header.get("settings", {}).items():
        yield ["set", f"{key} = {_value(value)}"]
    for note in header.get("notes", []):
        yield ["of an earlier run", str(note)]
    control = control_of(header)
    if control is None:
        return
    sliding = control.law is LawKind.SLIDING
    yield ["law", to_toml_value(control.law, 1.0)]
    for key, part in header.get("own_parts", {}).items():
        yield [f"{key}, one's own", f"{part['class']}, source {part['source']} of {part['package']}"]
    if isinstance(control.law, PartName):
        if control.own:
            yield ["own", ", ".join(f"{one} = {_value(value)}" for one, value in control.own.items())]
        return
    if sliding:
        yield ["gains", _GAINS[control.gains]]
    printed = {"depth": PAPER_DEPTH_GAINS, "heading": PAPER_HEADING_GAINS} if control.gains is GainSet.PAPER else {}
    for name in ("depth", "heading", "speed"):
        key = name if sliding or name == "speed" else f"{name}_pid"
        gains = dump(printed.get(key, getattr(control, key)))
        yield [name, ", ".join(f"{one} = {_value(value)}" for one, value in gains.items())]


def _multiplied(factors: Mapping[str, Any], table: str = "") -> Iterator[str]:
    """Yield the numbers of vehicle.toml that a scenario multiplied, such as "coefficients.M_q 0.6"."""
    for key, factor in factors.items():
        if isinstance(factor, Mapping):
            yield from _multiplied(factor, f"{table}{key}.")
        else:
            yield f"{table}{key} {factor:g}"


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower()


def _footnote(figures: Figures) -> str:
    if figures.envelope:
        shown = f"Lines show the least and the greatest value of every {2 * figures.stride} cycles"
    else:
        shown = f"Plots show every {_ordinal(figures.stride)} cycle ({figures.rate:.3g} Hz)"
    return f"{shown}; the figures use all of them."


def _ordinal(n: int) -> str:
    endings = {1: "st", 2: "nd", 3: "rd"}
    return "" if n == 1 else f"{n}{'th' if 10 < n % 100 < 14 else endings.get(n % 10, 'th')}"
