"""An estimator of one's own, beside the built-in one."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from firmware_py.estimation.estimator import EstimationParams, Estimator, EstimatorMemory
from firmware_py.estimation.state_estimator import StateEstimator
from firmware_py.marine import Eta, Nu, Origin
from firmware_py.own_part import Guard, GuardMemory, OwnClass
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied
from firmware_py.records.estimate import Learned, StateEstimate
from firmware_py.records.event import Event
from firmware_py.records.health import NO_DOUBTS, AxisDoubt
from firmware_py.records.order import Mode
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle

_NUMBERS = ("position_std", "depth_std", "velocity_std", "altitude", "water_std")
_LISTS = ("value", "std", "valid", "excited", "current", "current_std", "nis")


class OwnEstimatorMemory(NamedTuple):
    """What both remember."""

    built_in: EstimatorMemory
    own: GuardMemory
    armed: bool


class OwnEstimator:
    """An `autopilot.StateEstimator`: the built-in estimator, and one's own beside it."""

    def __init__(self, built_in: Estimator, own: OwnClass[StateEstimator], vehicle: Vehicle) -> None:
        self._built_in = built_in
        self._guard = Guard("estimator", own, vehicle)
        self._answer: StateEstimate | None = None
        self._armed = False
        self.keep, self.resume = built_in.keep, built_in.resume
        self.learned_model, self.restore = built_in.learned_model, built_in.restore

    @property
    def heard(self) -> SensorFrame:
        """See `autopilot.StateEstimator`."""
        return self._built_in.heard

    @property
    def believed(self) -> SensorFrame:
        """See `autopilot.StateEstimator`."""
        return self._built_in.believed

    @property
    def placed(self) -> SensorFrame:
        """See `autopilot.StateEstimator`."""
        return self._built_in.placed

    @property
    def held(self) -> tuple[bool, ...]:
        """See `autopilot.StateEstimator`."""
        return self._built_in.held

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        doubts: Sequence[AxisDoubt] = NO_DOUBTS,
        adopted: Adopted | None = None,
    ) -> StateEstimate:
        """Return the state by the built-in estimator, with what one's own has learned."""
        state = self._built_in.update(tick, frame, applied, doubts, adopted)
        seen = replace(self._built_in.believed, payload=frame.payload)
        self._answer = self._guard.ask(tick.k, lambda own: _merged(state, own.update(tick, seen, applied, state)))
        return state if self._answer is None else replace(state, learned=self._answer.learned)

    def flown_by(self, mode: Mode, state: StateEstimate) -> StateEstimate:
        """Return the state that guidance and laws fly by: one's own, but in SURFACE, which is no experiment."""
        armed = mode is not Mode.DISARMED
        if self._armed and not armed:
            self._guard.rest()
        self._armed = armed
        return state if self._answer is None or mode is Mode.SURFACE else self._answer

    def told(self) -> tuple[Event, ...]:
        """Return what happened since the last call: that one's own estimator has failed."""
        return self._guard.told()

    def with_params(self, params: EstimationParams, origin: Origin) -> OwnEstimator:
        """Return an estimator that goes on from here with other parameters; see `Estimator.with_params`."""
        other = copy.copy(self)
        other._built_in = built_in = self._built_in.with_params(params, origin)
        other.keep, other.resume = built_in.keep, built_in.resume
        other.learned_model, other.restore = built_in.learned_model, built_in.restore
        return other

    def freeze(self) -> OwnEstimatorMemory:
        """Return the whole memory."""
        return OwnEstimatorMemory(self._built_in.freeze(), self._guard.freeze(), self._armed)

    def thaw(self, memory: OwnEstimatorMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._built_in.thaw(memory.built_in)
        self._guard.thaw(memory.own)
        self._armed = memory.armed


def _merged(state: StateEstimate, answer: StateEstimate) -> StateEstimate:
    """Return the built-in estimate with what one's own may answer for.

    Raises:
        ValueError: it is not finite where the built-in one is, or in a part of the water, or of another length.
    """
    eta, nu = Eta(*map(float, answer.eta)), Nu(*map(float, answer.nu))
    for own, built_in in ((eta, state.eta), (nu, state.nu)):
        for name, one, other in zip(own._fields, own, built_in, strict=True):
            if math.isfinite(other) and not math.isfinite(one):
                raise ValueError(f"{name} is {one}")
    north, east = map(float, answer.water)
    if not (math.isfinite(north + east) or (math.isnan(north) and math.isnan(east))):
        raise ValueError(f"water is ({north}, {east})")
    numbers: dict[str, Any] = {name: float(getattr(answer, name)) for name in _NUMBERS}
    learned = state.learned if answer.learned is state.learned else _learned(state.learned, answer.learned)
    return replace(state, eta=eta, nu=nu, water=(north, east), learned=learned, **numbers)


def _learned(built_in: Learned, own: Learned) -> Learned:
    lists: dict[str, Any] = {}
    for name in _LISTS:
        kind = bool if name in ("valid", "excited") else float
        lists[name] = tuple(kind(one) for one in getattr(own, name))
        if len(lists[name]) != len(getattr(built_in, name)):
            raise ValueError(f"learned.{name} has {len(lists[name])} entries, not {len(getattr(built_in, name))}")
    return replace(built_in, **lists)
