"""Actuator watch: what servos and propeller report, against what they were commanded."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ActuatorFault, ActuatorHealth
from firmware_py.records.sensing import Heard, SensorFrame
from firmware_py.tick import Tick

_TIMEOUT = 1.0
"""An actuator that was heard before and is silent for longer than this, s, is named."""


class ActuatorWatchMemory(NamedTuple):
    """What the watch remembers."""


class ActuatorWatch:
    """Names what is wrong with each fin and with the propeller."""

    def __init__(self) -> None:
        self._memory = ActuatorWatchMemory()

    def update(self, tick: Tick, frame: SensorFrame, _applied: Applied, _state: StateEstimate) -> ActuatorHealth:
        """Return the health of fins and propeller at this tick; `applied` is what was commanded one tick ago."""
        t = tick.t
        return ActuatorHealth(tuple([_silence(fin, t) for fin in frame.fins]), _silence(frame.n, t))

    def freeze(self) -> ActuatorWatchMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: ActuatorWatchMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory


def _silence(heard: Heard[float], t: float) -> ActuatorFault:
    return ActuatorFault.SILENT if _TIMEOUT < t - heard.t_valid < math.inf else ActuatorFault.NONE
