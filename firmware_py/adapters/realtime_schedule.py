"""The real-time schedule: ticks at absolute deadlines of the monotonic clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from firmware_py.tick import Tick


class RealTimeSchedule:
    """Tick k begins at start + k dt, whatever the ticks before it took; a late one begins at once and says how late.

    `advance(k)` is called just before tick k is released; it returns False to end the run. In SITL it steps the plant,
    at sea it checks whether the operator asked to stop.

    Attributes:
        slips: how many ticks of this run began more than one step late, counted as the supervisor does.
    """

    def __init__(self, dt_ns: int, advance: Callable[[int], bool], spin_ns: int = 0) -> None:
        """Take the step, ns, what is called before each tick, and the time before a deadline to poll the clock, ns.

        A sleep ends tens of microseconds late; polling the clock instead is punctual, and keeps a processor busy.
        """
        self._dt_ns = dt_ns
        self._advance = advance
        self._spin_ns = spin_ns
        self.slips = 0

    def __iter__(self) -> Iterator[Tick]:
        """Yield ticks until `advance` ends the run."""
        start = time.monotonic_ns()
        self.slips = k = 0
        while True:
            deadline = start + k * self._dt_ns
            wait = deadline - self._spin_ns - time.monotonic_ns()
            if wait > 0:
                time.sleep(wait * 1e-9)
            while time.monotonic_ns() < deadline:
                pass
            if not self._advance(k):
                return
            late_ns = max(0, time.monotonic_ns() - deadline)
            self.slips += late_ns > self._dt_ns
            yield Tick(k, self._dt_ns, late_ns)
            k += 1
