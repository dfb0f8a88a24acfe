"""Actuator watch: fins and propeller, by what they report and by what the vehicle does, against what was commanded."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ActuatorHealth, sound
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.feedback import PERIOD, FeedbackLimits, FeedbackMemory, FeedbackWatch
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle

__all__ = ["ActuatorParams", "ActuatorWatch", "ActuatorWatchMemory"]


class ActuatorWatchMemory(NamedTuple):
    """What the watch remembers."""

    feedback: tuple[FeedbackMemory, ...]
    """Of the fins, then of the propeller."""
    health: ActuatorHealth


class ActuatorWatch:
    """Names what is wrong with each fin and with the propeller."""

    def __init__(self, params: ActuatorParams, vehicle: Vehicle, n_rate: float) -> None:
        """`n_rate` is the rate limit of the propeller's commands, rev/s^2."""
        times = params.latency, params.timeout, params.time
        share, fins = params.rate_share, vehicle.fins
        limits = [
            FeedbackLimits(fin.rate_max, share * fin.rate_max, params.tolerance, fin.delta_max, *times) for fin in fins
        ]
        limits.append(FeedbackLimits(n_rate, share * n_rate, params.n_tolerance, math.inf, *times, turns=True))
        self._feedback = tuple([FeedbackWatch(limit) for limit in limits])
        self._health = sound(len(fins))

    def update(self, tick: Tick, frame: SensorFrame, applied: Applied, _state: StateEstimate) -> ActuatorHealth:
        """Return the health of fins and propeller at this tick; `applied` is what was commanded one tick ago."""
        turns = max(1, round(PERIOD / tick.dt))
        first, count = tick.k % turns, len(self._feedback)
        changed = False
        for i in range(first, count, turns):  # each in its own tick, so that all ticks cost the same
            heard, command = (frame.fins[i], applied.fins[i]) if i < count - 1 else (frame.n, applied.n)
            watch = self._feedback[i]
            before = watch.fault
            changed |= watch.update(tick.t, heard, command, applied.armed) is not before
        if changed:
            faults = [watch.fault for watch in self._feedback]
            self._health = ActuatorHealth(tuple(faults[:-1]), faults[-1])
        return self._health

    def freeze(self) -> ActuatorWatchMemory:
        """Return the whole memory."""
        return ActuatorWatchMemory(tuple([watch.freeze() for watch in self._feedback]), self._health)

    def thaw(self, memory: ActuatorWatchMemory) -> None:
        """Restore the memory that `freeze` returned."""
        for watch, remembered in zip(self._feedback, memory.feedback, strict=True):
            watch.thaw(remembered)
        self._health = memory.health
