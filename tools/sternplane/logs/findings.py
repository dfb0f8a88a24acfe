"""What the rules of the supervisor and the monitor of the bus found in a flight, from its events."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind
from firmware_py.records.event_text import texts
from firmware_py.records.health import ActuatorFault
from firmware_py.records.order import Mode
from firmware_py.safety.rules import RULES
from sternplane.logs.health_record import Timeline

_OF_SENSORS: Mapping[Cause, str] = {
    Cause.AHRS_SUSPECT: "ahrs",
    Cause.HEADING_SUSPECT: "ahrs",
    Cause.PRESSURE_SUSPECT: "pressure",
    Cause.DVL_BAD: "dvl",
    Cause.ALTIMETER_BAD: "altitude",
}
_KEYS: Mapping[Cause, list[str]] = {
    cause: [rule.answer for rule in RULES if rule.cause is cause and isinstance(rule.answer, str) and rule.answer]
    for cause in {rule.cause for rule in RULES}
}
"""The keys of [autopilot.safety] that say what is done for each cause."""
_DOES = (" (a rule warns)", " (one more reason for the mode)")
"""What stands behind a sentence; the key joins it."""
_TOGETHER = 1.0
"""What falls silent within so long of each other, s, is told together: the rule names the first of them alone."""
_NODES = (EventKind.NODE_FAULT, EventKind.NODE_RESTARTED)
_LABELS = {"rule": "by the rules", "bus": "on the bus"}
Finding = dict[str, Any]


def findings(
    events: Iterable[tuple[float, tuple[Event, ...]]],
    faulty: Collection[str],
    actuators: Mapping[str, Timeline] | None = None,
) -> list[Finding]:
    """Return each thing once: by whom ("rule", "bus"), as what, first when, s, and how many times it was told.

    `key` is that of [autopilot.safety] which says what is done, "" where there is none. `known`: a rule warns of what
    is told of the sensor or the actuator itself, too.

    Args:
        events: of a flight, with their times, s.
        faulty: sensors and actuators that are known to have been at fault.
        actuators: their faults over time (`HealthRecord.actuators`).
    """
    found: dict[tuple[Any, ...], Finding] = {}
    mode = Mode.DISARMED
    for t, happened in events:
        for event in happened:
            before = mode if event.before is None else event.before
            mode = event.after if event.kind is EventKind.MODE_CHANGED and event.after is not None else mode
            by = _by(event)
            if not by:
                continue
            told = _with_others(event, t, actuators or {})
            one = found.setdefault(
                (event.kind, event.cause, event.names, event.after, *(event.numbers if by == "bus" else ())),
                {
                    "by": by,
                    "text": texts((told,))[0],
                    "key": _key(event, before),
                    "known": _known(event, faulty),
                    "first_s": t,
                    "times": 0,
                },
            )
            one["times"] += 1
    return list(found.values())


def key_figures(found: Iterable[Finding]) -> list[tuple[str, str]]:
    """Return (label, text) of them for people, a line for each of those who found them."""
    told: dict[str, list[str]] = {}
    for one in found:
        times = f", {one['times']} times" if one["times"] > 1 else ""
        text = _with_key(one["text"], one["key"])
        told.setdefault(_LABELS[one["by"]], []).append(f"{text}, at {one['first_s']:.1f} s{times}")
    return [(label, "; ".join(those)) for label, those in told.items()]


def _with_key(text: str, key: str) -> str:
    """Return a sentence with the key that decided, in the brackets that it ends with if a rule's doing stands there."""
    if not key:
        return text
    return f"{text[:-1]}: {key})" if text.endswith(_DOES) else f"{text} ({key})"


def _with_others(event: Event, t: float, actuators: Mapping[str, Timeline]) -> Event:
    """Return the event of silent actuators with the names of all that fell silent then."""
    if event.cause is not Cause.ACTUATOR_SILENT or not event.names:
        return event
    names = [
        name
        for name, line in actuators.items()
        if name in event.names
        or any(s.value == ActuatorFault.SILENT and s.begin <= t + _TOGETHER and s.end >= t for s in line.spans)
    ]
    return dataclasses.replace(event, names=(", ".join(names or event.names),))


def _key(event: Event, mode: Mode) -> str:
    """Return the key that decided; where several are of one cause, by the mode or by what the actuator did."""
    keys = _KEYS.get(event.cause, [])
    if event.kind in _NODES or not keys:
        return ""
    if event.cause is Cause.STATION_LOST:
        return next((key for key in keys if key == f"station.{mode.name.lower()}_action"), "")
    if event.cause is Cause.PROPELLER_FAULT:
        runaway = bool(event.numbers) and event.numbers[0] == ActuatorFault.RUNAWAY
        return "runaway_action" if runaway else "propeller_action"
    return keys[0]


def _by(event: Event) -> str:
    """Return who found what an event tells; "" if it tells of nothing found."""
    if event.kind in _NODES:
        return "bus"
    if event.kind is EventKind.MODE_CHANGED:
        return "" if event.cause in INTENDED_CAUSES or event.cause is Cause.NONE else "rule"
    return "rule" if event.kind in (EventKind.RULE_HOLDS, EventKind.RULE_WARNS) else ""


def _known(event: Event, faulty: Collection[str]) -> bool:
    """Return whether a rule does not end the mode, and tells of what is known to be faulty."""
    if event.kind not in (EventKind.RULE_HOLDS, EventKind.RULE_WARNS):
        return False
    told = {_OF_SENSORS[event.cause]} if event.cause in _OF_SENSORS else {*event.names}
    return bool(told) and told <= set(faulty)
