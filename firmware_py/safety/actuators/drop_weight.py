"""The drop weight, by what was commanded and what its hardpoint says: it is released when the hardpoint says so."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.health import WeightState
from firmware_py.records.sensing import Hardpoint, Heard
from firmware_py.safety.actuators.actuator_params import ActuatorParams

_SURE = 2.0
"""A hardpoint that says without a command that it holds nothing must say so for this long, s."""
_HANGS = 0.5
"""A load of more than this share of the drop weight hangs on, whatever the hardpoint says."""
_UNREPORTED, _HELD, _SILENT, _COMMANDED = (
    WeightState.UNREPORTED,
    WeightState.HELD,
    WeightState.SILENT,
    WeightState.COMMANDED,
)
_RELEASED, _STUCK, _NOT_CONFIRMED, _GONE = (
    WeightState.RELEASED,
    WeightState.STUCK,
    WeightState.NOT_CONFIRMED,
    WeightState.GONE,
)


class DropWeightMemory(NamedTuple):
    """What the watch remembers: the state; since when the release is commanded, and the hardpoint open, s; NaN: no."""

    state: WeightState = _UNREPORTED
    t_commanded: float = math.nan
    t_open: float = math.nan


class DropWeightWatch:
    """Follows one hardpoint; `weight` is what the vehicle file says of the drop weight, N, NaN if there is none."""

    def __init__(self, params: ActuatorParams, weight: float) -> None:
        self._there = weight == weight
        self._silence, self._time = params.weight_timeout, params.release_time
        self._hangs = _HANGS * weight
        self.memory = DropWeightMemory()

    @property
    def state(self) -> WeightState:
        """Return the state at the last update."""
        return self.memory.state

    def update(self, t: float, heard: Heard[Hardpoint], commanded: bool) -> WeightState:
        """Return the state at time t, s; `commanded` is whether the release was commanded in an earlier tick."""
        state, t_commanded, t_open = self.memory
        if not self._there or (state is _UNREPORTED and not heard.ok):
            return state  # there is none, or a relay holds it
        t_commanded = (t_commanded if t_commanded == t_commanded else t) if commanded else math.nan
        reports = heard.usable(t, self._silence)
        holds = heard.value.holds or heard.value.load > self._hangs
        if reports:
            t_open = math.nan if holds else t_open if t_open == t_open else heard.t_valid
        if commanded:
            state = self._after_command(state, t - t_commanded, reports, holds)
        elif reports:
            gone = state is _GONE or heard.t_valid - t_open >= _SURE
            state = _HELD if holds else _GONE if gone else state
        elif state is not _GONE and state is not _UNREPORTED:
            state = _SILENT
        self.memory = DropWeightMemory(state, t_commanded, t_open)
        return state

    def _after_command(self, state: WeightState, passed: float, reports: bool, holds: bool) -> WeightState:
        """Return the state `passed` s after the command."""
        if reports and not holds:
            return _GONE if state is _GONE else _RELEASED
        if state in (_UNREPORTED, _GONE, _RELEASED) and not reports:
            return state
        if passed <= self._time:
            return _COMMANDED
        return _STUCK if reports else _NOT_CONFIRMED
