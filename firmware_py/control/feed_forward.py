"""What the believed model must do to follow a reference: the error of each state, and the fin angle that holds it.

Every law steers by these, so sliding mode and PID have the same references and the same feed-forward.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import clip, euler_rates, wrap
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import Linear, Row

DRIFT_MAX = 0.3
"""Bound of what is believed of the unexplained climb, m/s."""
SWAY_MAX = 0.5
"""Bound of the sway that is believed, as a share of the speed."""


class Track(NamedTuple):
    """error = x - x_d, and the input delta_d (rad) for which x_d obeys the model."""

    error: Row
    delta_d: float


class Rates(NamedTuple):
    """Rates of the Euler angles, rad/s: what q and r of the linear models are when the boat rolls."""

    theta_dot: float
    psi_dot: float


def rates(state: StateEstimate) -> Rates:
    """(theta_dot, psi_dot) of a state."""
    _, _, _, phi, theta, _ = state.eta
    _, _, _, p, q, r = state.nu
    _, theta_dot, psi_dot = euler_rates(phi, theta, p, q, r)
    return Rates(theta_dot, psi_dot)


def dive(model: Linear, reference: Reference, state: StateEstimate, theta_dot: float, drift: float) -> Track:
    """x = (q, theta, z). From z_dot = -u theta + drift: theta_d = (drift - z_d_dot)/u, q_d = -z_d_ddot/u, and so on."""
    (a_qq, a_qt, _), _, (_, minus_u, _) = model.A
    theta_d = (reference.z_d_dot - drift) / minus_u
    q_d = reference.z_d_ddot / minus_u
    delta_d = (reference.z_d_dddot / minus_u - a_qq * q_d - a_qt * theta_d) / model.b[0]
    return Track((theta_dot - q_d, state.eta.theta - theta_d, state.eta.z - reference.z_d), delta_d)


def unexplained_climb(model: Linear, state: StateEstimate) -> float:
    """z_dot + u theta, m/s: what Eq. 26 leaves out of the vertical motion (heave, steep pitch, a rising current)."""
    phi, theta = state.eta.phi, state.eta.theta
    u, v, w, *_ = state.nu
    z_dot = -u * math.sin(theta) + math.cos(theta) * (v * math.sin(phi) + w * math.cos(phi))
    return clip(z_dot - model.A[2][1] * theta, -DRIFT_MAX, DRIFT_MAX)


class Sway(NamedTuple):
    """Sway through the water, m/s: `v_d` on the reference, `v` as the model has it from the rudder and the yaw rate."""

    v_d: float
    v: float


def turn(model: Linear, reference: Reference, state: StateEstimate, psi_dot: float, sway: Sway) -> Track:
    """x = (v, r, psi). The yaw row of Eq. 30 gives delta_d; the sway is `sway`, never the speed over ground."""
    _, (a_rv, a_rr, _), _ = model.A
    r_d = reference.psi_d_dot
    delta_d = (reference.psi_d_ddot - a_rv * sway.v_d - a_rr * r_d) / model.b[1]
    return Track((sway.v - sway.v_d, psi_dot - r_d, wrap(state.eta.psi - reference.psi_d)), delta_d)


def next_sway(
    model: Linear, sway: Sway, r_d: float, delta_d: float, psi_dot: float, delta_r: float, u: float, dt: float
) -> Sway:
    """The sway row of Eq. 30, one step on.

    A current shows in the sway that a DVL measures, but not in the side force on the hull. The model's own is blind
    to it, and its error dies out with the sway row's pole, so the poles of the closed loop stay where they were placed.
    """
    (a_vv, a_vr, _), _, _ = model.A
    b_v = model.b[0]
    bound = SWAY_MAX * u
    return Sway(
        clip(sway.v_d + dt * (a_vv * sway.v_d + a_vr * r_d + b_v * delta_d), -bound, bound),
        clip(sway.v + dt * (a_vv * sway.v + a_vr * psi_dot + b_v * delta_r), -bound, bound),
    )
