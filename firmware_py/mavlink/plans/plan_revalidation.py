"""Revalidation of the stored mission after the fence or a limit has changed: a few steps in each tick."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from firmware_py.mavlink.plans.items import ItemRefused, Limits
from firmware_py.mavlink.plans.path_check import PathCheck
from firmware_py.records.mission import MissionItem

_STEPS_PER_TICK = 4


class PlanRevalidation:
    """`wrong` is the first item that should not be flown, and why; None if there is none, or as long as it looks."""

    def __init__(self) -> None:
        self.problem: tuple[int, str] | None = None
        self._left: Iterator[tuple[int, str] | None] = iter(())
        self.running = False

    def start(self, steps: Sequence[MissionItem], at: Sequence[int], limits: Limits) -> None:
        """Check all steps from the first on; `at` has the item number of each."""
        self.problem, self.running = None, True
        self._left = _checks(tuple(steps), tuple(at), limits)

    def cancel(self) -> None:
        """Stop: a new mission was checked as it arrived."""
        self.problem, self.running = None, False

    def advance(self) -> bool:
        """Check the next few steps; return True if one must not be flown."""
        for _ in range(_STEPS_PER_TICK):
            if not self.running:
                return False
            try:
                self.problem = next(self._left)
            except StopIteration:
                self.running = False
            if self.problem is not None:
                self.running = False
                return True
        return False


def _checks(steps: Sequence[MissionItem], at: Sequence[int], limits: Limits) -> Iterator[tuple[int, str] | None]:
    path_check = PathCheck(limits)
    for i, step in enumerate(steps):  # the jumps of a whole mission name steps
        try:
            path_check.check(i, step)
        except ItemRefused as refused:
            yield at[i], str(refused)
        yield None
