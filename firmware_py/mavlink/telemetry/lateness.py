"""Lateness of the cycles, as a histogram of octaves that a station can plot."""

from __future__ import annotations

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.scaling import boot_us
from firmware_py.records.cycle import Cycle

OCTAVES = 16
_FIELDS = 58


class Lateness:
    """Counts every cycle since the start: the first of the octaves is below 16 us, the last from 262 ms."""

    def __init__(self) -> None:
        self.counts = [0] * OCTAVES

    def update(self, cycle: Cycle) -> None:
        """Count one cycle."""
        octave = (cycle.tick.late_ns // 16_000).bit_length()
        self.counts[octave if octave < OCTAVES else OCTAVES - 1] += 1

    def message(self, cycle: Cycle) -> Message:
        """Return DEBUG_FLOAT_ARRAY "late_us": entry i counts the cycles that were late by 2^(i+3) us to twice that."""
        data = [float(count) for count in self.counts] + [0.0] * (_FIELDS - OCTAVES)
        return dialect.MAVLink_debug_float_array_message(boot_us(cycle.tick), b"late_us", 1, data)
