"""Linear models of diving and steering, about straight and level motion at speed u. The laws are designed from them.

Both are the paper's, with two errors of its print corrected: the coefficients on the left-hand sides of Eq. 26 and
Eq. 30 are added mass (dotted), and the term of Y_dr in Eq. 30 contains L^2, as a force does.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

Vector3 = tuple[float, float, float]


class DivingCoefficients(NamedTuple):
    """What the diving model (Eq. 26) is made of beyond hull, body and added mass."""

    M_q: float
    M_ds: float


class SteeringCoefficients(NamedTuple):
    """What the steering model (Eq. 30) is made of beyond these."""

    Y_v: float
    Y_r: float
    Y_dr: float
    N_v: float
    N_r: float
    N_dr: float


class LinearModel(NamedTuple):
    """x_dot = A x + b delta: A has shape (3, 3), b shape (3,), delta is one fin angle, rad. Plain floats."""

    A: tuple[Vector3, Vector3, Vector3]
    b: Vector3

    @property
    def righting(self) -> float:
        """Return what turns the hull back at any speed, 1/s^2: -A[0][1] where the second state is its angle."""
        (_, restoring, _), second, _ = self.A
        return max(0.0, -restoring) if second == (1.0, 0.0, 0.0) else 0.0


def diving_coefficients(vehicle: Vehicle) -> DivingCoefficients:
    """Return the coefficients of the diving model as vehicle.toml has them."""
    c = vehicle.coefficients
    return DivingCoefficients(c.M_q, c.M_ds)


def steering_coefficients(vehicle: Vehicle) -> SteeringCoefficients:
    """Return the coefficients of the steering model as vehicle.toml has them."""
    c = vehicle.coefficients
    return SteeringCoefficients(c.Y_v, c.Y_r, c.Y_dr, c.N_v, c.N_r, c.N_dr)


def diving_model(vehicle: Vehicle, u: float, other: DivingCoefficients | None = None) -> LinearModel:
    """Return the diving model at speed u, m/s (paper Eq. 26), with `other` coefficients than those of the vehicle.

    x = (q, theta, z) in rad/s, rad, m; the input is delta_s, rad, positive bow down (M_ds < 0); z_dot = -u theta.

    Raises:
        ParamError: I_y minus the added moment of inertia is not positive.
    """
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    L = hull.length
    scale = 0.5 * hull.density * L**3
    inertia = body.I_y - scale * L**2 * c.M_qdot
    if not inertia > 0.0:
        raise ParamError(f"coefficients: M_qdot = {c.M_qdot:g} leaves no inertia in pitch; it should be negative")
    M_q, M_ds = other or (c.M_q, c.M_ds)
    damping = scale * L * u * M_q
    restoring = -(body.z_G - body.z_B) * body.weight
    control = scale * u * u * M_ds
    return LinearModel(
        ((damping / inertia, restoring / inertia, 0.0), (1.0, 0.0, 0.0), (0.0, -u, 0.0)),
        (control / inertia, 0.0, 0.0),
    )


def steering_model(vehicle: Vehicle, u: float, other: SteeringCoefficients | None = None) -> LinearModel:
    """Return the steering model at speed u, m/s (paper Eq. 30), with `other` coefficients than those of the vehicle.

    x = (v, r, psi) in m/s, rad/s, rad; the input is delta_r, rad, positive to port (N_dr < 0); psi_dot = r.

    Raises:
        ParamError: the inertia matrix of sway and yaw, added mass included, is not positive definite.
    """
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    L = hull.length
    scale = 0.5 * hull.density * L**2
    m_vv = body.mass - scale * L * c.Y_vdot
    m_vr = -scale * L**2 * c.Y_rdot
    m_rv = -scale * L**2 * c.N_vdot
    m_rr = body.I_z - scale * L**3 * c.N_rdot
    det = m_vv * m_rr - m_vr * m_rv
    if not (m_vv > 0.0 and det > 0.0):
        raise ParamError(
            "coefficients: Y_vdot, Y_rdot, N_vdot, N_rdot leave no inertia; Y_vdot, N_rdot should be negative"
        )

    def accelerations(force: float, moment: float) -> tuple[float, float]:
        """Return (v_dot, r_dot) under a sway force, N, and a yaw moment, N m."""
        return (m_rr * force - m_vr * moment) / det, (m_vv * moment - m_rv * force) / det

    Y_v, Y_r, Y_dr, N_v, N_r, N_dr = other or steering_coefficients(vehicle)
    a_vv, a_rv = accelerations(scale * u * Y_v, scale * L * u * N_v)
    a_vr, a_rr = accelerations(scale * L * u * Y_r - body.mass * u, scale * L**2 * u * N_r)
    b_v, b_r = accelerations(scale * u * u * Y_dr, scale * L * u * u * N_dr)
    return LinearModel(((a_vv, a_vr, 0.0), (a_rv, a_rr, 0.0), (0.0, 1.0, 0.0)), (b_v, b_r, 0.0))
