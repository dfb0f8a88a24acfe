"""What became of a driver that was given hostile bytes, and how long its calls took."""

from __future__ import annotations

from collections.abc import Callable
from time import thread_time
from typing import NamedTuple, TypeVar

R = TypeVar("R")
_SLOW = 0.1
"""s: ten ticks; the longest call of a sound driver takes less than half a millisecond."""
_MOST_SLOW = 2
"""So many calls may be slow: what the interpreter does beside them, such as collecting garbage, is in their time."""


class CallTimes:
    """How long calls take, in time of a processor: others on a busy machine do not lengthen it.

    Attributes:
        longest: the longest call, s.
    """

    def __init__(self) -> None:
        self.longest = 0.0
        self._slow = 0

    def of(self, call: Callable[[], R]) -> R:
        """Make a call, and return what it returns."""
        began = thread_time()
        found = call()
        took = thread_time() - began
        self.longest = max(self.longest, took)
        self._slow += took > _SLOW
        return found

    @property
    def broken(self) -> str:
        """Return how many calls were too slow; empty if no more than may be."""
        if self._slow <= _MOST_SLOW:
            return ""
        return f"{self._slow} calls took more than {1e3 * _SLOW:g} ms of a processor, up to {1e3 * self.longest:.0f} ms"


class Outcome(NamedTuple):
    """What became of one driver.

    Attributes:
        name: of its device.
        given: so many bytes.
        readings: of these, and how many were ok.
        ok: see readings.
        longest_ms: the longest call.
        broken: how a rule was broken; empty if none was.
    """

    name: str
    given: int
    readings: int
    ok: int
    longest_ms: float
    broken: str
