"""Faults aboard the vehicle, which no plant can make: no station is heard, the clock jumps, the disk is full."""

from __future__ import annotations

import errno
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.recorder import LogError, LogWriter
from firmware_py.params import ParamError
from firmware_py.ports import Ground
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import NO_ORDER, Order
from firmware_py.tick import NS_PER_S, Tick
from sim_bridge.faults.fault import Fault
from sternplane.sitl.unlogged_flight import UnloggedFlight

Outage = tuple[float, float]
"""From when to when no station is heard, s."""


class AboardFaults:
    """The faults of a run that strike the vehicle's computer and its links.

    Attributes:
        unlogged: the witness of what comes after the disk is full; None if it never is.

    Args:
        faults: of the run; those of the plant are left to the plant.
        realtime: whether ticks keep the time of a clock.

    Raises:
        ParamError: the clock jumps where there is none.
    """

    def __init__(self, faults: Iterable[Fault], *, realtime: bool) -> None:
        aboard = [fault for fault in faults if fault.kind.aboard]
        self._outages = [(fault.t, fault.t + fault.duration) for fault in aboard if fault.target == "station"]
        self._jumps = sorted((fault.t, fault.value) for fault in aboard if fault.target == "clock")
        self._full_at = min((fault.t for fault in aboard if fault.target == "disk"), default=math.inf)
        fills = not math.isinf(self._full_at)
        self.unlogged = UnloggedFlight(self._full_at, "the disk was full") if fills else None
        self._full = False
        if self._jumps and not realtime:
            text = next(fault.text for fault in aboard if fault.target == "clock")
            raise ParamError(f"fault {text}: ticks are counted here, and no clock can jump; add --pace realtime")

    def heard(self, ground: Ground) -> Ground:
        """Return what of a ground the vehicle hears."""
        return _Outages(ground, self._outages) if self._outages else ground

    def log(self, path: Path, header: Mapping[str, Any]) -> LogWriter:
        """Return the log of the run, on its disk."""
        return LogWriter(path, header) if math.isinf(self._full_at) else _FillingLog(path, header, self._full_at)

    def close(self, log: LogWriter, end: Mapping[str, Any]) -> None:
        """Close the log of the run; beside one that is cut off, say how the flight went on.

        Raises:
            LogError: it cannot be written.
        """
        log.close(end)
        if self.unlogged is None or not self._full:
            return
        try:
            self.unlogged.leave(log.path, end)
        except OSError as error:
            raise LogError(f"{log.path.parent}: cannot be written ({error.strerror})") from None

    def recorded(self, keep: Callable[[Cycle], None]) -> Callable[[Cycle], None]:
        """Return what keeps a cycle, until the disk is full, and lets the clock jump between two ticks.

        A vehicle at sea flies on without a log (`run.flight_recorder`), and so it does here.
        """
        if math.isinf(self._full_at) and not self._jumps:
            return keep

        def kept(cycle: Cycle) -> None:
            while self._jumps and self._jumps[0][0] <= cycle.tick.t:
                time.sleep(self._jumps.pop(0)[1])  # who counts ticks finds the clock so much later at once
            if self._full:
                return
            try:
                keep(cycle)
            except LogError as error:
                if math.isinf(self._full_at):
                    raise
                self._full = True
                print(f"sternplane: {error}; the flight goes on without a log", file=sys.stderr)

        return kept


class _FillingLog(LogWriter):
    """A log on a disk that is full from a time on, s."""

    def __init__(self, path: Path, header: Mapping[str, Any], full_at: float) -> None:
        super().__init__(path, header)
        self._full_at = full_at

    def write(self, topic: str, t_ns: int, record: Any) -> None:
        """Write one record; raise LogError where the disk is full."""
        if t_ns >= self._full_at * NS_PER_S:
            raise self._failed(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
        super().write(topic, t_ns, record)


class _Outages:
    """A ground that is not heard now and then: what comes in an outage is lost.

    Outside of it the vehicle hears a station in every tick, and be it the scenario's operator, who has no heartbeat of
    its own: what was never heard cannot be lost.
    """

    def __init__(self, ground: Ground, outages: Iterable[Outage]) -> None:
        self._ground = ground
        self._outages = tuple(outages)
        self._last = NO_ORDER

    def read(self, tick: Tick) -> Order:
        order, last = self._ground.read(tick), self._last
        if any(begin <= tick.t < end for begin, end in self._outages):
            return replace(NO_ORDER, sticks=last.sticks, t_sticks=last.t_sticks, t_station=last.t_station)
        self._last = replace(order, t_station=max(order.t_station, tick.t))
        return self._last

    def write(self, cycle: Cycle) -> None:
        self._ground.write(cycle)
