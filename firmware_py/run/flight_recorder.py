"""The recorder of a flight at sea; it also prints events."""

from __future__ import annotations

import contextlib
import math
import sys
from collections.abc import Callable

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage.recorder import LogError, LogRecorder, LogWriter
from firmware_py.records.cycle import Cycle
from firmware_py.records.event_text import texts
from firmware_py.run.sensor_watch import SensorWatch
from firmware_py.tick import NS_PER_S

_STATUS_NS = 10 * NS_PER_S
"""Interval of the status lines."""


class FlightRecorder:
    """A recorder that never ends a flight: a log that cannot be written is reported once, and the flight goes on."""

    def __init__(
        self,
        log: LogWriter,
        watch: Callable[[Cycle], None] = lambda _cycle: None,
        losses: LossWatch | None = None,
    ) -> None:
        """`watch` is shown every cycle once it is written; `losses` counts what is lost."""
        self._watch = watch
        self._losses = losses
        self._recorder = LogRecorder(log, losses)
        self._sensors = SensorWatch()
        self.cycles = 0
        self.last: Cycle | None = None
        self.broken = False

    def write(self, cycle: Cycle) -> None:
        """Write one cycle while that is possible, and print its events."""
        self._write(cycle)
        self._watch(cycle)

    def _write(self, cycle: Cycle) -> None:
        for line in (*texts(cycle.events), *self._sensors.changes(cycle)):
            say(f"{cycle.tick.t:9.2f} s  {line}")
        if cycle.tick.k * cycle.tick.dt_ns % _STATUS_NS == 0:
            eta, mode = cycle.state.eta, cycle.mode.mode.name.lower()
            heading = round(math.degrees(eta.psi)) % 360
            say(f"{cycle.tick.t:9.2f} s  {mode}, depth {eta.z:.2f} m, heading {heading}°, {cycle.state.nu.u:.2f} m/s")
        self.last = cycle
        if self.broken:
            if self._losses is not None:
                self._losses.update(cycle)
            return
        try:
            self._recorder.write(cycle)
            self.cycles += 1
        except LogError as error:
            self.broken = True
            say(f"sternplane: {error}; the flight goes on without a log")


def say(line: str) -> None:
    """Print a line on stderr; a closed terminal does not end a flight."""
    with contextlib.suppress(OSError, ValueError):
        print(line, file=sys.stderr, flush=True)
