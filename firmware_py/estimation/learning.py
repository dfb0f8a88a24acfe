"""Learning in flight: the coefficient filter on the horizon, started, held, watched and begun anew."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf, CoefficientParams, EkfMemory
from firmware_py.estimation.health import Health, HealthMemory, HealthParams, Verdict
from firmware_py.estimation.horizon import Horizon, HorizonMemory, HorizonParams, Span
from firmware_py.estimation.jacobians import Array
from firmware_py.estimation.transition import MOVING
from firmware_py.params import param
from firmware_py.records.command import Applied
from firmware_py.records.estimate import Learned, StateEstimate
from firmware_py.records.sensing import SensorFrame
from firmware_py.schedule import Rate, Tick
from firmware_py.vehicle.vehicle import Vehicle

SAID = Rate.HZ_10
"""How often what is learned is said anew."""


@dataclass(frozen=True, slots=True)
class LearningParams:
    """When the filter may learn."""

    enabled: bool = True
    """false: the coefficients of the vehicle file are all that is known."""
    depth_min: float = param(1.0, unit="m", low=0.0, high=100.0, doc="Nothing is learned nearer to the surface.")
    speed_min: float = param(0.3, unit="m/s", low=0.0, high=5.0, doc="Nothing is learned slower through the water.")
    gap_max: float = param(3.0, unit="s", low=0.5, high=60.0, doc="After so long without DVL and AHRS it begins anew.")
    horizon: HorizonParams = field(default_factory=HorizonParams)


class LearningMemory(NamedTuple):
    """Everything that is remembered."""

    horizon: HorizonMemory
    ekf: EkfMemory
    health: HealthMemory
    verdict: Verdict
    running: bool
    begun: bool
    fresh: bool
    heard: tuple[Array, Array]
    resets: int
    said: Learned


class Learning:
    """Follows the vehicle a lag behind, and says what it has learned."""

    def __init__(
        self, params: LearningParams, coefficients: CoefficientParams, health: HealthParams, vehicle: Vehicle
    ) -> None:
        """Makes the filter.

        Raises:
            ParamError: see `CoefficientEkf`.
        """
        self._params = params
        self.ekf = CoefficientEkf(vehicle, coefficients)
        self._count = len(coefficients.names)
        self._horizon = Horizon(params.horizon, vehicle)
        self._health = Health(health, self.ekf.model, self._count)
        self._running = self._begun = self._fresh = False
        self._z, self._heard = np.full(MOVING, math.nan), np.full(MOVING, -math.inf)
        """What each sensor said last, and when."""
        self._resets = 0
        first = self.ekf.model.first
        self._learned = slice(first, first + self._count)
        self._growth = self.ekf.rules[0, self._learned].copy()
        nan = (math.nan,) * 3
        self._verdict = Verdict((False,) * self._count, (False,) * self._count, (nan[0], nan[1], nan[2]))
        self.ekf.start((0.0,) * 6, (0.0,) * 3, (1.0,) * 9)
        self._said = self._say()

    def update(self, tick: Tick, frame: SensorFrame, applied: Applied, state: StateEstimate) -> Learned:
        """What is known after the tick; `state` is what navigation makes of the same frame."""
        self._horizon.hear(tick.t, frame, applied)
        may = state.eta.z >= self._params.depth_min and state.attitude_ok
        for span in self._horizon.spans(tick.t):
            new = ~np.isnan(span.z)
            self._z[new], self._heard[new] = span.z[new], span.t
            known = span.t - float(self._heard.min()) <= self._params.gap_max
            known = known and self._z[0] >= self._params.speed_min
            if not (may and known):
                self._running = False
            elif self._running:
                self._step(span)
            else:
                self._begin(span)
        if tick.every(SAID):
            self._said = self._say()
        return self._said

    def _begin(self, span: Span) -> None:
        """Takes motion from what the sensors said last; what was learned before stays."""
        nu, angles, std = self._z[:6].tolist(), self._z[6:].tolist(), np.sqrt(span.variance)
        if self._begun:
            self.ekf.resume(nu, angles, std)
        else:
            self.ekf.start(nu, angles, std)
        self._running = self._begun = self._fresh = True

    def _step(self, span: Span) -> None:
        excited = np.array(self._verdict.excited)
        self.ekf.rules[0, self._learned] = np.where(excited, self._growth, 0.0)
        self.ekf.rules[1, self._learned] = excited
        if not self.ekf.step(span.inputs, span.h, span.z, span.variance):
            self._running = self._begun = False
            self._resets += 1
            return
        std = np.sqrt(self.ekf.P[int(np.argmax(self.ekf.evidence))].diagonal()[self._learned])
        self._verdict = self._health.update(span.h, std, self.ekf.model.y, self.ekf.nis, self._fresh)
        self._fresh = False

    def _say(self) -> Learned:
        told = self.ekf.estimate()
        (x_c, y_c), (x_std, y_std) = told.current.tolist(), told.current_std.tolist()
        return Learned(
            value=tuple(told.values.tolist()),
            std=tuple(told.std.tolist()),
            valid=self._verdict.valid if self._begun else (False,) * self._count,
            excited=self._verdict.excited if self._running else (False,) * self._count,
            current=(x_c, y_c),
            current_std=(x_std, y_std),
            turbulence=told.turbulence,
            nis=self._verdict.nis,
            rejected=int(self.ekf.rejected.sum()),
            dropped=self._horizon.dropped,
            resets=self._resets,
            horizon=self._horizon.t if self._running else math.nan,
        )

    def freeze(self) -> LearningMemory:
        """All it remembers."""
        return LearningMemory(
            self._horizon.freeze(),
            self.ekf.freeze(),
            self._health.freeze(),
            self._verdict,
            self._running,
            self._begun,
            self._fresh,
            (self._z.copy(), self._heard.copy()),
            self._resets,
            self._said,
        )

    def thaw(self, memory: LearningMemory) -> None:
        """Takes up again what `freeze` gave."""
        self._horizon.thaw(memory.horizon)
        self.ekf.thaw(memory.ekf)
        self._health.thaw(memory.health)
        self._verdict, self._said, self._resets = memory.verdict, memory.said, memory.resets
        self._running, self._begun, self._fresh = memory.running, memory.begun, memory.fresh
        self._z[:], self._heard[:] = memory.heard
