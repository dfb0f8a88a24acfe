"""The sentences of events, for people: the one place where they are made, for every log, link and terminal.

Nothing reads them back: who needs to know what happened looks at the `Event`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from firmware_py.records.adoption import design_text
from firmware_py.records.cause_text import ANGLES, CAUSES, REMEDIES
from firmware_py.records.command import AscentStage
from firmware_py.records.event import Cause, Event, EventKind, Severity
from firmware_py.records.fence import breach_text
from firmware_py.records.health import ActuatorFault, SourceFault
from firmware_py.records.health_text import (
    actuator_fault_text,
    choice_text,
    node_text,
    sensor_text,
    source_fault_text,
    stage_text,
)
from firmware_py.records.learning_text import report_text
from firmware_py.records.order import NOBODY, Asker, Mode
from firmware_py.records.passport import moved_text

ModeName = Callable[[Mode], str]
"""What a mode is called."""


class Sentence(NamedTuple):
    """What happened, for people, and its severity."""

    text: str
    severity: Severity


_SOURCES: Mapping[Cause, str] = {
    Cause.AHRS_SUSPECT: "AHRS",
    Cause.PRESSURE_SUSPECT: "pressure sensor",
    Cause.DVL_BAD: "DVL",
    Cause.ALTIMETER_BAD: "altimeter",
}
_LOST: Mapping[Cause, str] = {Cause.ATTITUDE_LOST: "AHRS", Cause.DEPTH_LOST: "pressure sensor"}
"""The sensor that is wanting."""
_ACTUATORS = (
    *(Cause.PLANE_FAULT, Cause.RUDDER_FAULT, Cause.PROPELLER_FAULT),
    *(Cause.ACTUATOR_SILENT, Cause.ACTUATOR_WORN),
)

_BY_AXIS = (Cause.PLANE_FAULT, Cause.RUDDER_FAULT, Cause.DAMAGED)
"""What fins of an axis do together."""


def sentences(events: Iterable[Event], name: ModeName = lambda mode: mode.name) -> list[Sentence]:
    """Return the sentences of the events of one cycle: mostly one for each event.

    The causes for which arming is refused, and the parts of a learning report, come in one sentence, which has the
    severity of its most severe part.

    Args:
        events: in the order in which they happened.
        name: what modes are called.
    """
    groups: list[list[Event]] = []
    for event in events:
        last = groups[-1][-1] if groups else None
        together = event.kind in _TOGETHER or _is_weak(event)
        if last is not None and together and _about(last) == _about(event):
            groups[-1].append(event)
        else:
            groups.append([event])
    return [Sentence(_text(group, name), min(event.severity for event in group)) for group in groups]


def texts(events: Iterable[Event]) -> list[str]:
    """Return the sentences alone, with the core's own names of modes."""
    return [sentence.text for sentence in sentences(events)]


_TOGETHER = (
    *(EventKind.ARMING_REFUSED, EventKind.ARMING_CHECK_FAILED),
    *(EventKind.LEARNING_REPORT, EventKind.MODEL_CHANGED),
)


def _is_weak(event: Event) -> bool:
    return event.kind is EventKind.ACTUATOR_FAULT and event.numbers[0] == ActuatorFault.WEAK


def _about(event: Event) -> tuple[object, ...]:
    return event.kind, event.asker, event.manoeuvre, _is_weak(event)


def _text(events: Sequence[Event], name: ModeName) -> str:
    first = events[0]
    if first.kind is EventKind.ARMING_REFUSED:
        return f"arming refused{_station(' to', first.asker)}: {_obstacles(events)}"
    if first.kind is EventKind.ARMING_CHECK_FAILED:
        return f"arming would be refused: {_obstacles(events)}"
    if first.kind is EventKind.LEARNING_REPORT:
        return f"{_manoeuvre(first)}: {report_text(events)}"
    if first.kind is EventKind.MODEL_CHANGED:
        what = "this flight against the earlier" if first.numbers[0] else "earlier flight against the vehicle file"
        moved = [moved_text(event.names[0], event.names[1], *event.numbers[1:]) for event in events]
        return f"{what}: {'; '.join(moved)}"
    if len(events) > 1:  # by the hull's answer, which tells what they do together
        names = " or ".join(event.names[0] for event in events)
        return f"{names}, one or more of them: {actuator_fault_text(ActuatorFault.WEAK)}"
    return _ONE[first.kind](first, name)


def _cause(event: Event, skip: int = 0) -> str:
    cause, numbers = event.cause, event.numbers[skip:]
    if cause is Cause.BATTERY_LOW or cause is Cause.BATTERY_WARNING:
        return f"{_battery(numbers[0])}, less than {numbers[1]:.0%}"
    if cause is Cause.ENERGY:
        needs = f"the way home needs {numbers[1]:.0%}" if numbers[1] < 1.0 else "not enough for the way home"
        return f"{_battery(numbers[0])}, {needs}"
    if cause is Cause.CHARGE_NEEDED:
        return f"{_battery(numbers[0])}, needs {numbers[1]:.0%}"
    if cause is Cause.FENCE:
        return breach_text(int(numbers[0]))
    if cause in _LOST:
        why = f" ({_LOST[cause]}: {source_fault_text(numbers[1])})" if any(numbers[1:]) else ""
        return CAUSES[cause].format(*numbers) + why
    if cause in ANGLES:
        return ANGLES[cause].format(*map(math.degrees, numbers))
    if cause in _SOURCES:
        return f"{_SOURCES[cause]} not to be relied on: {source_fault_text(numbers[0])}"
    if cause is Cause.DAMAGED:
        left = f"{numbers[1]:.0%} of diving and {numbers[2]:.0%} of turning are left"
        return f"damage found: {_fault(event, numbers[0])}; {left}"
    if cause in _ACTUATORS:
        return _fault(event, numbers[0])
    if cause is Cause.RULES_OFF:
        return f"set so that it is not brought up: {', '.join(event.names)}"
    if cause is Cause.RESTARTED:
        mode = Mode(int(numbers[1])).name
        where = "where the depth is not known" if math.isnan(numbers[0]) else f"{numbers[0]:.1f} m under water"
        return f"started again {where}, {numbers[2]:.0f} s after its program ended in {mode}"
    if cause is Cause.SUNK and math.isnan(numbers[0]):
        return "sunk again, as the bottom that comes nearer says, after it had surfaced"
    if cause is Cause.STARTED_UNDER_WATER:
        where = "where the depth is not known" if math.isnan(numbers[0]) else f"{numbers[0]:.1f} m under water"
        return f"started {where}; arm it in SURFACE to bring it up"
    if cause is Cause.UNDER_WATER:
        depth = "depth not known" if math.isnan(numbers[0]) else f"under water, at {numbers[0]:.1f} m"
        return f"{depth}; surface first, or force it (param2 = 21196)"
    if cause is Cause.ORDERED:
        return f"ordered{_station(' by', event.asker)}"
    return CAUSES[cause].format(*numbers)


def _fault(event: Event, number: float) -> str:
    name = event.names[0] if event.names else "an actuator"
    if number == ActuatorFault.WEAK and event.cause in _BY_AXIS:
        return f"{name}: half of the effect is left"
    return f"{name}: {actuator_fault_text(number)}"


def _obstacles(events: Sequence[Event]) -> str:
    """Return what keeps a vehicle from being armed; a fin of an X, which is plane and rudder, is named once."""
    return "; ".join(dict.fromkeys(map(_obstacle, events)))


def _obstacle(event: Event) -> str:
    """Return what keeps a vehicle from being armed, with the remedy where it is not plain."""
    remedy = REMEDIES.get(event.cause)
    return f"{_cause(event)} ({remedy})" if remedy else _cause(event)


def _battery(charge: float) -> str:
    return "battery not heard" if math.isnan(charge) else f"battery at {charge:.0%}"


def _station(how: str, asker: Asker) -> str:
    """Which station it was, by system and component; nothing if it was none."""
    return "" if asker == NOBODY else f"{how} station {asker.system}/{asker.component}"


def _manoeuvre(event: Event) -> str:
    return "manoeuvre" if event.manoeuvre is None else event.manoeuvre.name.lower()


def _mode_changed(event: Event, name: ModeName) -> str:
    before, after = (name(mode) if mode is not None else "?" for mode in (event.before, event.after))
    return f"{before} -> {after}: {_cause(event)}"


def _mode_refused(event: Event, name: ModeName) -> str:
    asked = name(event.after) if event.after is not None else "?"
    if event.cause is Cause.NOTHING_TO_END:
        asked = "flight termination"
    return f"{asked} refused{_station(' to', event.asker)}: {_cause(event)}"


def _mode_chosen(event: Event, name: ModeName) -> str:
    chosen = name(event.after) if event.after is not None else "?"
    return f"{chosen} chosen{_station(' by', event.asker)}; arming begins it"


def _back(event: Event) -> str:
    now, was = [*event.numbers, SourceFault.NONE, SourceFault.NONE][:2]
    if now == SourceFault.SILENT:
        return "not heard, and not expected: it is under water"
    return "is heard again, and believed" if was == SourceFault.SILENT else "agrees again"


def _given_up(event: Event, _: ModeName) -> str:
    return f"{_manoeuvre(event)} given up after {event.numbers[0]:.1f} s: {_cause(event, 1)}"


def _by_a_rule(event: Event, does: str) -> str:
    """Return the cause; of what a watch told a moment before in the same words also what the rule does about it."""
    told_before = event.cause in _SOURCES or event.cause in _ACTUATORS
    return f"{_cause(event)} ({does})" if told_before else _cause(event)


def _because(event: Event, skip: int = 0) -> str:
    return "" if event.cause is Cause.NONE else f": {_cause(event, skip)}"


def _missed(which: float, of: float, shallow: float) -> str:
    return f"waypoint {which:.0f} of {of:.0f} given up {abs(shallow):.1f} m too {'shallow' if shallow > 0 else 'deep'}"


def _ascent_stage(event: Event, _: ModeName) -> str:
    stage = event.numbers[0]
    if stage == AscentStage.NONE and event.cause is not Cause.NONE:  # before the first stage, or in another mode
        return _cause(event, 1)
    return f"coming up: {stage_text(stage)}{_because(event, 1)}"


_ONE: Mapping[EventKind, Callable[[Event, ModeName], str]] = {
    EventKind.MODE_CHANGED: _mode_changed,
    EventKind.MODE_REFUSED: _mode_refused,
    EventKind.ARMING_CHECK_PASSED: lambda *_: "ready to be armed",
    EventKind.RULE_HOLDS: lambda event, _: _by_a_rule(event, "one more reason for the mode"),
    EventKind.CHANGE_FAILED: lambda event, _: f"change not made: {'; '.join(event.names)}",
    EventKind.WAYPOINT_PASSED: lambda event, _: "waypoint {:.0f} of {:.0f} passed".format(*event.numbers),
    EventKind.RALLY_POINT_REACHED: lambda *_: "rally point reached",
    EventKind.RALLY_POINT_UNREACHABLE: lambda *_: "no rally point has a straight way within the fence",
    EventKind.LOITER_DONE: lambda event, _: f"loiter done at item {event.numbers[0]:.0f}",
    EventKind.MANOEUVRE_BEGUN: lambda event, _: (
        f"{_manoeuvre(event)} begins: {event.numbers[0]:g} s about {event.numbers[1]:.1f} m"
    ),
    EventKind.MANOEUVRE_WAITS: lambda event, _: f"{_manoeuvre(event)} waits: {_cause(event)}",
    EventKind.MANOEUVRE_RESUMED: lambda event, _: f"{_manoeuvre(event)} goes on",
    EventKind.MANOEUVRE_DONE: lambda event, _: (
        f"{_manoeuvre(event)} done: {event.numbers[0]:g} s, and {event.numbers[1]:.1f} s of waiting"
    ),
    EventKind.MANOEUVRE_GIVEN_UP: _given_up,
    EventKind.SENSOR_GOOD: lambda event, _: f"{sensor_text(event.names[0])} {_back(event)}",
    EventKind.SENSOR_SUSPECT: lambda event, _: (
        f"{sensor_text(event.names[0])} not believed: {source_fault_text(event.numbers[0])}"
    ),
    EventKind.SENSOR_LOST: lambda event, _: (
        f"{sensor_text(event.names[0])} lost: {source_fault_text(event.numbers[0])}"
    ),
    EventKind.CANDIDATE_BELIEVED: lambda event, _: f"{sensor_text(event.names[0])}: {choice_text(*event.numbers)}",
    EventKind.ACTUATOR_GOOD: lambda event, _: f"{event.names[0]} works again",
    EventKind.ACTUATOR_FAULT: lambda event, _: f"{event.names[0]}: {actuator_fault_text(event.numbers[0])}",
    EventKind.ASCENT_STAGE: _ascent_stage,
    EventKind.WEIGHT_RELEASED: lambda event, _: f"drop weight released{_because(event)}",
    EventKind.RULE_WARNS: lambda event, _: _by_a_rule(event, "a rule warns"),
    EventKind.NODE_GOOD: lambda event, _: node_text(event.names, SourceFault.NONE),
    EventKind.NODE_FAULT: lambda event, _: node_text(event.names, event.numbers[0]),
    EventKind.WAYPOINT_MISSED: lambda event, _: _missed(*event.numbers),
    EventKind.MODE_CHOSEN: _mode_chosen,
    EventKind.HOME_REACHED: lambda *_: "home reached",
    EventKind.HOME_UNREACHABLE: lambda *_: "home has no straight way within the fence",
    EventKind.HOME_NOT_KNOWN: lambda event, _: (
        "where home lies is not known: {:.0f} m away by a position to {:.0f} m".format(*event.numbers)
    ),
    EventKind.NODE_RESTARTED: lambda event, _: f"node {', '.join(event.names)} has restarted",
    EventKind.PARAMETER_CHANGED: lambda event, _: f"{event.names[0]} changed from {' to '.join(event.names[1:])}",
    EventKind.DESIGN_CHANGED: lambda event, _: f"{event.names[0]} law: {design_text(*event.numbers)}",
    EventKind.POSITION_RESET: lambda event, _: f"position put right by {event.numbers[0]:.0f} m: fixes contradicted it",
    EventKind.WEIGHT_COMMANDED: lambda event, _: f"release of the drop weight commanded{_because(event)}",
    EventKind.WEIGHT_NOT_RELEASED: lambda event, _: f"drop weight not released{_because(event)}",
    EventKind.WEIGHT_HELD: lambda *_: "drop weight held: its hardpoint says so",
    EventKind.WEIGHT_SILENT: lambda *_: "drop weight: its hardpoint says nothing any longer",
    EventKind.OWN_PART_FAILED: lambda event, _: "{} {} failed, the built-in one goes on: {}".format(*event.names),
}
