"""Desired states and feed-forward fin angles: what the linear models must do to follow a reference.

Both kinds of law use them, so that sliding mode and PID track the same states with the same feed-forward.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import clip, euler_rates, wrap
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import LinearModel, Vector3

CLIMB_BIAS_MAX = 0.3
"""Bound of the vertical velocity that the diving model leaves out, m/s."""
PITCH_MAX = math.radians(25.0)
"""To make good what the diving model leaves out no steeper pitch is desired, rad: way and lift would be lost."""
SWAY_RATIO_MAX = 0.5
"""Bound of the steering model's sway over the speed."""


class Tracking(NamedTuple):
    """Input of a law.

    Attributes:
        error: x - x_d, in the units of the model's states.
        delta_ff: feed-forward fin angle, rad: with it x_d is a solution of x_dot = A x + b delta.
    """

    error: Vector3
    delta_ff: float


class AttitudeRates(NamedTuple):
    """Rates of pitch and heading angle, rad/s. The linear models' q and r stand for these while the vehicle rolls."""

    theta_dot: float
    psi_dot: float


def attitude_rates(state: StateEstimate) -> AttitudeRates:
    """Return theta_dot and psi_dot of a state."""
    _, _, _, phi, theta, _ = state.eta
    _, _, _, p, q, r = state.nu
    _, theta_dot, psi_dot = euler_rates(phi, theta, p, q, r)
    return AttitudeRates(theta_dot, psi_dot)


def track_depth(
    model: LinearModel, reference: Reference, state: StateEstimate, theta_dot: float, climb_bias: float
) -> Tracking:
    """Return error and feed-forward of the diving model, x = (q, theta, z).

    z_dot = -u theta + climb_bias and its derivatives give the desired states: theta_d = (climb_bias - z_d_dot) / u and
    q_d = -z_d_ddot / u. The pitch row of Eq. 26, solved for delta_s with q_d_dot = -z_d_dddot / u, gives delta_ff.

    Args:
        model: diving model (Eq. 26).
        reference: z_d and its first three derivatives, m, m/s, m/s^2, m/s^3.
        state: estimated state.
        theta_dot: rate of the pitch angle, rad/s.
        climb_bias: vertical velocity that the model leaves out, m/s, down positive.
    """
    (a_qq, a_qt, _), _, (_, minus_u, _) = model.A
    b_q, _, _ = model.b
    steepest = max(PITCH_MAX, abs(reference.z_d_dot / minus_u))
    theta_d = clip((reference.z_d_dot - climb_bias) / minus_u, -steepest, steepest)
    q_d = reference.z_d_ddot / minus_u
    delta_ff = (reference.z_d_dddot / minus_u - a_qq * q_d - a_qt * theta_d) / b_q
    return Tracking((theta_dot - q_d, state.eta.theta - theta_d, state.eta.z - reference.z_d), delta_ff)


def unmodelled_climb(model: LinearModel, state: StateEstimate) -> float:
    """Return z_dot + u theta, m/s, bounded: what Eq. 26 leaves out of the vertical velocity, down positive.

    It comes from heave, from large pitch angles and from vertical current.
    """
    _, _, (_, minus_u, _) = model.A
    return clip(state.z_dot - minus_u * state.eta.theta, -CLIMB_BIAS_MAX, CLIMB_BIAS_MAX)


class SwayState(NamedTuple):
    """Sway through the water of the steering model, m/s: `v_d` on the reference, `v` under the actual rudder."""

    v_d: float
    v: float


class SwayInput(NamedTuple):
    """What drives the sway row of the steering model: yaw rate r, rad/s, and rudder angle delta_r, rad."""

    r: float
    delta_r: float


def track_heading(
    model: LinearModel, reference: Reference, state: StateEstimate, psi_dot: float, sway: SwayState
) -> Tracking:
    """Return error and feed-forward of the steering model, x = (v, r, psi).

    The yaw row of Eq. 30, solved for delta_r with r_d = psi_d_dot, gives delta_ff.

    Args:
        model: steering model (Eq. 30).
        reference: psi_d and its first two derivatives, rad, rad/s, rad/s^2.
        state: estimated state.
        psi_dot: rate of the heading angle, rad/s.
        sway: the model's sway. The estimated v is not used: it is over ground and contains the current.
    """
    _, (a_rv, a_rr, _), _ = model.A
    _, b_r, _ = model.b
    r_d = reference.psi_d_dot
    delta_ff = (reference.psi_d_ddot - a_rv * sway.v_d - a_rr * r_d) / b_r
    return Tracking((sway.v - sway.v_d, psi_dot - r_d, wrap(state.eta.psi - reference.psi_d)), delta_ff)


def propagate_sway(
    model: LinearModel, sway: SwayState, desired: SwayInput, actual: SwayInput, u: float, dt: float
) -> SwayState:
    """Return the sway one step later: v_dot = a_vv v + a_vr r + b_v delta_r (sway row of Eq. 30), by Euler.

    A DVL's sway contains the current, which exerts no side force on the hull. The model's own sway does not contain
    it, and its error decays with the pole a_vv, so that the poles of the closed loop stay where they were placed.

    Args:
        model: steering model at the speed u.
        sway: sway now.
        desired: yaw rate and rudder of the reference; they drive `v_d`.
        actual: yaw rate and rudder of the vehicle; they drive `v`.
        u: speed, m/s; the sway stays within +-SWAY_RATIO_MAX u.
        dt: step, s.
    """
    (a_vv, a_vr, _), _, _ = model.A
    b_v, _, _ = model.b
    bound = SWAY_RATIO_MAX * u
    return SwayState(
        clip(sway.v_d + dt * (a_vv * sway.v_d + a_vr * desired.r + b_v * desired.delta_r), -bound, bound),
        clip(sway.v + dt * (a_vv * sway.v + a_vr * actual.r + b_v * actual.delta_r), -bound, bound),
    )
