"""The estimator that flies: sensor integrity, navigation, and the coefficient estimator of vehicle and water."""

from __future__ import annotations

import copy
import enum
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from firmware_py.estimation.coefficient_estimator import CoefficientEstimator, CoefficientEstimatorMemory
from firmware_py.estimation.coefficient_params import CoefficientParams, relative_std
from firmware_py.estimation.coefficient_validity import ValidityParams
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.integrity_records import NO_CORRECTION
from firmware_py.estimation.integrity.selection import Selection, SelectionMemory
from firmware_py.estimation.integrity.selection_params import SelectionParams
from firmware_py.estimation.learning_params import LearningParams
from firmware_py.estimation.lever_arms import LeverArms, LeverArmsMemory
from firmware_py.estimation.navigation.navigation import KeptNavigation, Navigation, NavigationMemory, NavigationParams
from firmware_py.marine import Origin
from firmware_py.params import TakesEffect, named_values, param, table
from firmware_py.part_name import PartName
from firmware_py.records.adoption import Adopted, Refusal, Source
from firmware_py.records.command import Applied
from firmware_py.records.estimate import NOTHING_LEARNED, Learned, StateEstimate
from firmware_py.records.event import Event
from firmware_py.records.health import NO_DOUBTS, AxisDoubt, SourceFault
from firmware_py.records.order import Mode
from firmware_py.records.passport import LearnedModel, Restored
from firmware_py.records.sensing import SensorFrame, silence
from firmware_py.tick import Rate, Tick
from firmware_py.vehicle.linear_models import SteeringCoefficients, steering_coefficients
from firmware_py.vehicle.vehicle import Vehicle


class EstimatorKind(enum.Enum):
    """The estimator that guidance and laws fly by."""

    BUILT_IN = enum.auto()


@dataclass(frozen=True)
class EstimationParams(NavigationParams):
    """Navigation's tables, those of sensor integrity and of the choice between devices, and those of learning."""

    integrity: IntegrityParams = table(IntegrityParams, mav="INT_")
    selection: SelectionParams = table(SelectionParams, mav="SEL_")
    learning: LearningParams = table(LearningParams, mav="LRN_")
    coefficients: CoefficientParams = table(CoefficientParams, mav="COF_")
    health: ValidityParams = table(ValidityParams, mav="HLT_")
    estimator: EstimatorKind | PartName = param(
        EstimatorKind.BUILT_IN,
        doc="Estimate that guidance and laws fly by. The built-in one runs too: the supervisor goes by it.",
        when=TakesEffect.RESTART,
    )
    own: Mapping[str, Any] = named_values("Parameters of an estimator of one's own.")


def same_filter(one: EstimationParams, other: EstimationParams) -> bool:
    """Return whether both have the same coefficient filter, or none."""
    return (one.learning.enabled, one.coefficients) == (other.learning.enabled, other.coefficients)


def refuse_no_filter(params: EstimationParams, vehicle: Vehicle) -> None:
    """Raise the ParamError that making an `Estimator` would; costs half of it."""
    if params.learning.enabled:
        BankArrays(vehicle, params.coefficients)


class EstimatorMemory(NamedTuple):
    """Everything that is remembered."""

    arms: LeverArmsMemory
    selection: SelectionMemory
    navigation: NavigationMemory
    learning: CoefficientEstimatorMemory | None


class Estimator:
    """An `autopilot.StateEstimator`. Steering rests on navigation; the coefficient estimator runs a lag behind.

    `heard` is the last frame with the devices in front that are believed; `placed` the same as sensors at the body's
    origin would have measured it; `believed` that without what sensor integrity does not believe.
    """

    heard: SensorFrame
    placed: SensorFrame
    believed: SensorFrame

    def __init__(self, params: EstimationParams, origin: Origin, vehicle: Vehicle) -> None:
        """Make them.

        Raises:
            ParamError: a list of coefficients that the vehicle does not have, or that gives no scale.
        """
        self._params, self._vehicle = params, vehicle
        self._arms, self._crossed = LeverArms(vehicle, params.attitude.timeout), vehicle.fins_crossed
        self._selection = Selection(params.selection, params.integrity, params, vehicle)
        self._navigation = Navigation(params, origin)
        self.heard = self.placed = self.believed = silence(len(vehicle.fins))
        self._learning = (
            CoefficientEstimator(params.learning, params.coefficients, params.health, vehicle)
            if params.learning.enabled
            else None
        )
        if params.learning.enabled:
            file, known = steering_coefficients(vehicle), params.coefficients
            shares = [relative_std(name, known) if name in known.names else 0.0 for name in file._fields]
            self._selection.doubt([share * abs(x) for share, x in zip(shares, file, strict=True)])

    def with_params(self, params: EstimationParams, origin: Origin) -> Estimator:
        """Return an estimator that goes on from here with other parameters; use only one of the two, for they share.

        A new filter costs as much as three cycles, so it is made for other coefficients alone.

        Raises:
            ParamError: as when it is made; this one is as it was.
        """
        before, learning = self._params, self._learning
        if learning is None or not same_filter(params, before):
            other = Estimator(params, origin, self._vehicle)
            other.thaw(self.freeze())
            return other
        other = copy.copy(self)
        other._params = params
        other._arms = LeverArms(self._vehicle, params.attitude.timeout)
        other._arms.thaw(self._arms.freeze())
        other._navigation = Navigation(params, origin)
        other._navigation.thaw(self._navigation.freeze())
        other._selection = Selection(params.selection, params.integrity, params, self._vehicle)
        other._selection.thaw(self._selection.freeze())
        if (params.learning, params.health) != (before.learning, before.health):
            other._learning = learning.with_params(params.learning, params.health, self._vehicle)
        return other

    @property
    def held(self) -> tuple[bool, ...]:
        """Return whether what planes and rudders do is held, since nobody knows where one of them is."""
        return self._learning.held if self._learning is not None else (False, False)

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        doubts: Sequence[AxisDoubt] = NO_DOUBTS,
        adopted: Adopted | None = None,
    ) -> StateEstimate:
        """Return the state at the tick, from what was received up to it and what was commanded one tick ago.

        `doubts` is what the motion said of planes and rudders then, `adopted` the coefficients in force, by which
        sensors are judged; None: those of vehicle.toml.
        """
        known = self._learning.velocity if self._learning is not None else None
        if self._learning is not None and adopted is not None and tick.every(Rate.HZ_1):
            self._follow(self._learning.last, adopted)
        selection, heard = self._selection, frame
        self.heard = selection.in_front(heard)
        frame = self._arms.at_origin(heard)
        self.placed = selection.in_front(frame)
        air = self._arms.in_air(heard, frame, tick.t)
        port = selection.in_front(air).pressure.value - self.placed.pressure.value
        if self._crossed and any(doubt.weak for doubt in doubts):  # planes turn it too, and no model says how much
            fins = tuple([replace(fin, ok=False) for fin in frame.fins])
            judged = selection.update(tick, replace(frame, fins=fins), applied, known, air)
            believed = self.believed = replace(judged, fins=frame.fins)
        else:
            believed = self.believed = selection.update(tick, frame, applied, known, air)
        self._arms.hear(believed.ahrs, tick.t)
        correction, integrity = selection.correction, selection.integrity
        if correction is not NO_CORRECTION:
            self._navigation.correct(*correction)
        before = self._learning.last if self._learning is not None else NOTHING_LEARNED
        judged_by = integrity.health, known, integrity.hull, before, integrity.refused, integrity.doubt
        state = self._navigation.update(tick, believed, applied, *judged_by, port)
        if (off := self._arms.depth_std(tick.t)) > 0.0:
            state = replace(state, depth_std=math.hypot(state.depth_std, off))
        if selection.candidates:
            state = replace(state, candidates=selection.candidates)
        if self._learning is not None:
            learned = self._learning.update(tick, believed, applied, state, doubts)
            state = state if learned is before else replace(state, learned=learned)
        return self._doubted(state)

    def _doubted(self, state: StateEstimate) -> StateEstimate:
        """Return the state with a depth as unsure as it and a pressure go apart, of which one is wrong.

        Who learns is not told: it would wait, and its velocity is the better witness.
        """
        pressure, undecided = self.placed.pressure, state.sensors.pressure.fault is SourceFault.UNDECIDED
        if not (undecided and pressure.ok and math.isfinite(pressure.value)):
            return state
        off = state.eta.z - self._navigation.depth_by(pressure.value)
        return replace(state, depth_std=math.hypot(state.depth_std, off))

    def _follow(self, learned: Learned, adopted: Adopted) -> None:
        """Let integrity judge headings by the coefficients in force, as well as they are known, once all are certain.

        Until then, and while adoption refuses what is learned, nothing changes: a heading that lies would teach the
        vehicle by which it is to be judged.
        """
        law = adopted.heading
        if law.source not in (Source.PASSPORT, Source.LEARNED) or law.refusal not in (Refusal.NONE, Refusal.BOUND):
            return
        steering = SteeringCoefficients(*adopted.steering)
        known = dict(zip(self._params.coefficients.names, zip(learned.value, learned.std, strict=True), strict=True))
        pairs = [(now, *known.get(name, (now, 0.0))) for name, now in steering._asdict().items()]
        self._selection.follow(steering, [math.hypot(sigma, now - value) for now, value, sigma in pairs])

    def flown_by(self, _mode: Mode, state: StateEstimate) -> StateEstimate:
        """Return the state that guidance and laws fly by, of the one that the supervisor goes by: the same."""
        return state

    def told(self) -> tuple[Event, ...]:
        """Return what happened since the last call; what it says of sensors, the supervisor tells."""
        return ()

    def keep(self) -> KeptNavigation:
        """Return what a later run may start from."""
        return self._navigation.keep()

    def resume(self, kept: KeptNavigation) -> None:
        """Start from what an earlier run kept."""
        self._navigation.resume(kept)

    def learned_model(self) -> LearnedModel | None:
        """Return what is known of the vehicle, for a later flight; None where nothing is learned."""
        return self._learning.learned_model() if self._learning is not None else None

    def restore(self, restored: Restored) -> None:
        """Begin with what an earlier flight learned; call before the first update.

        Raises:
            ParamError: see `inherited.prior`.
        """
        if self._learning is not None:
            self._learning.restore(restored)

    def freeze(self) -> EstimatorMemory:
        """Return the whole memory."""
        return EstimatorMemory(
            self._arms.freeze(),
            self._selection.freeze(),
            self._navigation.freeze(),
            self._learning.freeze() if self._learning else None,
        )

    def thaw(self, memory: EstimatorMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._arms.thaw(memory.arms)
        self._selection.thaw(memory.selection)
        self._navigation.thaw(memory.navigation)
        if self._learning is not None and memory.learning is not None:
            self._learning.thaw(memory.learning)
