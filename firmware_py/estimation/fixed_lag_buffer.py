"""The fixed-lag buffer: measurements in the order of their validity, for a filter that runs behind the clock.

Measurements come late, each sensor's by its own latency, and fin angles are reported from time to time. So the filter
is kept a fixed lag behind the clock. By then the measurements of that time have arrived, are put in order, and each is
taken once, at its time of validity; and the fins' reports lie on both sides of a step, so their mean over it is known.
Work is the same in every tick: nothing is ever computed again.
"""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from firmware_py.estimation.interval_mean import IntervalMeans, Reports
from firmware_py.estimation.model.jacobians import Array
from firmware_py.params import TakesEffect, param
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.vehicle.servo import servo_angle, servo_rate
from firmware_py.vehicle.vehicle import Vehicle

_TOGETHER = 1e-6
"""Times as near as this, s, are one."""
_SPANS = 8
"""The most steps in one tick; a backlog waits. At 50 Hz, with two measurements, seven of the shortest can be due."""
MAGNITUDE_MAX = 50.0
"""No speed (m/s), rate (rad/s) or angle (rad) of such a vehicle; a measurement that is as long as that is none."""
_FINEST = 1e-6
"""No ping is better than this, m/s, whatever it states."""
_TRAVEL = 0.5 * math.pi
"""No fin is turned further, rad."""
_OVERSPEED = 2.0
"""No propeller turns faster than its highest speed by more than this."""
DVL, AHRS = 0, 1


@dataclass(frozen=True, slots=True)
class FixedLagBufferParams:
    """How far behind the clock the filter lives, and what it may expect of the sensors."""

    lag: float = param(
        0.2,
        unit="s",
        low=0.0,
        high=0.5,
        doc="How far behind: longer than any sensor's latency.",
        mav="LAG",
        when=TakesEffect.RESTART,
    )
    longest: float = param(
        0.02,
        unit="s",
        low=0.005,
        high=0.1,
        doc="Longest step without a measurement.",
        mav="LONGEST",
        when=TakesEffect.RESTART,
    )
    stale: float = param(
        0.5,
        unit="s",
        low=0.02,
        high=10.0,
        doc="A fin's older report gives way to where its servo should be, the propeller's to the command.",
        mav="STALE",
    )
    speed_std: float = param(
        0.01, unit="m/s", low=1e-6, high=1.0, doc="1 sigma of a ping that states none.", mav="U_STD"
    )
    rate_std: float = param(0.05, unit="deg/s", low=1e-6, high=10.0, doc="1 sigma of the gyros.", mav="RATE_STD")
    tilt_std: float = param(0.3, unit="deg", low=1e-6, high=30.0, doc="1 sigma of roll and pitch.", mav="TILT_STD")
    heading_std: float = param(0.5, unit="deg", low=1e-6, high=60.0, doc="1 sigma of the heading.", mav="HDG_STD")


class Span(NamedTuple):
    """One step of the filter: it ends at t (s) after h (s) under `inputs`; z, (9,), was measured there, or NaN.

    The arrays are the buffer's own: they are valid until the next span.
    """

    t: float
    h: float
    inputs: Array
    z: Array
    variance: Array


class Measurement(NamedTuple):
    """A measurement: u v w and 1 sigma of a ping, or p q r phi theta psi."""

    t: float
    sensor: int
    values: tuple[float, ...]


class FixedLagBufferMemory(NamedTuple):
    """Time up to which steps were made, what waits, the times of each sensor's newest, and the last one taken.

    `heard` is when it was told last, s; `obeying` where each fin is then if it obeys, rad; `mute` which report nothing.
    """

    t: float
    waiting: tuple[Measurement, ...]
    actuators: tuple[Reports, ...]
    newest: tuple[float, ...]
    last: tuple[Measurement, ...]
    dropped: int
    heard: float
    obeying: tuple[float, ...]
    mute: tuple[bool, ...]


class FixedLagBuffer:
    """Puts measurements in order.

    `dropped` counts the measurements that are not used: older than the lag, from the future, not after the last of
    their sensor, not finite, or out of range. A propeller that reports nothing, or an impossible value, is taken to do
    what was commanded, a fin what its servo makes of that; `mute` says which fins that are.
    """

    def __init__(self, params: FixedLagBufferParams, vehicle: Vehicle) -> None:
        self._params = params
        shaft = len(vehicle.fins)
        self._actuators = IntervalMeans([*((*row, 0.0) for row in vehicle.deflection_rows), (*(0.0,) * shaft, 1.0)])
        self._reach = (*(_TRAVEL,) * shaft, _OVERSPEED * vehicle.propeller.n_max)
        self._waiting: list[Measurement] = []
        self._newest = [-math.inf, -math.inf]
        self._t = self._heard = -math.inf
        self._obeying, self.mute = (0.0,) * shaft, (False,) * shaft
        self.dropped = 0
        tilt, gyro = params.tilt_std**2, params.rate_std**2
        self._usual = np.array((params.speed_std**2,) * 3 + (gyro,) * 3 + (tilt, tilt, params.heading_std**2))
        self._inputs, self._z, self._variance = np.zeros(4), np.zeros(9), np.zeros(9)
        self.last = [Measurement(-math.inf, sensor, (0.0,) * 6) for sensor in (DVL, AHRS)]
        """The last measurement of each sensor that was taken."""

    @property
    def t(self) -> float:
        """Return the time up to which the filter has been stepped, s."""
        return self._t

    def rates(self, told: Sequence[float]) -> tuple[float, ...]:
        """Return how fast each fin turns if it obeys, rad/s, where it is `told` these angles, rad."""
        return tuple([servo_rate(angle, to) for angle, to in zip(self._obeying, told, strict=True)])

    def hear(self, t: float, frame: SensorFrame, applied: Applied, idle: Sequence[int] = ()) -> None:
        """Take what was received in the tick at t, s; `applied` is what was commanded one tick before.

        A fin that is `idle` counts as straight: an angle that makes no force, 0.05 deg, taught a wrong N_v (32 sigma).
        """
        oldest, reach, actuators = t - self._params.stale, self._reach, self._actuators
        dt, self._heard = t - self._heard, t
        obeying = [servo_angle(was, told, dt) for was, told in zip(self._obeying, applied.fins, strict=True)]
        mute, self._obeying = [False] * (len(obeying) + 1), tuple(obeying)
        obeying.append(applied.n)
        for i, heard in enumerate((*frame.fins, frame.n)):
            if not (heard.ok and heard.t_valid >= oldest and -reach[i] <= heard.value <= reach[i]):
                mute[i] = True
                actuators.add(i, t, obeying[i])
            elif heard.fresh:
                actuators.add(i, min(heard.t_valid, t), 0.0 if i in idle else heard.value)
        self.mute = tuple(mute[:-1])

        dvl, ahrs = frame.dvl, frame.ahrs
        if dvl.fresh and dvl.ok:
            u, v, w, fom, _ = dvl.value
            std = min(max(fom, _FINEST), MAGNITUDE_MAX) if fom > 0.0 else self._params.speed_std
            self._wait(t, dvl.t_valid, DVL, (u, v, w, std))
        if ahrs.fresh and ahrs.ok:
            phi, theta, psi, p, q, r = ahrs.value
            self._wait(t, ahrs.t_valid, AHRS, (p, q, r, phi, theta, psi))

    def spans(self, t: float) -> Iterator[Span]:
        """Yield the steps that are due at t, s, in order."""
        waiting, longest = self._waiting, self._params.longest
        end = t - self._params.lag + _TOGETHER
        if self._t == -math.inf:
            self._t = waiting[0].t - longest if waiting else end
        for _ in range(_SPANS):
            here = waiting[0].t if waiting else math.inf
            if here > min(end, self._t + longest):
                if end - self._t < longest:
                    return
                here = self._t + longest
            self._z.fill(math.nan)
            self._variance[:] = self._usual
            while waiting and waiting[0].t <= here + _TOGETHER:
                self._take(waiting.pop(0))
            self._actuators.mean(self._t, here, self._inputs)
            h, self._t = here - self._t, here
            yield Span(here, h, self._inputs, self._z, self._variance)

    def _wait(self, t: float, t_valid: float, sensor: int, values: tuple[float, ...]) -> None:
        size = 0.0
        for value in values:
            size += value * value
        if (
            size <= MAGNITUDE_MAX * MAGNITUDE_MAX
            and max(self._t, self._newest[sensor]) + _TOGETHER < t_valid <= t + _TOGETHER
        ):
            self._newest[sensor] = t_valid
            insort(self._waiting, Measurement(t_valid, sensor, values))
        else:
            self.dropped += 1

    def _take(self, measurement: Measurement) -> None:
        _, sensor, values = measurement
        self.last[sensor] = measurement
        if sensor == DVL:
            self._z[:3], self._variance[:3] = values[:3], values[3] * values[3]
        else:
            self._z[3:] = values

    def freeze(self) -> FixedLagBufferMemory:
        """Return the whole memory."""
        return FixedLagBufferMemory(
            self._t,
            tuple(self._waiting),
            self._actuators.freeze(),
            tuple(self._newest),
            tuple(self.last),
            self.dropped,
            self._heard,
            self._obeying,
            self.mute,
        )

    def thaw(self, memory: FixedLagBufferMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._t, self._waiting, self.dropped = memory.t, list(memory.waiting), memory.dropped
        self._newest, self.last = list(memory.newest), list(memory.last)
        self._actuators.thaw(memory.actuators)
        self._heard, self._obeying, self.mute = memory.heard, memory.obeying, memory.mute
