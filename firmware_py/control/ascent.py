"""Control in SURFACE: a pitch instead of a depth is held, with attitude or without, and the propeller may go astern."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.params import ParamError, param
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import DivingCoefficients, diving_coefficients, diving_model
from firmware_py.vehicle.turning import heaved_axis, pitch_axis
from firmware_py.vehicle.vehicle import Vehicle

_INTEGRAL_SHARE = 0.1
"""Bandwidth of the integral over that of the law."""
_INTEGRAL_MAX = 0.5
"""Bound of the integral, of the greatest angle."""
_TAU = 1.0
"""Time constant of what the vertical velocities tell of the pitch, s."""
_CROSS_FLOW = 0.71
"""What cross-flow leaves of the pitch that the linear model gives in steady motion: 12 deg for 5 on NPS AUV II."""
_BLIND_GAIN = 1.2
"""What the planes do to the pitch over its error, where it is known from velocities alone; more would need its rate."""
_BLIND_MAX = math.radians(29.0)
"""More pitch by the planes without attitude lets the vehicle pitch without end."""
_QUICKEST = 5.0
"""The greatest bandwidth, 1/s."""
_DECAY = 0.2
"""The slowest pole of pitch and heave, over the bandwidth."""
_TRIM_TIME = 20.0
"""The trim is a mean over so long, s."""
_TRIM_MAX = math.radians(3.0)
"""More is no trim: a pitch that was not true, or a moment that may end."""
_SLOW = 0.4
"""Slower than this, m/s, the velocities tell nothing of the pitch."""


@dataclass(frozen=True, slots=True)
class AscentControlParams:
    """Gain of the pitch law; propeller speed astern."""

    bandwidth: float = param(
        0.6,
        unit="1/s",
        low=0.05,
        high=_QUICKEST,
        doc="Of the pitch law, at least: more where heave asks for it. Larger: faster, with larger angles.",
        mav="BW",
    )
    n_reverse: float = param(
        700.0, unit="rpm", low=0.0, high=1e5, doc="Propeller speed astern that takes the way off.", mav="N_REV"
    )


class AscentControlMemory(NamedTuple):
    """What is remembered.

    Attributes:
        integral: of the pitch law, rad of stern planes.
        z: depth of the last tick, m.
        pitch: what velocities tell of it, rad.
        trim: the angle of the stern planes at which the hull was level, rad.
    """

    integral: float = 0.0
    z: float = math.nan
    pitch: float = 0.0
    trim: float = 0.0


class PitchControl:
    """Holds a pitch by the stern planes."""

    def __init__(self, params: AscentControlParams, vehicle: Vehicle) -> None:
        self._asked = params.bandwidth
        self._limit = vehicle.effectiveness.delta_s_max
        self._vehicle = vehicle
        self._coefficients: DivingCoefficients | None = None
        self._pitching = _CROSS_FLOW * abs(steady_pitch(vehicle))
        """Pitch by the angle of the stern planes in steady motion at 1 m/s."""
        self.adopt(diving_coefficients(vehicle))
        self._memory = AscentControlMemory()

    def adopt(self, coefficients: DivingCoefficients) -> None:
        """Design from other coefficients."""
        if coefficients == self._coefficients:
            return
        self._coefficients = coefficients
        self._bandwidth = settling_bandwidth(self._asked, self._vehicle, coefficients)
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
        self._memory = m._replace(integral=integral, z=state.eta.z, pitch=theta)
        return clip(delta_s, -self._limit, self._limit)

    def update_blind(self, pitch_d: float, state: StateEstimate, u_d: float, dt: float) -> float:
        """Return delta_s, rad, without attitude: trim and a fixed angle; a good DVL and pressure tell of the pitch.

        u_d is the speed that is driven at, m/s.
        """
        (u, _, w, *_), z, m, sensors = state.nu, state.eta.z, self._memory, state.sensors
        good = sensors.dvl.believed and sensors.pressure.believed
        pitch, pitching = m.pitch, self._pitching * u_d * u_d
        delta_s = m.trim - pitch_d / pitching
        if good and state.velocity_ok and state.depth_ok and u > _SLOW and m.z == m.z:
            pitch += dt / (_TAU + dt) * (_pitch_seen(u, w, (z - m.z) / dt) - pitch)
            delta_s -= _BLIND_GAIN / pitching * (pitch_d - pitch)
        self._memory = m._replace(integral=0.0, z=z if state.depth_ok else math.nan, pitch=pitch)
        return clip(delta_s, max(-_BLIND_MAX / pitching, -self._limit), 0.0)

    def follow(self, delta_s: float, state: StateEstimate, dt: float) -> None:
        """Learn the trim from stern planes, rad, that another law moves while attitude and speed are known."""
        u, theta, m = state.nu.u, state.eta.theta, self._memory
        if state.attitude_ok and state.velocity_ok and u > _SLOW:
            level = delta_s + theta / (self._pitching * u * u)
            trim = clip(m.trim + dt / _TRIM_TIME * (level - m.trim), -_TRIM_MAX, _TRIM_MAX)
            self._memory = m._replace(trim=trim)

    def reset(self) -> None:
        """Clear the memory."""
        self._memory = AscentControlMemory()

    def freeze(self) -> AscentControlMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: AscentControlMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory


def steady_pitch(vehicle: Vehicle) -> float:
    """Return pitch by stern plane angle where neither heave nor pitch changes, at 1 m/s (Eq. 1); it grows by u^2.

    Raises:
        ParamError: no such pitch exists, for the vehicle has no inertia, damping in heave or righting moment.
    """
    pitch, ((heave_w, _, heave_s), _) = pitch_axis(vehicle), heaved_axis(vehicle)
    if heave_w == 0.0:
        raise ParamError("coefficients: Z_w = 0 leaves heave without damping; it should be negative")
    if pitch.restoring == 0.0:
        raise ParamError("body: z_G and z_B leave no righting moment in pitch; z_G should be greater, further down")
    return -(pitch.control - pitch.crosswise * heave_s / heave_w) / pitch.restoring


def settling_bandwidth(asked: float, vehicle: Vehicle, coefficients: DivingCoefficients) -> float:
    """Return the least bandwidth from `asked` on, 1/s, with which pitch and heave settle at the speed of trim.

    The law takes away the hull's own damping and stiffness and puts its own there, by a model without heave (Eq. 26). A
    hull that has begun to turn is turned further by its heave: where its own damping is the greater one, too little is
    left (REMUS 100 at 0.6 1/s and 1.54 m/s: poles at +0.4 and +0.1 1/s). If no bandwidth does, it is the one asked for.
    """
    bandwidth = asked
    while bandwidth <= _QUICKEST:
        if settles(bandwidth, vehicle, coefficients, vehicle.propeller.u_trim):
            return bandwidth
        bandwidth *= 1.1
    return asked


def settles(bandwidth: float, vehicle: Vehicle, coefficients: DivingCoefficients, u: float) -> bool:
    """Return whether the law makes pitch and heave decay by _DECAY times its bandwidth at speed u, m/s, or faster.

    That is the criterion of Routh for the poles of heave, pitch rate and pitch, moved by so much.
    """
    pitch, ((heave_w, heave_q, heave_s), _) = pitch_axis(vehicle, coefficients), heaved_axis(vehicle)
    w, by_fin, s = bandwidth, heave_s / pitch.control, -_DECAY * bandwidth
    a, b = heave_w * u, heave_q * u - by_fin * (2.0 * w + pitch.damping * u)
    e, f = -by_fin * (w * w + pitch.restoring), pitch.crosswise * u
    c2, c1, c0 = 2.0 * w - a, w * w - 2.0 * w * a - f * b, -a * w * w - f * e
    c2, c1, c0 = c2 + 3.0 * s, c1 + (2.0 * c2 + 3.0 * s) * s, c0 + (c1 + (c2 + s) * s) * s
    return c2 > 0.0 and c0 > 0.0 and c2 * c1 > c0


def _pitch_seen(u: float, w: float, z_dot: float) -> float:
    """Return the pitch, rad, at which u and w make the depth grow by z_dot, m/s; small angles, no roll.

    A z_dot beyond u is noise of the pressure: +-90 deg then, for noise to even out.
    """
    return math.asin(clip((w - z_dot) / u, -1.0, 1.0))
