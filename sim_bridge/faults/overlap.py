"""Faults of one thing that overlap in time: what one has changed is put back before another one changes it."""

from __future__ import annotations

from collections.abc import Callable

from sim_bridge.faults.target import End


class Overlap:
    """The faults that replace one thing: the newest is in force alone; when it ends, the one before it is again."""

    def __init__(self) -> None:
        self._begun: list[Callable[[], End]] = []
        """What lets each fault begin that has not ended, in the order in which they began."""
        self._end: End | None = None
        """Ends the newest."""

    def add(self, begin: Callable[[], End]) -> End:
        """Let a fault begin in place of the one in force; return what ends it."""
        self._begun.append(begin)
        self._renew()
        return lambda: self._remove(begin)

    def _remove(self, begin: Callable[[], End]) -> None:
        in_force = self._begun[-1] is begin
        self._begun.remove(begin)
        if in_force:
            self._renew()

    def _renew(self) -> None:
        if self._end is not None:
            self._end()
        self._end = self._begun[-1]() if self._begun else None
