"""What the rules of the supervisor and the monitor of the bus found in a flight, from its events."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind
from firmware_py.records.event_text import texts
from firmware_py.safety.rules import RULES

_OF_SENSORS: Mapping[Cause, str] = {
    Cause.AHRS_SUSPECT: "ahrs",
    Cause.HEADING_SUSPECT: "ahrs",
    Cause.PRESSURE_SUSPECT: "pressure",
    Cause.DVL_BAD: "dvl",
    Cause.ALTIMETER_BAD: "altimeter",
}
_KEYS: Mapping[Cause, list[str]] = {
    cause: [rule.answer for rule in RULES if rule.cause is cause and isinstance(rule.answer, str) and rule.answer]
    for cause in {rule.cause for rule in RULES}
}
"""The keys of [autopilot.safety] that say what is done for each cause."""
_NODES = (EventKind.NODE_FAULT, EventKind.NODE_RESTARTED)
_LABELS = {"rule": "by the rules", "bus": "on the bus"}
Finding = dict[str, Any]


def findings(events: Iterable[tuple[float, tuple[Event, ...]]], faulty: Collection[str]) -> list[Finding]:
    """Return each thing once: by whom ("rule", "bus"), as what, first when, s, and how many times it was told.

    `key` is that of [autopilot.safety] which says what is done, "" where there is none, or not one alone.

    Args:
        events: of a flight, with their times, s.
        faulty: sensors and actuators that are known to have been at fault: a rule that only warns of them adds nothing.
    """
    found: dict[tuple[Any, ...], Finding] = {}
    for t, happened in events:
        for event in happened:
            by = _by(event, faulty)
            if not by:
                continue
            one = found.setdefault(
                (event.kind, event.cause, event.names, event.after, *(event.numbers if by == "bus" else ())),
                {"by": by, "text": texts((event,))[0], "key": _key(event), "first_s": t, "times": 0},
            )
            one["times"] += 1
    return list(found.values())


def key_figures(found: Iterable[Finding]) -> list[tuple[str, str]]:
    """Return (label, text) of them for people, a line for each of those who found them."""
    told: dict[str, list[str]] = {}
    for one in found:
        times = f", {one['times']} times" if one["times"] > 1 else ""
        key = f" ({one['key']})" if one["key"] else ""
        told.setdefault(_LABELS[one["by"]], []).append(f"{one['text']}{key}, at {one['first_s']:.1f} s{times}")
    return [(label, "; ".join(those)) for label, those in told.items()]


def _key(event: Event) -> str:
    keys = _KEYS.get(event.cause, [])
    return keys[0] if len(keys) == 1 and event.kind not in _NODES else ""


def _by(event: Event, faulty: Collection[str]) -> str:
    """Return who found what an event tells; "" if it tells of nothing found."""
    if event.kind in _NODES:
        return "bus"
    if event.kind is EventKind.MODE_CHANGED:
        return "" if event.cause in INTENDED_CAUSES or event.cause is Cause.NONE else "rule"
    if event.kind not in (EventKind.RULE_HOLDS, EventKind.RULE_WARNS):
        return ""
    told = {_OF_SENSORS[event.cause]} if event.cause in _OF_SENSORS else {*event.names}
    return "" if told and told <= set(faulty) else "rule"
