"""What was said and done without cause: something sound was called faulty, or a rule ended a mission for nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware_py.records.event import INTENDED_CAUSES, Cause
from firmware_py.records.health import SourceFault
from sternplane.study.safety.struck import struck
from sternplane.study.safety.trial import Trial

_SPEAKERS = (SourceFault.TWO_SENDERS.name, SourceFault.OTHER_DEVICE.name)
"""Faults that say that somebody else speaks, and are wrong where nobody does, whatever else is struck."""
_UNDECIDED = SourceFault.UNDECIDED.name
_TOGETHER = 0.1
"""Two sensors that contradict each other are said to within this, s, unless one of them is known to already."""


def accused(trial: Trial, onset: int, found: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return the (name, fault) of what was called faulty and is not, each once.

    Of two sensors of which nothing tells which is wrong both are said, as UNDECIDED: that is right if one is struck.
    """
    faults = trial.at(onset)
    ours, duplicated = struck(faults), any(text.startswith("duplicate:") for text in faults)

    def fair(t: float, name: str, kind: str) -> bool:
        if kind in _SPEAKERS:
            return duplicated and name in ours
        if name in ours or any(one.covers(name, kind) for one in trial.allowed):
            return True
        last = {other: word for at, other, word in found["said"] if at <= t and other in ours}
        beside = [word for at, other, word in found["said"] if abs(at - t) <= _TOGETHER and other in ours]
        return kind == _UNDECIDED and _UNDECIDED in (*last.values(), *beside)

    return tuple(dict.fromkeys((name, kind) for t, name, kind in found["said"] if not fair(t, name, kind)))


def needless_end(trial: Trial, found: Mapping[str, Any]) -> str:
    """Return the cause of the rule that ended the mission though none had reason to; "" if none did."""
    if trial.ends:
        return ""
    for _, _, cause in found["modes"]:
        if Cause[cause] is Cause.MISSION_DONE:
            break
        if Cause[cause] not in (*INTENDED_CAUSES, Cause.NONE):
            return str(cause)
    return ""
