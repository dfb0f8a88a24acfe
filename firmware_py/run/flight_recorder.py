"""The recorder of a flight at sea; it also prints events."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from typing import Any

from firmware_py.adapters.loss_watch import LossWatch
from firmware_py.adapters.storage.parted_log import PartedLog
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.records.cycle import Cycle
from firmware_py.records.event_text import texts
from firmware_py.run.sensor_watch import SensorWatch
from firmware_py.run.terminal import say
from firmware_py.tick import NS_PER_S

_STATUS_NS = 10 * NS_PER_S
"""Interval of the status lines."""
_AGAIN_NS = 60 * NS_PER_S
"""How often a log that cannot be written is tried again."""


class FlightRecorder:
    """A recorder that never ends a flight: a log that cannot be written is told, and tried again every minute.

    Attributes:
        cycles: how many were logged.
        last: the newest of all.
        broken: why the log cannot be written now; else empty.
    """

    def __init__(
        self,
        log: PartedLog,
        watch: Callable[[Cycle], None] = lambda _cycle: None,
        losses: LossWatch | None = None,
        tell: Callable[[str], None] | None = None,
    ) -> None:
        """`watch` is shown every cycle once it is written, `losses` what no log tells; `tell` takes what went wrong."""
        self._log, self._watch, self._losses = log, watch, losses
        self._tell = tell or (lambda sentence: say(f"sternplane: {sentence}"))
        self._sensors = SensorWatch()
        self._again_ns = 0
        self.cycles = 0
        self.last: Cycle | None = None
        self.broken = ""

    def begin(self) -> None:
        """Begin the log, or say why not and go on without."""
        try:
            self._log.begin()
        except LogError as error:
            self._break(error, 0)

    def write(self, cycle: Cycle) -> None:
        """Write one cycle while that is possible, and print its events."""
        self._write(cycle)
        self._watch(cycle)

    def close(self, end: Mapping[str, Any]) -> bool:
        """Write how the flight ended; return False, and say so, if that cannot be written."""
        try:
            if not self.broken:
                self._log.close(end)
                return True
        except LogError as error:
            self.broken = str(error)
            say(f"sternplane: {error}")
        if self.last is not None:
            t, reason = self.last.tick.t, end["reason"]
            say(f"sternplane: {self._log.path} is not complete; the flight went on without it to {t:.1f} s: {reason}")
        return False

    def _write(self, cycle: Cycle) -> None:
        for line in (*texts(cycle.events), *self._sensors.changes(cycle)):
            say(f"{cycle.tick.t:9.2f} s  {line}")
        if cycle.tick.k * cycle.tick.dt_ns % _STATUS_NS == 0:
            state, mode = cycle.state, cycle.mode.mode.name.lower()
            depth = f"{state.eta.z:z.2f}" if state.depth_ok else "?"
            heading = round(math.degrees(state.eta.psi)) % 360 if state.attitude_ok else "?"
            say(f"{cycle.tick.t:9.2f} s  {mode}, depth {depth} m, heading {heading}°, {state.nu.u:z.2f} m/s")
        self.last = cycle
        if self.broken:
            self._without(cycle)
            return
        try:
            self._log.write(cycle)
            self.cycles += 1
        except LogError as error:
            self._break(error, cycle.tick.t_ns)

    def _without(self, cycle: Cycle) -> None:
        if self._losses is not None:
            self._losses.update(cycle)
        if cycle.tick.t_ns < self._again_ns:
            return
        self._again_ns = cycle.tick.t_ns + _AGAIN_NS
        with contextlib.suppress(LogError):
            self._log.begin_next(cycle)
            self.broken = ""
            self._tell(f"the log goes on in {self._log.path}")

    def _break(self, error: LogError, t_ns: int) -> None:
        self.broken, self._again_ns = str(error), t_ns + _AGAIN_NS
        self._tell(f"{error}; the flight goes on without a log")
