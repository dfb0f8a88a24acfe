"""Adoption: the laws are designed from what the vehicle has learned of itself, as far as that can be trusted.

At 10 Hz the coefficients in force move towards the learned ones, at most by a share of their size each second, so that
no law jumps. Each coefficient is adopted by itself once its 1 sigma is small enough. What is far from vehicle.toml,
what no law can be designed from, and what the vehicle's motion contradicts (`model_evidence`) is refused, for an axis
as a whole: then the last good values hold, or vehicle.toml where these are contradicted too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.control.axis_adoption import AxisAdoption, AxisModel
from firmware_py.control.axis_memory import AxisMemory, Values
from firmware_py.control.model_evidence import PERIOD, Motion
from firmware_py.control.passport_watch import PassportMemory, PassportWatch
from firmware_py.control.sliding_mode_params import S_LAST_DEPTH, S_LAST_HEADING
from firmware_py.marine import clip
from firmware_py.records.adoption import Adopted, Refusal, Source
from firmware_py.records.command import Applied
from firmware_py.records.estimate import NOTHING_LEARNED, StateEstimate
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.health import FinHealth
from firmware_py.records.passport import LearnedModel
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Rate, Tick
from firmware_py.vehicle.linear_models import (
    DivingCoefficients,
    LinearModel,
    SteeringCoefficients,
    diving_coefficients,
    diving_model,
    steering_coefficients,
    steering_model,
)
from firmware_py.vehicle.turning import TurningAxis, pitch_axis, stationary_gains, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

Poles = tuple[float, float]
_DEPTH_MIN, _SPEED_MIN = 2.5, 0.8
"""Near the surface, m, and slower, m/s, the linear models do not hold."""
_ANGLE_MAX = math.radians(30.0)
"""Nor do they in a steeper dive, or rolled over farther."""
_CERTAIN, _UNCERTAIN = 0.2, 0.5
"""1 sigma of what turns the vehicle, of its size: below the one no caution is needed, above the other all of it."""
_TURNS = ("M_q", "M_ds", "N_r", "N_dr")
"""What turns the vehicle first of all: damping and fins."""
_TOLD_EVERY = 3.0
"""Where coefficients come from may change to and fro; of one law no more is told than one change in such a time, s."""
_EDDIES = 0.05
"""What eddies of this, m/s, do is no evidence."""


class Told(NamedTuple):
    """Where coefficients come from, as it was told, and when, s."""

    source: Source
    refusal: Refusal
    t: float


class AdoptionMemory(NamedTuple):
    """What is remembered: of both axes, and the caution.

    `sums` are of q and r over the ticks of a period, and how many ticks these are; `passport` is what was learned in an
    earlier flight; `doubts` is by how much it differs from vehicle.toml, of each axis, until this flight has told;
    `told` is the last change of each axis that was told.
    """

    depth: AxisMemory
    heading: AxisMemory
    caution: float
    sums: tuple[float, float, int]
    passport: PassportMemory
    doubts: tuple[float, float]
    told: tuple[Told, ...]


class Adoption:
    """Decides what the laws are designed from; `events` are what the last update changed."""

    events: tuple[Event, ...]

    def __init__(self, params: AdoptionParams, poles: tuple[Poles, Poles], names: tuple[str, ...], vehicle: Vehicle):
        """Begin with vehicle.toml.

        Args:
            params: when and how fast.
            poles: of the laws of depth and heading at the trim speed, 1/s.
            names: what is learned, in the order of `Learned`; nothing where nobody learns.
            vehicle: vehicle.toml.

        Raises:
            ParamError: no inertia is left.
        """
        models = _depth(vehicle, poles[0]), _heading(vehicle, poles[1])
        self._axes = [AxisAdoption(params, model, bool(set(model.names) & set(names))) for model in models]
        self._chosen = [_chosen(model.names, names) for model in models]
        self._turns = _chosen(_TURNS, names)
        self._sizes = [abs(getattr(vehicle.coefficients, name)) for name in _TURNS]
        self._on = params.enabled and bool(names)
        self._caution = 1.0
        self._sums, self._doubts = (0.0, 0.0, 0), (0.0, 0.0)
        self._passport, self._count, unknown = PassportWatch(names), len(names), (math.nan,) * len(names)
        self._nothing = replace(NOTHING_LEARNED, value=unknown, std=unknown, valid=(False,) * len(names))
        self._adopted = self._in_force()
        self._told = tuple([Told(axis.design.source, axis.design.refusal, -math.inf) for axis in self._axes])
        self.events = ()

    def begin(self, earlier: LearnedModel) -> None:
        """Begin with what an earlier flight of this vehicle learned, and the filter begins with; before any update.

        Raises:
            ParamError: no law may begin with it; see `AxisAdoption.begin`.
        """
        known = dict(zip(earlier.names, zip(earlier.value, earlier.std, strict=True), strict=True))
        valid, (depth, heading) = dict(zip(earlier.names, earlier.valid, strict=True)), self._axes
        pitch, yaw = [all(valid.get(name, False) for name in turns) for turns in (_TURNS[:2], _TURNS[2:])]
        self._doubts = depth.begin(known, pitch), heading.begin(known, yaw)
        self._passport.begin(earlier)

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        state: StateEstimate,
        applied: Applied,
        left: Sequence[FinHealth] = (),
        asked: bool = False,
        held: Sequence[bool] = (False, False),
    ) -> Adopted:
        """Return what the laws are designed from; at 10 Hz anew.

        Args:
            tick: now.
            frame: what was heard, for the fins' angles.
            state: the state with what was learned.
            applied: what was commanded in the last tick.
            left: what is left of each fin; empty: all are sound.
            asked: somebody wants to arm the vehicle, or to know whether that is possible.
            held: of planes and rudders, whether one may stay nobody knows where: nothing is learned or judged then.
        """
        self.events = self._passport.update(applied.armed, asked)
        if self._on:
            self._weigh(tick, frame, state, applied, held)
        if tick.every(Rate.HZ_10):
            learned = state.learned if len(state.learned.value) == self._count else self._nothing
            for axis, select, unknown in zip(self._axes, self._chosen, held, strict=True):
                known = select(learned.value), select(learned.std), select(learned.valid)
                axis.update(*known, left, unknown)
            self.events += self._passport.heed(learned)
            if self._on:  # what was due when it was switched off is due when it is switched on
                self._caution = self._caution_now(self._turns(learned.std))
            self._adopted = self._in_force()
            self._tell(tick.t)
        return self._adopted

    @property
    def last(self) -> Adopted:
        """Return what the last update returned."""
        return self._adopted

    def freeze(self) -> AdoptionMemory:
        """Return the whole memory."""
        depth, heading = self._axes
        told = self._passport.freeze(), self._doubts, self._told
        return AdoptionMemory(depth.freeze(), heading.freeze(), self._caution, self._sums, *told)

    def thaw(self, memory: AdoptionMemory) -> None:
        """Restore the memory that `freeze` returned."""
        for axis, remembered in zip(self._axes, memory[:2], strict=True):
            axis.thaw(remembered)
        self._caution, self._sums, self._doubts, self._told = memory.caution, memory.sums, memory.doubts, memory.told
        self._passport.thaw(memory.passport)
        self._adopted = self._in_force()

    def _weigh(
        self, tick: Tick, frame: SensorFrame, state: StateEstimate, applied: Applied, held: Sequence[bool]
    ) -> None:
        nu, eta = state.nu, state.eta
        q, r, ticks = self._sums
        self._sums = q, r, ticks = q + nu.q, r + nu.r, ticks + 1
        if tick.k % max(1, round(PERIOD / tick.dt)):
            return
        self._sums = 0.0, 0.0, 0
        judged = (
            applied.armed
            and state.attitude_ok
            and state.depth_ok
            and state.velocity_ok
            and not state.sensors.ahrs.tilt_doubted
            and state.through_water > _SPEED_MIN
            and eta.z > _DEPTH_MIN
            and max(abs(eta.theta), abs(eta.phi)) < _ANGLE_MAX
        )
        for axis, rate, unknown in zip(self._axes, (q, r), held, strict=True):
            if judged and not unknown:
                axis.weigh(tick.t, frame, applied, Motion(state.through_water, rate / ticks, eta.theta, nu.w, 0.0))
            else:
                axis.pause()

    def _caution_now(self, std: list[float]) -> float:
        """Return the caution: it grows only where learned values are given up.

        An earlier flight and vehicle.toml that differ are two measurements of one vehicle: one of them is off by that,
        however certain either is of itself, until the motion of this flight has told which.
        """
        if any(axis.design.source is Source.NOMINAL for axis in self._axes):
            return 1.0
        worst = max([s / size if s == s else 1.0 for s, size in zip(std, self._sizes, strict=True)])
        depth, heading = [
            0.0 if axis.confirmed else doubt for axis, doubt in zip(self._axes, self._doubts, strict=True)
        ]
        self._doubts, worst = (depth, heading), max(worst, depth, heading)
        now = clip((worst - _CERTAIN) / (_UNCERTAIN - _CERTAIN), 0.0, 1.0)
        return min(self._caution, now)

    def _in_force(self) -> Adopted:
        depth, heading = self._axes
        return Adopted(
            *(depth.values, heading.values, depth.design, heading.design, self._caution if self._on else 0.0),
            *(depth.held, heading.held, (depth.refuted, heading.refuted), (depth.proven, heading.proven)),
            halved=(depth.halved, heading.halved),
        )

    def _tell(self, t: float) -> None:
        """Tell at the time t, s, what changed of where the coefficients come from."""
        told = list(self._told)
        for i, law in enumerate(("depth", "heading")):
            design = getattr(self._adopted, law)
            if (design.source, design.refusal) != told[i][:2] and t - told[i].t >= _TOLD_EVERY:
                told[i] = Told(design.source, design.refusal, t)
                numbers = float(design.source), float(design.refusal)
                self.events += (event(EventKind.DESIGN_CHANGED, numbers=numbers, names=(law,)),)
        self._told = tuple(told)


def _depth(vehicle: Vehicle, poles: Poles) -> AxisModel:
    """Return the axis of the stern planes."""
    u, effectiveness, file = vehicle.propeller.u_trim, vehicle.effectiveness, diving_coefficients(vehicle)

    def linear(values: Values) -> LinearModel:
        return diving_model(vehicle, u, DivingCoefficients(*values))

    def unit(values: Values) -> TurningAxis:
        return pitch_axis(vehicle, DivingCoefficients(*values))

    gains, limit = stationary_gains(pitch_axis(vehicle).eddies(u, _EDDIES), PERIOD), effectiveness.delta_s_max
    return AxisModel(file._fields, file, linear, unit, 0, S_LAST_DEPTH, poles, effectiveness.s, limit, gains)


def _heading(vehicle: Vehicle, poles: Poles) -> AxisModel:
    """Return the axis of the rudders."""
    u, effectiveness, file = vehicle.propeller.u_trim, vehicle.effectiveness, steering_coefficients(vehicle)

    def linear(values: Values) -> LinearModel:
        return steering_model(vehicle, u, SteeringCoefficients(*values))

    def unit(values: Values) -> TurningAxis:
        return yaw_axis(vehicle, SteeringCoefficients(*values))

    gains, limit = stationary_gains(yaw_axis(vehicle).eddies(u, _EDDIES), PERIOD), effectiveness.delta_r_max
    return AxisModel(file._fields, file, linear, unit, 1, S_LAST_HEADING, poles, effectiveness.r, limit, gains)


def _chosen(names: Sequence[str], learned: Sequence[str]) -> Callable[[Sequence[Any]], list[Any]]:
    """Return a function that takes the entries of `names` out of what is sorted by `learned`; NaN where one is not."""
    where = [learned.index(name) if name in learned else -1 for name in names]
    return lambda values: [values[i] if i >= 0 else float("nan") for i in where]
