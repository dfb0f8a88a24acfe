"""The schedule that waits: ticks at absolute deadlines of the monotonic clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from firmware_py.schedule import Tick


class RealTime:
    """Tick k begins at start + k dt, whatever the ticks before it took; one that is late begins at once and says so.

    `advance(k)` is called just before tick k is released; it returns False to end the run. In SITL it is the plant's
    step, at sea a look at whether someone asked to stop.
    """

    def __init__(self, dt_ns: int, advance: Callable[[int], bool]) -> None:
        self._dt_ns = dt_ns
        self._advance = advance

    def __iter__(self) -> Iterator[Tick]:
        """Ticks until `advance` ends the run."""
        start = time.monotonic_ns()
        k = 0
        while True:
            deadline = start + k * self._dt_ns
            wait = deadline - time.monotonic_ns()
            if wait > 0:
                time.sleep(wait * 1e-9)
            if not self._advance(k):
                return
            late_ns = max(0, time.monotonic_ns() - deadline)
            yield Tick(k, self._dt_ns, late_ns)
            k += 1
