"""Battery and leak sensor, which come once a second: a value that jumps is used when the next one confirms it."""

from __future__ import annotations

import math

from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.records.sensing import Battery, Heard

_BATTERY_JUMP, _LEAK_JUMP = 0.05, 0.1
"""What charge and humidity do not change by in a second, share."""


def hear_battery(heard: Heard[Battery], t: float, watch: SourceWatch) -> None:
    """Take a report of the battery, if it is confirmed. One without a charge, where there was one, is no report."""
    held = watch.memory.held.value
    before = math.nan if held is None else held.remaining
    if math.isnan(heard.value.remaining) and not math.isnan(before):
        heard = Heard(heard.value, heard.t_valid, heard.fresh, ok=False)
    if watch.hear(heard, t) and _confirmed(heard.value.remaining, before, _BATTERY_JUMP, watch, t):
        watch.take(heard)


def hear_leak(heard: Heard[float], t: float, watch: SourceWatch) -> None:
    """Take a humidity, if it is confirmed."""
    if watch.hear(heard, t):
        held = watch.memory.held.value
        if _confirmed(heard.value, math.nan if held is None else held, _LEAK_JUMP, watch, t):
            watch.take(heard)


def _confirmed(value: float, before: float, most: float, watch: SourceWatch, t: float) -> bool:
    """Return whether a value is within `most` of the last one that was used, or not the first beyond that."""
    if abs(value - before) <= most or before != before:
        return True
    return watch.refuse(t) > 1
