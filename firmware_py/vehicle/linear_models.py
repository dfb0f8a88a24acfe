"""The linear models the laws are designed from: diving and steering about straight and level flight at speed u.

Both are the paper's, with the errata of its print put right: the coefficients on the left-hand sides of Eq. 26 and
Eq. 30 are added mass (dotted), and the term of Y_dr in Eq. 30 carries L^2, as a force does.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.params import ParamError
from firmware_py.vehicle.vehicle import Vehicle

Row = tuple[float, float, float]


class Linear(NamedTuple):
    """x_dot = A x + b delta for three states and one input, as plain floats."""

    A: tuple[Row, Row, Row]
    b: Row


def diving(vehicle: Vehicle, u: float) -> Linear:
    """Diving at speed u, m/s: x = (q, theta, z) in rad/s, rad, m and the input delta_s in rad (paper Eq. 26).

    Raises:
        ParamError: the added moment of inertia leaves none.
    """
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    L = hull.length
    half = 0.5 * hull.density * L**3
    inertia = body.I_y - half * L**2 * c.M_qdot
    if not inertia > 0.0:
        raise ParamError(f"coefficients: M_qdot = {c.M_qdot:g} leaves no inertia in pitch; it should be negative")
    damping = half * L * u * c.M_q
    restoring = -(body.z_G - body.z_B) * body.weight
    control = half * u * u * c.M_ds
    return Linear(
        ((damping / inertia, restoring / inertia, 0.0), (1.0, 0.0, 0.0), (0.0, -u, 0.0)),
        (control / inertia, 0.0, 0.0),
    )


def steering(vehicle: Vehicle, u: float) -> Linear:
    """Steering at speed u, m/s: x = (v, r, psi) in m/s, rad/s, rad and the input delta_r in rad (paper Eq. 30).

    Raises:
        ParamError: the added mass leaves none.
    """
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    L = hull.length
    half = 0.5 * hull.density * L**2
    m_vv = body.mass - half * L * c.Y_vdot
    m_vr = -half * L**2 * c.Y_rdot
    m_rv = -half * L**2 * c.N_vdot
    m_rr = body.I_z - half * L**3 * c.N_rdot
    det = m_vv * m_rr - m_vr * m_rv
    if not (m_vv > 0.0 and det > 0.0):
        raise ParamError(
            "coefficients: Y_vdot, Y_rdot, N_vdot, N_rdot leave no inertia; Y_vdot, N_rdot should be negative"
        )

    def solve(force: float, moment: float) -> tuple[float, float]:
        return (m_rr * force - m_vr * moment) / det, (m_vv * moment - m_rv * force) / det

    a_vv, a_rv = solve(half * u * c.Y_v, half * L * u * c.N_v)
    a_vr, a_rr = solve(half * L * u * c.Y_r - body.mass * u, half * L**2 * u * c.N_r)
    b_v, b_r = solve(half * u * u * c.Y_dr, half * L * u * u * c.N_dr)
    return Linear(((a_vv, a_vr, 0.0), (a_rv, a_rr, 0.0), (0.0, 1.0, 0.0)), (b_v, b_r, 0.0))
