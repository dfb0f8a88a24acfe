"""The equations of motion and their integration: one compiled call per step of the plant."""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from sim_bridge.plant.actuators import actuate, shaft_acceleration
from sim_bridge.plant.hydrodynamics import fins, hull
from sim_bridge.plant.packing import Array, C, S, places
from sim_bridge.plant.propulsion import propulsion, race
from sim_bridge.plant.strips import cross_flow, hydrostatics

MOTION = S.n
"""Length of the part of the state that the equations of motion move."""
W = places("k1 k2 k3 k4 trial nu_r tau wet")
"""Rows of the scratch array, shape (len(W), MOTION)."""
O = places("u_dot v_dot w_dot p_dot q_dot r_dot u_r v_r w_r phi theta psi n_dot")  # noqa: E741
"""The outputs of a step besides the state."""


@kernel("void(f8[::1],f8[::1],f8[::1])")
def rigid_body(c: Array, nu: Array, tau: Array) -> None:
    """Add -C_RB(nu) nu for a centre of gravity anywhere (Fossen 2011, Eq. 3.38, from the vectors); it does no work."""
    m, x, y, z = c[C.m], c[C.x_G], c[C.y_G], c[C.z_G]
    u, v, w, p, q, r = nu[0], nu[1], nu[2], nu[3], nu[4], nu[5]
    u_G, v_G, w_G = u + q * z - r * y, v + r * x - p * z, w + p * y - q * x
    h_x = c[C.I_x] * p - c[C.I_xy] * q - c[C.I_xz] * r
    h_y = c[C.I_y] * q - c[C.I_xy] * p - c[C.I_yz] * r
    h_z = c[C.I_z] * r - c[C.I_xz] * p - c[C.I_yz] * q
    a_x, a_y, a_z = q * w - r * v, r * u - p * w, p * v - q * u
    tau[0] -= m * (q * w_G - r * v_G)
    tau[1] -= m * (r * u_G - p * w_G)
    tau[2] -= m * (p * v_G - q * u_G)
    tau[3] -= q * h_z - r * h_y + m * (y * a_z - z * a_y)
    tau[4] -= r * h_x - p * h_z + m * (z * a_x - x * a_z)
    tau[5] -= p * h_y - q * h_x + m * (x * a_y - y * a_x)


@kernel("void(f8[::1],f8[:,::1],f8[:,::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[:,::1])")
def derivative(
    c: Array,
    table: Array,
    inverse: Array,
    current: Array,
    state: Array,
    actuators: Array,
    x_dot: Array,
    work: Array,
) -> None:
    """Compute x_dot of position, quaternion and velocity.

    In a uniform steady current the laws of motion are those of still water for an observer who drifts along
    (Galileo), so M nu_r_dot + C_RB(nu_r) nu_r = tau(nu_r) with nu_r = nu - nu_c; Fossen 2011, ch. 8, comes to the same
    for an irrotational current. Seen from the body nu_c turns, nu_c_dot = -omega x nu_c, which leads back to nu_dot.
    Turbulence changes the current from step to step; the inertia of the eddies themselves is left out.

    Args:
        c: constants.
        table: fins.
        inverse: inverse of the mass matrix, (6, 6).
        current: water velocity, NED, m/s.
        state: position, quaternion and velocity are read.
        actuators: a state whose shaft and fins are read.
        x_dot: out, (MOTION,).
        work: scratch; the relative velocity is left in row `nu_r`.
    """
    a, b, d, e = state[S.e0], state[S.e1], state[S.e2], state[S.e3]
    R_11, R_12, R_13 = a * a + b * b - d * d - e * e, 2.0 * (b * d - a * e), 2.0 * (b * e + a * d)
    R_21, R_22, R_23 = 2.0 * (b * d + a * e), a * a - b * b + d * d - e * e, 2.0 * (d * e - a * b)
    R_31, R_32, R_33 = 2.0 * (b * e - a * d), 2.0 * (d * e + a * b), a * a - b * b - d * d + e * e
    u, v, w, p, q, r = state[S.u], state[S.v], state[S.w], state[S.p], state[S.q], state[S.r]
    x_c, y_c, z_c = current[0], current[1], current[2]
    u_c = R_11 * x_c + R_21 * y_c + R_31 * z_c
    v_c = R_12 * x_c + R_22 * y_c + R_32 * z_c
    w_c = R_13 * x_c + R_23 * y_c + R_33 * z_c

    nu_r, tau, wet = work[W.nu_r], work[W.tau], work[W.wet]
    nu_r[0], nu_r[1], nu_r[2] = u - u_c, v - v_c, w - w_c
    nu_r[3], nu_r[4], nu_r[5] = p, q, r
    tau[:6] = 0.0
    n = actuators[S.n]
    delta = actuators[len(S) + len(table) :]
    depth = state[S.z] + c[C.radius]
    disc = min(max(0.5 + (depth + R_31 * c[C.x_prop] + R_33 * c[C.z_prop]) / c[C.d_prop], 0.0), 1.0)
    u_eps, abs_u_eps = race(c, nu_r[0], n, disc)

    part = hydrostatics(c, state[S.z], R_31, R_32, R_33, wet, tau)
    rigid_body(c, nu_r, tau)
    hull(c, nu_r, u_eps, abs_u_eps, part, tau)
    cross_flow(c, nu_r, wet, tau)
    fins(c, nu_r, table, delta, u_eps, depth, R_31, R_32, R_33, tau)
    propulsion(c, nu_r[0], n, disc, part, tau)

    x_dot[S.x] = R_11 * u + R_12 * v + R_13 * w
    x_dot[S.y] = R_21 * u + R_22 * v + R_23 * w
    x_dot[S.z] = R_31 * u + R_32 * v + R_33 * w
    x_dot[S.e0] = 0.5 * (-b * p - d * q - e * r)
    x_dot[S.e1] = 0.5 * (a * p + d * r - e * q)
    x_dot[S.e2] = 0.5 * (a * q + e * p - b * r)
    x_dot[S.e3] = 0.5 * (a * r + b * q - d * p)
    for i in range(6):
        total = 0.0
        for j in range(6):
            total += inverse[i, j] * tau[j]
        x_dot[S.u + i] = total
    x_dot[S.u] -= q * w_c - r * v_c
    x_dot[S.v] -= r * u_c - p * w_c
    x_dot[S.w] -= p * v_c - q * u_c


@kernel("void(f8[::1],f8[:,::1],f8[:,::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[:,::1])")
def observe(
    c: Array, table: Array, inverse: Array, current: Array, command: Array, state: Array, out: Array, work: Array
) -> None:
    """Fill `out` (see `O`) with what instruments measure at `state`."""
    x_dot = work[W.k1]
    derivative(c, table, inverse, current, state, state, x_dot, work)
    for i in range(O.u_r):
        out[i] = x_dot[S.u + i]
    for i in range(O.phi - O.u_r):
        out[O.u_r + i] = work[W.nu_r, i]
    a, b, d, e = state[S.e0], state[S.e1], state[S.e2], state[S.e3]
    out[O.phi] = math.atan2(2.0 * (d * e + a * b), a * a - b * b - d * d + e * e)
    out[O.theta] = math.asin(min(max(2.0 * (a * d - b * e), -1.0), 1.0))
    out[O.psi] = math.atan2(2.0 * (b * d + a * e), a * a + b * b - d * d - e * e)
    out[O.n_dot] = shaft_acceleration(c, state[S.n], command[len(table)])


@kernel("f8(f8[::1],f8[:,::1],f8[:,::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[:,::1],f8,i8)")
def advance(
    c: Array,
    table: Array,
    inverse: Array,
    current: Array,
    command: Array,
    state: Array,
    out: Array,
    work: Array,
    dt: float,
    substeps: int,
) -> float:
    """Advance `state` by `dt` (s) in `substeps` steps of RK4 and fill `out`; command and current are held.

    The actuators stand where they exactly are at the beginning, middle and end of each substep.

    Returns:
        0, or NaN once the state is no longer finite.
    """
    h = dt / substeps
    k1, k2, k3, k4, trial = work[W.k1], work[W.k2], work[W.k3], work[W.k4], work[W.trial]
    for _ in range(substeps):
        derivative(c, table, inverse, current, state, state, k1, work)
        actuate(c, table, command, state, 0.5 * h)
        for i in range(MOTION):
            trial[i] = state[i] + 0.5 * h * k1[i]
        derivative(c, table, inverse, current, trial, state, k2, work)
        for i in range(MOTION):
            trial[i] = state[i] + 0.5 * h * k2[i]
        derivative(c, table, inverse, current, trial, state, k3, work)
        actuate(c, table, command, state, 0.5 * h)
        for i in range(MOTION):
            trial[i] = state[i] + h * k3[i]
        derivative(c, table, inverse, current, trial, state, k4, work)
        for i in range(MOTION):
            state[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
        norm = 0.0
        for i in range(S.e0, S.u):
            norm += state[i] * state[i]
        norm = math.sqrt(norm)
        for i in range(S.e0, S.u):
            state[i] /= norm
    observe(c, table, inverse, current, command, state, out, work)
    check = 0.0
    for i in range(len(state)):
        check += state[i] * 0.0
    return check
