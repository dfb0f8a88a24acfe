"""Messages for the terminal when attitude, depth or velocity is lost, and when it is back."""

from __future__ import annotations

from firmware_py.records.cycle import Cycle
from firmware_py.records.health import SourceState
from firmware_py.records.health_text import sensor_text
from firmware_py.records.sensing import ROLES

_FIRST_S = 5.0
"""Time after the start within which everything should have been heard, s; a device of several too."""


class SensorWatch:
    """Watches attitude, depth and velocity, on which the state depends."""

    def __init__(self) -> None:
        self._heard = (False, False, False)
        self._reported_first = False

    def changes(self, cycle: Cycle) -> list[str]:
        """Return a sentence for each change in this cycle; mostly none."""
        state = cycle.state
        now = (state.attitude_ok, state.depth_ok, state.velocity_ok)
        if now == self._heard and (self._reported_first or cycle.tick.t < _FIRST_S):
            return []
        names, sentences = ("attitude", "depth", "velocity"), []
        if not self._reported_first and cycle.tick.t >= _FIRST_S:
            self._reported_first = True
            missing = [name for name, ok in zip(names, now, strict=True) if not ok]
            lost = [one for one in state.candidates if one.health.state is SourceState.LOST]
            missing += [sensor_text(f"{ROLES[one.role]}.{one.number + 1}") for one in lost]
            if missing:
                sentences.append(f"not known for {_FIRST_S:g} s: {', '.join(missing)}")
        for name, ok, before in zip(names, now, self._heard, strict=True):
            if before and not ok:
                sentences.append(f"{name} is no longer known")
            elif ok and not before and self._reported_first:
                sentences.append(f"{name} is known again")
        self._heard = now
        return sentences
