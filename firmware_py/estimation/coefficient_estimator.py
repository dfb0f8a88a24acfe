"""The coefficient estimator: starts the filter behind the fixed-lag buffer, pauses it, judges it and resets it."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from operator import mul
from typing import NamedTuple

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.coefficient_records import EkfMemory
from firmware_py.estimation.coefficient_validity import CoefficientValidity, ValidityMemory, ValidityParams
from firmware_py.estimation.doubts import Doubts, DoubtsMemory
from firmware_py.estimation.filter_velocity import filter_velocity
from firmware_py.estimation.fixed_lag_buffer import FixedLagBuffer, FixedLagBufferMemory, Span
from firmware_py.estimation.identifiability import LearnedState, report, reported
from firmware_py.estimation.inherited import learned_model, prior
from firmware_py.estimation.learning_params import LearningParams
from firmware_py.estimation.model.state import CURRENT_EAST, CURRENT_NORTH, MOVING, STILL
from firmware_py.estimation.navigation.velocity import FilterVelocity
from firmware_py.estimation.value_bounds import ValueBounds, possible, unbounded
from firmware_py.records.command import Applied
from firmware_py.records.estimate import Learned, StateEstimate
from firmware_py.records.event import Cause, Event
from firmware_py.records.health import NO_DOUBTS, AxisDoubt, SourceState
from firmware_py.records.passport import LearnedModel, Restored
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Rate, Tick
from firmware_py.vehicle.vehicle import Vehicle

VALUES_RATE, REPORT_RATE = Rate.HZ_10, Rate.HZ_1
"""How often `Learned` is made anew: its values, and its report."""
ATTITUDE_AGE_MAX = 0.1
"""It begins with a ping of the DVL, and an attitude that is no older than this, s."""
DEPTH_SIGMAS = 2.0
"""So many sigmas of depth it must be under water by."""


class CoefficientEstimatorMemory(NamedTuple):
    """Everything that is remembered."""

    buffer: FixedLagBufferMemory
    ekf: EkfMemory
    health: ValidityMemory
    running: bool
    begun: bool
    resets: int
    iterations: int
    ever: tuple[bool, ...]
    bounds: ValueBounds
    last: Learned
    velocity: FilterVelocity | None
    doubts: DoubtsMemory


class CoefficientEstimator:
    """Follows the vehicle a lag behind, and reports what it has learned.

    `last` is what the last update returned, `velocity` that of vehicle and water while the filter runs and its
    innovations are what they should be.
    """

    velocity: FilterVelocity | None = None

    def __init__(
        self, params: LearningParams, coefficients: CoefficientParams, health: ValidityParams, vehicle: Vehicle
    ) -> None:
        """Make the filter.

        Raises:
            ParamError: see `CoefficientEkf`.
        """
        self._params = params
        self.ekf = CoefficientEkf(vehicle, coefficients)
        first, count = self.ekf.model.first, len(coefficients.names)
        self._count, self._learned = count, slice(first, first + count)
        self._buffer, self._doubts = FixedLagBuffer(params.horizon, vehicle), Doubts(self.ekf, vehicle)
        self._health = CoefficientValidity(health, self.ekf.model, count)
        self._running = self._begun = False
        self._whole, self._carries = True, vehicle.drop_weight is not None
        self._resets = self._filter_resets = self._iterations = 0
        self._variances = [P.diagonal()[self._learned] for P in self.ekf.P]
        """Of the coefficients, by filter: views of the covariances."""
        self._std, self._ever = np.zeros(count), np.zeros(count, dtype=np.bool_)
        lower, upper = self.ekf.tuning.lower[self._learned], self.ekf.tuning.upper[self._learned]
        self._possible = possible(self.ekf.names, lower.tolist(), upper.tolist())
        self._intensities = coefficients.turbulence
        self._bounds = unbounded(count)
        self._forget()
        self._permit()
        self.last = self._learned_now(None, self._report())

    def with_params(self, params: LearningParams, health: ValidityParams, vehicle: Vehicle) -> CoefficientEstimator:
        """Return an estimator that goes on from here with other rules; use one of the two: the filter is shared."""
        other = copy.copy(self)
        other._params = params
        other._health = CoefficientValidity(health, self.ekf.model, self._count)
        other._health.thaw(self._health.freeze())
        if params.horizon != self._params.horizon:
            other._buffer = FixedLagBuffer(params.horizon, vehicle)
            other._buffer.thaw(self._buffer.freeze())
        return other

    @property
    def held(self) -> tuple[bool, ...]:
        """Return whether what planes and rudders do is held; see `doubted_fins`."""
        return self._doubts.fins.held

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        state: StateEstimate,
        doubts: Sequence[AxisDoubt] = NO_DOUBTS,
    ) -> Learned:
        """Return what is known after the tick.

        `state` is what navigation makes of the same frame, `doubts` is for `Doubts`.
        """
        params, buffer = self._params, self._buffer
        gone = applied.drop or (self._carries and frame.hardpoint.ok and not frame.hardpoint.value.holds)
        self._whole = not gone  # without its drop weight it is another vehicle, of which nothing is learned
        buffer.hear(tick.t, frame, applied, doubts[0].idle)
        deep = state.eta.z - DEPTH_SIGMAS * state.depth_std >= params.depth_min
        heard = state.attitude_ok and state.sensors.ahrs.state is not SourceState.LOST  # one that is back may be late
        may = deep and heard and self._whole
        for span in buffer.spans(tick.t):
            ping, turn = buffer.last
            if not (may and span.t - ping.t <= params.gap_max and ping.values[0] >= params.speed_min):
                self._running = False
            elif self._running:
                self._step(span)
            elif ping.t >= span.t and span.t - turn.t <= ATTITUDE_AGE_MAX:
                self._begin(span)
        if tick.every(VALUES_RATE):
            mute, rates = buffer.mute, buffer.rates(applied.fins)
            innovations, moved = (self._health.trusted, self._health.surprised), self._doubts.water.moves
            if self._doubts.update(tick.t, state, mute, rates, doubts, *innovations, self.last.turbulence):
                self._bounds, self._running = unbounded(self._count), False  # the motion was followed by a wrong model
                self._health.reset()  # without a DVL nothing begins anew, and nothing counts as known until then
                self._permit()
            elif self._doubts.water.moves != moved:
                self._permit()
            self.last = self._learned_now(self.last, self._report() if tick.every(REPORT_RATE) else self.last.report)
        return self.last

    def learned_model(self) -> LearnedModel:
        """Return what is known of the vehicle, for a later flight."""
        known = self.ekf.estimate()
        return learned_model(self.ekf.bank, known.mean, known.covariance, self.last.valid)

    def restore(self, restored: Restored) -> None:
        """Begin with what an earlier flight learned; call before the first update.

        Raises:
            ParamError: see `inherited.prior`.
        """
        self.ekf.restore(*prior(restored, self.ekf.bank))
        self.last = self._learned_now(None, self._report())

    def _begin(self, span: Span) -> None:
        """Begin with the motion of the last measurements; what was learned before stays."""
        ping, turn = self._buffer.last
        nu, angles = (*ping.values[:3], *turn.values[:3]), turn.values[3:]
        self.ekf.resume(nu, angles, np.sqrt(span.variance))
        self._health.reset()
        self._running = self._begun = True

    def _step(self, span: Span) -> None:
        ekf = self.ekf
        if not ekf.step(span.inputs, span.h, span.z, span.variance):
            self._resets += 1
            self._forget()
            self.last = self._learned_now(None, self._report())
            return
        np.sqrt(self._variances[ekf.log_likelihood.argmax()], out=self._std)
        if ekf.resets > self._filter_resets:
            self._filter_resets = ekf.resets
            self._health.reset()
        if self._health.update(span.h, self._std, ekf.model.linearisation.regressors, ekf.nis):
            self._permit()

    def _forget(self) -> None:
        """Start anew: coefficients as in the vehicle file, and nothing known of the water."""
        self.ekf.start((0.0,) * 6, (0.0,) * 3, (1.0,) * MOVING)
        self._ever[:] = self._health.excited
        self._bounds = unbounded(self._count)
        self._doubts.fins.forget()
        self._running = self._begun = False

    def _permit(self) -> None:
        """Let coefficients learn whose motion is informative, and that are not held; others become no less certain."""
        held = [self._doubts.holds(name) for name in self.ekf.names]
        self.ekf.permit(self._health.informative & ~np.array(held, dtype=np.bool_))
        self._ever |= self._health.excited

    def _learned_now(self, before: Learned | None, report: tuple[Event, ...]) -> Learned:
        """Return what is known. What was not excited since `before` stays, unless an iteration took over."""
        mean, std, weights = (array.tolist() for array in self.ekf.bank.combine())
        value, sigma = mean[self._learned], std[self._learned]
        _, excited, nis = self._health.verdict
        nothing = (False,) * self._count
        excited = excited if self._running else nothing
        iterations, self._iterations = self._iterations, self.ekf.iteration.accepted
        if before is not None and iterations == self._iterations:
            for i, moved in enumerate(excited):
                if not (moved or before.excited[i]):
                    value[i], sigma[i] = before.value[i], before.std[i]
        if not self._bounds.hold(value):  # it was not to be relied on: consistency is to be earned anew
            self._health.reset()
            self._bounds, self.ekf.bursts = unbounded(self._count), self.ekf.bursts + 1
        turbulence, self.velocity = sum(map(mul, weights, self._intensities)), None
        if self._running and self._health.trusted:
            self.velocity = filter_velocity(self._buffer.t, mean, std, self.ekf.model.water, turbulence)
        valid = self._valid(value, sigma)
        self._bounds = self._bounds.after(value, sigma, valid)
        current = slice(CURRENT_NORTH, CURRENT_EAST + 1)
        flows = self.ekf.model.water != STILL
        (north, east), (north_std, east_std) = (mean[current], std[current]) if flows else ((math.nan,) * 2,) * 2
        return Learned(
            value=tuple(value),
            std=tuple(sigma),
            valid=valid,
            excited=excited,
            current=(north, east),
            current_std=(north_std, east_std),
            turbulence=turbulence,
            nis=nis,
            rejected=sum(self.ekf.rejected.tolist()),
            dropped=self._buffer.dropped,
            resets=self._resets + self.ekf.resets,
            horizon=self._buffer.t if self._running else math.nan,
            report=report,
        )

    def _valid(self, value: list[float], sigma: list[float]) -> tuple[bool, ...]:
        """Return what may be relied on: what is valid, was confirmed by a pass over the whole flight, and still holds.

        A value that its bound has stopped is no estimate: it has to be a sigma away, and from a sign that cannot be.
        """
        valid, iterated = self._health.sure(sigma), self.ekf.confirmed.holds.tolist()
        known = self._begun and self._whole
        free = [
            a and b and not self._doubts.fins.holds(n) for a, b, n in zip(valid, iterated, self.ekf.names, strict=True)
        ]
        each = zip(free, self._possible.low, value, self._possible.high, sigma, strict=True)
        return tuple([known and a and low + s < x < high - s for a, low, x, high, s in each])

    def _report(self) -> tuple[Event, ...]:
        """Return what was learned and what was not."""
        model, count, learned = self.ekf.model, self._count, self._learned
        if not self._begun:
            return (reported(Cause.NOT_BEGUN, (float(count),)),)
        excited, known = self._health.verdict.excited, self.ekf.estimate()
        return report(
            LearnedState(
                model.names[:count],
                known.covariance[learned, learned],
                self.ekf.prior[learned],
                np.array(model.sizes[:count]),
                np.array(self._valid(known.values.tolist(), known.std.tolist())),
                np.array(excited) & self._running,
                self._ever,
            )
        )

    def freeze(self) -> CoefficientEstimatorMemory:
        """Return the whole memory."""
        return CoefficientEstimatorMemory(
            self._buffer.freeze(),
            self.ekf.freeze(),
            self._health.freeze(),
            self._running,
            self._begun,
            self._resets,
            self._iterations,
            tuple(self._ever.tolist()),
            self._bounds,
            self.last,
            self.velocity,
            self._doubts.freeze(),
        )

    def thaw(self, memory: CoefficientEstimatorMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._buffer.thaw(memory.buffer)
        self.ekf.thaw(memory.ekf)
        self._health.thaw(memory.health)
        self._doubts.thaw(memory.doubts)
        self._running, self._begun = memory.running, memory.begun
        self._resets, self._bounds, self.last = memory.resets, memory.bounds, memory.last
        self.velocity = memory.velocity
        self._filter_resets, self._iterations = self.ekf.resets, memory.iterations
        self._permit()
        self._ever[:] = memory.ever
