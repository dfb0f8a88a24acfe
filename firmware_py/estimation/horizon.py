"""The horizon: a filter that lives a little in the past meets every measurement in the order in which it was true.

Measurements come late, each sensor's by its own latency, and fin angles are reported from time to time. So the filter
is kept a fixed lag behind the clock. By then what was true at the horizon has arrived, is put in order, and is taken in
once, each at its time of validity; and the fins' reports lie on both sides of a step, so their mean over it is known.
Work is the same in every tick: nothing is ever computed again.
"""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from firmware_py.estimation.jacobians import Array
from firmware_py.estimation.trace import Trace, TraceMemory
from firmware_py.params import param
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.vehicle.vehicle import Vehicle

_TOGETHER = 1e-6
"""Times as near as this, s, are one."""
_SPANS = 8
"""The most steps in one tick; a backlog waits."""
DVL, AHRS = 0, 1


@dataclass(frozen=True, slots=True)
class HorizonParams:
    """How far behind the clock the filter lives, and what it may expect of the sensors."""

    lag: float = param(0.2, unit="s", low=0.0, high=0.5, doc="How far behind: longer than any sensor's latency.")
    longest: float = param(0.02, unit="s", low=0.001, high=0.1, doc="Longest step without a measurement.")
    speed_std: float = param(0.01, unit="m/s", low=1e-6, high=1.0, doc="1 sigma of a ping that states none.")
    rate_std: float = param(0.05, unit="deg/s", low=1e-6, high=10.0, doc="1 sigma of the gyros.")
    tilt_std: float = param(0.3, unit="deg", low=1e-6, high=30.0, doc="1 sigma of roll and pitch.")
    heading_std: float = param(0.5, unit="deg", low=1e-6, high=60.0, doc="1 sigma of the heading.")


class Span(NamedTuple):
    """One step of the filter: it ends at t (s) after h (s) under `inputs`; z, (9,), was measured there, or NaN."""

    t: float
    h: float
    inputs: Array
    z: Array
    variance: Array


class HorizonMemory(NamedTuple):
    """Where the horizon is, and what waits before it."""

    t: float
    waiting: tuple[tuple[float, int, tuple[float, ...]], ...]
    fins: TraceMemory
    n: TraceMemory
    newest: tuple[float, float]
    dropped: int


class Horizon:
    """Puts in order what is heard. `dropped` counts what came behind the horizon, from the future or twice."""

    def __init__(self, params: HorizonParams, vehicle: Vehicle) -> None:
        self._params = params
        self._rows = vehicle.fin_sums
        self._fins, self._n = Trace(), Trace()
        self._waiting: list[tuple[float, int, tuple[float, ...]]] = []
        self._newest = [-math.inf, -math.inf]
        self._t = -math.inf
        self.dropped = 0
        tilt, gyro = params.tilt_std**2, params.rate_std**2
        self._variance = (params.speed_std**2,) * 3 + (gyro,) * 3 + (tilt, tilt, params.heading_std**2)

    @property
    def t(self) -> float:
        """Up to where the filter has been stepped, s."""
        return self._t

    def hear(self, t: float, frame: SensorFrame, applied: Applied) -> None:
        """Takes in what came in the tick at t, s; `applied` is what the actuators were told one tick before."""
        fins = frame.fins
        if any(fin.fresh and fin.ok for fin in fins):
            newest = max(fin.t_valid for fin in fins if fin.fresh and fin.ok)
            self._fins.add(
                min(newest, t),
                self._sums([f.value if f.ok else told for f, told in zip(fins, applied.fins, strict=True)]),
            )
        elif not any(fin.ok for fin in fins):  # nobody reports: what they were told is the best there is
            self._fins.add(t, self._sums(applied.fins))
        if frame.n.fresh and frame.n.ok and math.isfinite(frame.n.value):
            self._n.add(min(frame.n.t_valid, t), (frame.n.value,))
        elif not frame.n.ok:
            self._n.add(t, (applied.n,))

        dvl, ahrs = frame.dvl, frame.ahrs
        if dvl.fresh and dvl.ok:
            u, v, w, fom, _ = dvl.value
            self._wait(t, dvl.t_valid, DVL, (u, v, w, fom if 0.0 < fom < math.inf else self._params.speed_std))
        if ahrs.fresh and ahrs.ok:
            phi, theta, psi, p, q, r = ahrs.value
            self._wait(t, ahrs.t_valid, AHRS, (p, q, r, phi, theta, psi))

    def spans(self, t: float) -> Iterator[Span]:
        """The steps that are due at t, s, in order."""
        end = t - self._params.lag + _TOGETHER
        if self._t == -math.inf:
            self._t = self._waiting[0][0] - self._params.longest if self._waiting else end
        for _ in range(_SPANS):
            waiting = self._waiting
            here = waiting[0][0] if waiting else math.inf
            if here > min(end, self._t + self._params.longest):
                if end - self._t < self._params.longest:
                    return
                here = self._t + self._params.longest
            z, variance = np.full(9, math.nan), np.array(self._variance)
            while waiting and waiting[0][0] <= here + _TOGETHER:
                _, sensor, values = waiting.pop(0)
                if sensor == DVL:
                    z[:3], variance[:3] = values[:3], values[3] ** 2
                else:
                    z[3:] = values
            h = here - self._t
            if len(self._fins) and len(self._n) and h > _TOGETHER:
                inputs = np.array((*self._fins.mean(self._t, here), *self._n.mean(self._t, here)))
                yield Span(here, h, inputs, z, variance)
            self._fins.forget(here)
            self._n.forget(here)
            self._t = here

    def _wait(self, t: float, t_valid: float, sensor: int, values: tuple[float, ...]) -> None:
        good = math.isfinite(sum(values))
        if not good or not max(self._t, self._newest[sensor]) + _TOGETHER < t_valid <= t + _TOGETHER:
            self.dropped += 1
            return
        self._newest[sensor] = t_valid
        insort(self._waiting, (t_valid, sensor, values))

    def _sums(self, angles: tuple[float, ...] | list[float]) -> tuple[float, float, float]:
        delta_s, delta_r, delta_b = [
            sum([worth * angle for worth, angle in zip(row, angles, strict=True)]) for row in self._rows
        ]
        return delta_s, delta_r, delta_b

    def freeze(self) -> HorizonMemory:
        """All it remembers."""
        newest = (self._newest[0], self._newest[1])
        return HorizonMemory(self._t, tuple(self._waiting), self._fins.freeze(), self._n.freeze(), newest, self.dropped)

    def thaw(self, memory: HorizonMemory) -> None:
        """Takes up again what `freeze` gave."""
        self._t, self._waiting, self.dropped = memory.t, list(memory.waiting), memory.dropped
        self._newest = list(memory.newest)
        self._fins.thaw(memory.fins)
        self._n.thaw(memory.n)
