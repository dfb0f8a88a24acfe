"""How an error moves over one step, compiled: the slopes of the equations and the transition matrix made from them.

A coefficient acts through the force that it multiplies, one number, in one equation. (For added mass that is the
acceleration: M nu_dot = tau differentiates to it.) So the motion states answer to six forces however many coefficients
are estimated, and a coefficient's column of the transition matrix is one of the six, times its regressor.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.model.equations import CONSTANTS
from firmware_py.estimation.model.flow import cross_flow_slopes, race, race_slopes, turn
from firmware_py.estimation.model.jacobians import (
    REGRESSORS,
    buoyancy,
    kinematic_slopes,
    kinematics,
    regressors,
    slopes,
)
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.state import EQUATIONS, MOVING, WIDTH

Nine = tuple[float, float, float, float, float, float, float, float, float]
Three = tuple[float, float, float]

DRAG = len(REGRESSORS)
"""Where the regressors of cross-flow drag begin, behind the others."""
BUOYANCY = DRAG + 8
"""Where those of the buoyancy begin, in the order of the equations."""
TRIM = BUOYANCY + 6
"""Where those of x_G are, in M and N: what weight makes of it. What inertia makes of it is a fiftieth of that."""
_WEIGHT = CONSTANTS.index("W")


@kernel()
def invert(M: Matrix, inverse: Matrix) -> bool:
    """Fills the inverse of M (6, 6), which is used up; False if M has none (Gauss-Jordan, pivot by column)."""
    for i in range(6):
        for j in range(6):
            inverse[i, j] = 1.0 if i == j else 0.0
    for k in range(6):
        best = k
        for i in range(k + 1, 6):
            if abs(M[i, k]) > abs(M[best, k]):
                best = i
        if not 0.0 < abs(M[best, k]) < math.inf:
            return False
        for j in range(6):
            M[k, j], M[best, j] = M[best, j], M[k, j]
            inverse[k, j], inverse[best, j] = inverse[best, j], inverse[k, j]
        scale = 1.0 / M[k, k]
        for j in range(6):
            M[k, j] *= scale
            inverse[k, j] *= scale
        for i in range(6):
            factor = M[i, k]
            if i != k and factor != 0.0:
                for j in range(6):
                    M[i, j] -= factor * M[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return True


@kernel()
def linearise(model: Model, inputs: Vector, x: Nine, x_dot: Nine, water: Three, step: Linearisation) -> None:
    """Fills A, the slopes of `rates` at x by motion and water velocity, and the regressors there.

    Args:
        model: its constants and inverse mass matrix are used.
        inputs: delta_s, delta_r, delta_b (rad), n (rev/s).
        x: the nine motion states.
        x_dot: their rates.
        water: its velocity north, east, down, m/s.
        step: out: A and the regressors; B and D are scratch.
    """
    c, inverse_mass = model.constants, model.inverse_mass
    A, B, D = step.A, step.B, step.D
    u, v, w, p, q, r, phi, theta, psi = x
    t = turn(phi, theta, psi)
    u_c, v_c, w_c, u_turn, v_turn, w_turn, _, _, _ = kinematics(p, q, r, *t, *water)
    u, v, w = u - u_c, v - v_c, w - w_c
    ds, dr, db, n = inputs[0], inputs[1], inputs[2], inputs[3]
    s, e, jet = race(c, u, n)
    s_u, e_u, _, _ = race_slopes(c, u, n)
    u_dot, v_dot, w_dot, p_dot, q_dot, r_dot, _, _, _ = x_dot
    u_dot, v_dot, w_dot = u_dot - u_turn, v_dot - v_turn, w_dot - w_turn
    regressors(c, u, v, w, p, q, r, u_dot, v_dot, w_dot, p_dot, q_dot, r_dot, ds, dr, db, s, e, jet, step.regressors)

    for i in range(EQUATIONS):
        for j in range(WIDTH):
            D[i, j] = 0.0
    slopes(c, u, v, w, p, q, r, t[0], t[1], t[2], t[3], ds, dr, db, s, e, s_u, e_u, D)
    cross_flow_slopes(c, v, w, q, r, D, step.regressors, DRAG)
    lift = buoyancy(c, t[0], t[1], t[2], t[3])
    for i in range(EQUATIONS):
        step.regressors[BUOYANCY + i] = lift[i]
    step.regressors[TRIM] = -c[_WEIGHT] * t[1] * t[3]
    step.regressors[TRIM + 1] = c[_WEIGHT] * t[0] * t[3]
    for i in range(MOVING):
        for j in range(WIDTH):
            A[i, j] = 0.0
    for i in range(3):
        for j in range(WIDTH):
            B[i, j] = 0.0
    kinematic_slopes(p, q, r, *t, *water, A, B)
    for i in range(EQUATIONS):
        d_0, d_1, d_2 = D[i, 0], D[i, 1], D[i, 2]
        for j in range(WIDTH):
            D[i, j] -= d_0 * B[0, j] + d_1 * B[1, j] + d_2 * B[2, j]
    for i in range(EQUATIONS):
        m_0, m_1, m_2 = inverse_mass[i, 0], inverse_mass[i, 1], inverse_mass[i, 2]
        m_3, m_4, m_5 = inverse_mass[i, 3], inverse_mass[i, 4], inverse_mass[i, 5]
        for j in range(WIDTH):
            A[i, j] += m_0 * D[0, j] + m_1 * D[1, j] + m_2 * D[2, j] + m_3 * D[3, j] + m_4 * D[4, j] + m_5 * D[5, j]


@kernel()
def product(X: Matrix, h: float, Y: Matrix, Z: Matrix) -> None:
    """Z = h X Y, all (9, WIDTH), X nine columns wide. The sum is written out, so that it compiles to vectors."""
    for i in range(MOVING):
        x_0, x_1, x_2, x_3, x_4 = h * X[i, 0], h * X[i, 1], h * X[i, 2], h * X[i, 3], h * X[i, 4]
        x_5, x_6, x_7, x_8 = h * X[i, 5], h * X[i, 6], h * X[i, 7], h * X[i, 8]
        for j in range(WIDTH):
            Z[i, j] = (
                x_0 * Y[0, j]
                + x_1 * Y[1, j]
                + x_2 * Y[2, j]
                + x_3 * Y[3, j]
                + x_4 * Y[4, j]
                + x_5 * Y[5, j]
                + x_6 * Y[6, j]
                + x_7 * Y[7, j]
                + x_8 * Y[8, j]
            )


@kernel()
def transition(model: Model, h: float, step: Linearisation) -> None:
    """Fills Phi = exp(A h) to third order, and the response to forces that are held over the step h (s).

    With the series E = 1 + A h/2 + A^2 h^2/6 they are Phi = 1 + h E A and the response = h E M^-1.
    """
    A, E, Phi, response, inverse_mass = step.A, step.series, step.Phi, step.response, model.inverse_mass
    product(A, h * h / 6.0, A, Phi)
    for i in range(MOVING):
        for j in range(MOVING):
            E[i, j] = h / 2.0 * A[i, j] + Phi[i, j]
        E[i, i] += 1.0
    product(E, h, A, Phi)
    for i in range(MOVING):
        Phi[i, i] += 1.0
        e_0, e_1, e_2, e_3, e_4, e_5 = h * E[i, 0], h * E[i, 1], h * E[i, 2], h * E[i, 3], h * E[i, 4], h * E[i, 5]
        for j in range(EQUATIONS):
            response[i, j] = (
                e_0 * inverse_mass[0, j]
                + e_1 * inverse_mass[1, j]
                + e_2 * inverse_mass[2, j]
                + e_3 * inverse_mass[3, j]
                + e_4 * inverse_mass[4, j]
                + e_5 * inverse_mass[5, j]
            )
