"""What fins on drives do while the vehicle is disarmed."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.records.command import Applied
from firmware_py.wire.fin_positions import AtRest


class RestingFins:
    """The angle that each fin is to have.

    Attributes:
        exercised: whether fins follow although the vehicle is disarmed, as for a bench tool.
    """

    def __init__(self, at_rest: Sequence[AtRest]) -> None:
        self._at_rest, self.exercised = at_rest, False
        self._angles: list[float | None] = [None] * len(at_rest)
        """The last of each; none before it was commanded, or reported."""

    def hear(self, i: int, angle: float) -> None:
        """Take where the i-th fin is, rad: one that is to be held before any command is held there."""
        if self._angles[i] is None:
            self._angles[i] = angle

    def wanted(self, i: int, applied: Applied) -> float | None:
        """Return the angle that the i-th fin is to have, rad; None: its drive is to have no power."""
        rest = self._at_rest[i]
        # Also one that rests in the centre: the gate itself centres a disarmed vehicle's fins.
        if applied.armed or self.exercised or rest is AtRest.CENTRE:
            self._angles[i] = applied.fins[i]
        elif rest is AtRest.OFF:
            return None
        return self._angles[i]
