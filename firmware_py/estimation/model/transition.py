"""How an error moves over one step, compiled: the slopes of the equations and the transition matrix made from them.

A coefficient acts through the force that it multiplies, one number, in one equation. (For added mass that is the
acceleration: M nu_dot = tau differentiates to it.) So the moving states answer to six forces however many coefficients
are estimated, and a coefficient's column of the transition matrix is one of the six, times its force.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firmware_py.compiled import kernel
from firmware_py.estimation.model.flow import cross_flow_slopes, race, race_slopes, turn
from firmware_py.estimation.model.jacobians import FACTORS, Array, factors, kinematic_slopes, kinematics, slopes

Nine = tuple[float, float, float, float, float, float, float, float, float]
Three = tuple[float, float, float]
Picks = NDArray[np.int64]

MOVING = 9
"""Velocities and angles, the states that move by themselves."""
DRAG = len(FACTORS)
"""Where the factors of cross-flow drag begin, behind the others."""
WIDTH = 16
"""Columns of such arrays, whole vectors: nine moving states, three of the water's velocity."""
WATER = 9
"""Where the water's columns begin."""


@kernel("b1(f8[:,::1],f8[:,::1])")
def invert(M: Array, inverse: Array) -> bool:
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


@kernel(
    "void(f8[::1],f8[:,::1],f8[::1],UniTuple(f8,9),UniTuple(f8,9),UniTuple(f8,3),f8[:,::1],f8[:,::1],f8[:,::1],f8[::1])"
)
def linearise(
    c: Array,
    inverse: Array,
    inputs: Array,
    x: Nine,
    x_dot: Nine,
    water: Three,
    A: Array,
    D: Array,
    B: Array,
    y: Array,
) -> None:
    """The slopes of `rates` at x, where it is x_dot.

    Args:
        c: constants.
        inverse: inverse of the mass matrix.
        inputs: as everywhere.
        x: the nine moving states; `x_dot` their rates.
        water: its velocity north, east, down, m/s.
        A: out, (9, WIDTH): by the moving states and the water.
        D: scratch, (6, WIDTH). `B` too, (3, WIDTH).
        y: out, (DRAG + 8,): the force that each coefficient multiplies; its slope is M^-1's column of its equation.
    """
    u, v, w, p, q, r, phi, theta, psi = x
    t = turn(phi, theta, psi)
    u_c, v_c, w_c, u_turn, v_turn, w_turn, _, _, _ = kinematics(p, q, r, *t, *water)
    u, v, w = u - u_c, v - v_c, w - w_c
    ds, dr, db, n = inputs[0], inputs[1], inputs[2], inputs[3]
    s, e, jet = race(c, u, n)
    s_u, e_u, _, _ = race_slopes(c, u, n)
    u_dot, v_dot, w_dot = x_dot[0] - u_turn, x_dot[1] - v_turn, x_dot[2] - w_turn
    factors(c, u, v, w, p, q, r, u_dot, v_dot, w_dot, x_dot[3], x_dot[4], x_dot[5], ds, dr, db, s, e, jet, y)

    for i in range(6):
        for j in range(WIDTH):
            D[i, j] = 0.0
    slopes(c, u, v, w, p, q, r, t[0], t[1], t[2], t[3], ds, dr, db, s, e, s_u, e_u, D)
    cross_flow_slopes(c, v, w, q, r, D, y, DRAG)
    for i in range(9):
        for j in range(WIDTH):
            A[i, j] = 0.0
    for i in range(3):
        for j in range(WIDTH):
            B[i, j] = 0.0
    kinematic_slopes(p, q, r, *t, *water, A, B)
    for i in range(6):
        d_0, d_1, d_2 = D[i, 0], D[i, 1], D[i, 2]
        for j in range(WIDTH):
            D[i, j] -= d_0 * B[0, j] + d_1 * B[1, j] + d_2 * B[2, j]
    for i in range(6):
        m_0, m_1, m_2 = inverse[i, 0], inverse[i, 1], inverse[i, 2]
        m_3, m_4, m_5 = inverse[i, 3], inverse[i, 4], inverse[i, 5]
        for j in range(WIDTH):
            A[i, j] += m_0 * D[0, j] + m_1 * D[1, j] + m_2 * D[2, j] + m_3 * D[3, j] + m_4 * D[4, j] + m_5 * D[5, j]


@kernel("void(f8[:,::1],f8,f8[:,::1],f8[:,::1])")
def product(X: Array, h: float, Y: Array, Z: Array) -> None:
    """Z = h X Y, all (9, WIDTH), X counting nine columns wide. The sum is written out: so it compiles to vectors."""
    for i in range(9):
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


@kernel("void(f8[:,::1],f8,f8[:,::1],f8[:,::1],f8[:,::1],f8[:,::1])")
def transition(inverse: Array, h: float, A: Array, G: Array, Phi: Array, response: Array) -> None:
    """Phi, the exponential of the slopes over a step h (s) to third order: G = 1 + A h/2 + A^2 h^2/6, Phi = 1 + h G A.

    Args:
        inverse: inverse of the mass matrix.
        h: step, s.
        A: from `linearise`.
        G: scratch, (9, WIDTH).
        Phi: out, (9, WIDTH): by the moving states and the water.
        response: out, (9, WIDTH): six columns, by a force in each equation, held over the step, N or N m.
    """
    product(A, h * h / 6.0, A, Phi)
    for i in range(9):
        for j in range(9):
            G[i, j] = h / 2.0 * A[i, j] + Phi[i, j]
        G[i, i] += 1.0
    product(G, h, A, Phi)
    for i in range(9):
        Phi[i, i] += 1.0
        g_0, g_1, g_2, g_3, g_4, g_5 = h * G[i, 0], h * G[i, 1], h * G[i, 2], h * G[i, 3], h * G[i, 4], h * G[i, 5]
        for j in range(6):
            response[i, j] = (
                g_0 * inverse[0, j]
                + g_1 * inverse[1, j]
                + g_2 * inverse[2, j]
                + g_3 * inverse[3, j]
                + g_4 * inverse[4, j]
                + g_5 * inverse[5, j]
            )
