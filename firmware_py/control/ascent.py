"""Control in SURFACE: a pitch instead of a depth is held, with attitude or without, and the propeller may go astern."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import DivingCoefficients, diving_coefficients, diving_model
from firmware_py.vehicle.vehicle import Vehicle

_INTEGRAL_SHARE = 0.1
"""Bandwidth of the integral over that of the law."""
_INTEGRAL_MAX = 0.5
"""Bound of the integral, of the greatest angle."""
_TAU = 1.0
"""Time constant of what the vertical velocities tell of the pitch, s."""
_PITCHING = 12.0 / 5.0
"""Pitch over stern plane angle in steady motion, about."""
_BLIND_GAIN = 0.5
"""Stern plane angle over the error of a pitch that is known from velocities alone; more would need its rate."""
_BLIND_MAX = math.radians(12.0)
"""More stern plane angle without attitude lets the vehicle pitch without end."""
_SLOW = 0.4
"""Slower than this, m/s, the velocities tell nothing of the pitch."""


@dataclass(frozen=True, slots=True)
class AscentControlParams:
    """Gain of the pitch law; propeller speed astern."""

    bandwidth: float = param(
        0.6, unit="1/s", low=0.05, high=5.0, doc="Of the pitch law. Larger: faster, with larger angles.", mav="BW"
    )
    n_reverse: float = param(
        700.0, unit="rpm", low=0.0, high=1e5, doc="Propeller speed astern that takes the way off.", mav="N_REV"
    )


class AscentControlMemory(NamedTuple):
    """Integral of the pitch law, rad of stern planes; depth, m, of the last tick; pitch that velocities tell, rad."""

    integral: float = 0.0
    z: float = math.nan
    pitch: float = 0.0


class PitchControl:
    """Holds a pitch by the stern planes."""

    def __init__(self, params: AscentControlParams, vehicle: Vehicle) -> None:
        self._bandwidth = params.bandwidth
        self._limit = vehicle.effectiveness.delta_s_max
        self._vehicle = vehicle
        self.adopt(diving_coefficients(vehicle))
        self._memory = AscentControlMemory()

    def adopt(self, coefficients: DivingCoefficients) -> None:
        """Design from other coefficients."""
        model = diving_model(self._vehicle, 1.0, coefficients)
        (self._damping, self._restoring, _), self._control = model.A[0], model.b[0]

    def update(self, pitch_d: float, state: StateEstimate, theta_dot: float, u: float, dt: float) -> float:
        """Return delta_s, rad, for the desired pitch, rad; `u` is the speed that is designed for, m/s.

        The law puts both poles of the pitch row of the diving model (Eq. 26) at the bandwidth.
        """
        w, theta, m = self._bandwidth, state.eta.theta, self._memory
        error, control = pitch_d - theta, self._control * u * u
        wanted = w * w * error - 2.0 * w * theta_dot - self._damping * u * theta_dot - self._restoring * theta
        delta_s = wanted / control + m.integral
        if abs(delta_s) < self._limit or delta_s * error > 0.0:
            bound = _INTEGRAL_MAX * self._limit
            integral = clip(m.integral + dt * _INTEGRAL_SHARE * w**3 * error / control, -bound, bound)
        else:
            integral = m.integral
        self._memory = AscentControlMemory(integral, state.eta.z, theta)
        return clip(delta_s, -self._limit, self._limit)

    def update_blind(self, pitch_d: float, state: StateEstimate, dt: float) -> float:
        """Return delta_s, rad, without attitude: fixed, corrected by the pitch that a good DVL and pressure tell."""
        (u, _, w, *_), z, m, sensors = state.nu, state.eta.z, self._memory, state.sensors
        good = sensors.dvl.believed and sensors.pressure.believed
        pitch, delta_s = m.pitch, -pitch_d / _PITCHING
        if good and state.velocity_ok and state.depth_ok and u > _SLOW and m.z == m.z:
            pitch += dt / (_TAU + dt) * (_pitch_seen(u, w, (z - m.z) / dt) - pitch)
            delta_s -= _BLIND_GAIN * (pitch_d - pitch)
        self._memory = AscentControlMemory(0.0, z if state.depth_ok else math.nan, pitch)
        return clip(delta_s, -_BLIND_MAX, 0.0)

    def reset(self) -> None:
        """Clear the memory."""
        self._memory = AscentControlMemory()

    def freeze(self) -> AscentControlMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: AscentControlMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory


def _pitch_seen(u: float, w: float, z_dot: float) -> float:
    """Return the pitch, rad, at which u and w make the depth grow by z_dot, m/s; small angles, no roll.

    A z_dot beyond u is noise of the pressure: +-90 deg then, for noise to even out.
    """
    return math.asin(clip((w - z_dot) / u, -1.0, 1.0))
