"""What the vehicle stops hearing, and hears again, in words: nobody reads a flag in a log while the boat is out."""

from __future__ import annotations

from firmware_py.records.cycle import Cycle

_FIRST_S = 5.0
"""How long a vehicle may take to hear everything at first, s."""


class SensorWatch:
    """Watches what the state rests on: attitude, depth, velocity."""

    def __init__(self) -> None:
        self._heard = (False, False, False)
        self._told_first = False

    def changes(self, cycle: Cycle) -> list[str]:
        """Sentences on what has changed with this cycle; mostly none."""
        state = cycle.state
        now = (state.attitude_ok, state.depth_ok, state.velocity_ok)
        if now == self._heard and (self._told_first or cycle.tick.t < _FIRST_S):
            return []
        names, said = ("attitude", "depth", "velocity"), []
        if not self._told_first and cycle.tick.t >= _FIRST_S:
            self._told_first = True
            deaf = [name for name, ok in zip(names, now, strict=True) if not ok]
            if deaf:
                said.append(f"not heard for {_FIRST_S:g} s: {', '.join(deaf)}")
        for name, ok, before in zip(names, now, self._heard, strict=True):
            if before and not ok:
                said.append(f"{name} is no longer heard")
            elif ok and not before and self._told_first:
                said.append(f"{name} is heard again")
        self._heard = now
        return said
