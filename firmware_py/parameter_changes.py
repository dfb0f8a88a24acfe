"""What a change of parameters leads to: the parts that are made anew, and the events that tell of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from firmware_py.parameter_tree import value_text
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.order import Change, ParameterChange

_MADE_OF: dict[str, tuple[str, ...]] = {
    "origin": ("estimator",),
    "estimation": ("estimator", "supervisor"),
    "safety": ("actuator_watch", "supervisor", "guidance", "gate"),
    "guidance": ("guidance", "supervisor"),
    "control": ("control", "adoption"),
    "mavlink": (),
}
"""The parts that depend on each table of autopilot.toml."""
_TOLD = ("safety.", "estimation.integrity.")
"""Tables whose changes are told as events; all changes are in the log."""


def parts_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the parts that depend on dotted keys."""
    tables = dict.fromkeys(key.partition(".")[0] for key in values)
    return tuple(dict.fromkeys(part for table in tables for part in _MADE_OF[table]))


def told(change: Change, before: Any, after: Any) -> Iterator[Event]:
    """Yield an event for each parameter that safety rests on and that a change made another.

    Args:
        change: what was ordered.
        before: all of autopilot.toml before it, and
        after: behind it.
    """
    for key in dict(change.values) if isinstance(change, ParameterChange) else ():
        if key.startswith(_TOLD):
            texts = value_text(before, key), value_text(after, key)
            if texts[0] != texts[1]:
                yield event(EventKind.PARAMETER_CHANGED, names=(key, *texts))
