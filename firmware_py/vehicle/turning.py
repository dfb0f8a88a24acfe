"""What turns the vehicle, in pitch and in yaw, at any speed; and the filter that follows a rate of turn by it.

The linear models at 1 m/s say it for every speed: damping and coupling grow with u, what fins do grows with u^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import EDDY_TIME
from firmware_py.params import ParamError
from firmware_py.vehicle.linear_models import (
    DivingCoefficients,
    SteeringCoefficients,
    diving_coefficients,
    diving_model,
    steering_model,
)
from firmware_py.vehicle.vehicle import Vehicle

GYRO_STD = 1e-3
"""Noise of the gyros for which the filter is designed, at 100 Hz, rad/s."""
_STEPS = 500
"""By then the gains are stationary."""


Follower = tuple[float, float]
"""Memory of a filter that follows a rate of turn: the rate, rad/s, and the disturbance beside it, rad/s^2."""


class TurningAxis(NamedTuple):
    """One axis: its angular acceleration at speed u, with a crosswise velocity c (w in pitch, v in yaw).

    Attributes:
        damping: of the rate, by u, 1/m.
        crosswise: by u c, 1/m^2.
        restoring: by the sine of pitch, 1/s^2; 0 in yaw.
        control: by u^2, of the fin angle of the axis (delta_s, delta_r), 1/m^2.
        sway: what changes v: by u v, 1/m, by u r, and by u^2 delta_r, 1/m; zeros in pitch.
    """

    damping: float
    crosswise: float
    restoring: float
    control: float
    sway: tuple[float, float, float]

    def eddies(self, u: float, std: float) -> float:
        """Return what eddies of 1 sigma `std`, m/s, do at speed u, m/s, as a random walk, rad/s^2/sqrt(s)."""
        return abs(self.crosswise) * u * std * math.sqrt(2.0 / EDDY_TIME)


def pitch_axis(vehicle: Vehicle, other: DivingCoefficients | None = None) -> TurningAxis:
    """Return the axis of the stern planes and bow planes, with `other` coefficients than those of the vehicle.

    Raises:
        ParamError: the vehicle has no inertia in pitch.
    """
    ((damping, restoring, _), *_), (control, *_) = diving_model(vehicle, 1.0, other)
    heave = control * vehicle.coefficients.M_w / (other or diving_coefficients(vehicle)).M_ds
    return TurningAxis(damping, heave, restoring, control, (0.0, 0.0, 0.0))


def yaw_axis(vehicle: Vehicle, other: SteeringCoefficients | None = None) -> TurningAxis:
    """Return the axis of the rudders, with `other` coefficients than those of the vehicle.

    Raises:
        ParamError: the vehicle has no inertia in sway and yaw.
    """
    ((a_vv, a_vr, _), (a_rv, a_rr, _), _), (b_v, b_r, _) = steering_model(vehicle, 1.0, other)
    return TurningAxis(a_rr, a_rv, 0.0, b_r, (a_vv, a_vr, b_v))


def steady_turn(axis: TurningAxis, stable: float = 0.0) -> float:
    """Return G of a turn in which sway and yaw no longer change (Eq. 30), r = G u delta_r, 1/m.

    Args:
        axis: see `yaw_axis`.
        stable: the stiffness of a hull that just holds its course by itself, 1/m^2.

    Returns:
        Infinity if it does not.
    """
    a_vv, a_vr, b_v = axis.sway
    stiffness = a_vv * axis.damping - a_vr * axis.crosswise
    if not (stiffness > stable and a_vv < 0.0):
        return math.inf
    return (axis.crosswise * b_v - a_vv * axis.control) / stiffness


class HeavedAxis(NamedTuple):
    """How the hull heaves, and how it pitches while it turns.

    Attributes:
        heave: what changes w: by u w, 1/m, by u q, and by u^2 delta_s, 1/m.
        turning: angular acceleration in pitch by r^2, by v r, 1/m, and by v^2, 1/m^2.
    """

    heave: tuple[float, float, float]
    turning: tuple[float, float, float]


def heaved_axis(vehicle: Vehicle) -> HeavedAxis:
    """Return what vehicle.toml says of heave, and of pitch in turns (Eq. 1).

    Raises:
        ParamError: the vehicle has no inertia in pitch.
    """
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    L, half = hull.length, 0.5 * hull.density * hull.length**2
    mass, inertia = body.mass - half * L * c.Z_wdot, body.I_y - half * L**3 * c.M_qdot
    if not (mass > 0.0 and inertia > 0.0):
        raise ParamError("coefficients: Z_wdot, M_qdot leave no inertia in heave or pitch; they should be negative")
    heave = half * c.Z_w / mass, (half * L * c.Z_q + body.mass) / mass, half * c.Z_ds / mass
    moment = half * L / inertia
    return HeavedAxis(heave, (moment * L * L * c.M_rr, moment * L * c.M_vr, moment * c.M_vv))


def stationary_gains(walk: float, dt: float) -> tuple[float, float]:
    """Return the gains of a Kalman filter that follows a rate of turn, and of the disturbance that it finds beside it.

    Args:
        walk: the disturbance, an angular acceleration, as a random walk, rad/s^2/sqrt(s).
        dt: step of the filter, s; the rate is the mean of the gyro over it.
    """
    noise, q = GYRO_STD**2 * 0.01 / dt, walk * walk * dt
    p_rr, p_rd, p_dd = noise, 0.0, noise
    gain = gain_d = 0.0
    for _ in range(_STEPS):
        p_rr, p_rd, p_dd = p_rr + 2.0 * dt * p_rd + dt * dt * p_dd, p_rd + dt * p_dd, p_dd + q
        gain, gain_d = p_rr / (p_rr + noise), p_rd / (p_rr + noise)
        p_rr, p_rd, p_dd = (1.0 - gain) * p_rr, (1.0 - gain) * p_rd, p_dd - gain_d * p_rd
    return gain, gain_d


def damped_share(damping: float, dt: float) -> float:
    """Return the share of a moment that damping, 1/s, leaves over a step of `dt`, s.

    `follow` goes on with what there is when a step begins; given this share of damping and moments it is exact.
    """
    return math.expm1(damping * dt) / (damping * dt) if damping else 1.0


def follow(
    follower: Follower, gains: tuple[float, float], rate: float, damping: float, known: float, dt: float
) -> tuple[float, Follower]:
    """Return the innovation of a filter, rad/s, and the filter after a step.

    Args:
        follower: the filter before.
        gains: see `stationary_gains`.
        rate: mean of the measured rate of turn over the step, rad/s.
        damping: of the rate, 1/s, negative.
        known: all other angular acceleration that the model knows, rad/s^2, between this step and the one before.
        dt: s.
    """
    before, disturbance = follower
    predicted = before + dt * (damping * before + known + disturbance)
    e = rate - predicted
    return e, (predicted + gains[0] * e, disturbance + gains[1] * e)
