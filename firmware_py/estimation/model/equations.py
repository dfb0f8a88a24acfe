"""The equations of motion of the believed vehicle, as equations: the same lines take floats and sympy's symbols.

Healey and Lienard (1993) with the errata of the paper's Eq. 1: six equations M nu_r_dot = tau, in the velocity relative
to the water, and the rates of the Euler angles. `sternplane.codegen.derive_jacobians` derives every kernel of
`jacobians.py` from them; nothing here runs in flight.

Every hydrodynamic term is one coefficient times one product of motions and fin angles, so the forces are linear in all
coefficients, added mass included. With rates made velocities by L (p' = L p) each product is in m^2/s^2 and each
equation has one scale: rho/2 L^2 for forces, rho/2 L^3 for moments.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any, NamedTuple

from firmware_py.vehicle.coefficients import Coefficients

Number = Any
"""A float, or an expression of sympy."""
Triple = tuple[Number, Number, Number]
Six = tuple[Number, Number, Number, Number, Number, Number]

AXES = "XYZKMN"
BODY = ("m", "I_x", "I_y", "I_z", "I_xy", "I_yz", "I_xz", "x_G", "y_G", "z_G", "x_B", "y_B", "z_B", "W", "B")
HULL = ("scale", "L", "h_y", "h_z", "advance", "k_race", "knee")
"""rho/2 L^2; L; height and width of the section over L^2; m/s of u_n per rev/s; C_t1; sqrt(C_t1 + 1) - 1."""
COEFFICIENTS = (*(field.name for field in fields(Coefficients)), "C_d0", "C_dy", "C_dz")
"""Whatever the forces are linear in, and so whatever can be estimated."""
CONSTANTS = (*BODY, *HULL, *COEFFICIENTS)
"""What a vehicle is to the kernels: one vector, in this order."""


class Motion(NamedTuple):
    """A velocity (m/s, rad/s) or an acceleration."""

    u: Number
    v: Number
    w: Number
    p: Number
    q: Number
    r: Number


class Fins(NamedTuple):
    """Sums of fin angles, rad: stern planes, rudders, and bow planes (the sum over both sides)."""

    delta_s: Number
    delta_r: Number
    delta_b: Number


class Race(NamedTuple):
    """What bends at u = 0 or n = 0. Published for motion ahead; direct damping takes |u| so that it damps astern too.

    `s` = |u|; `e` = u eps(n), what the race adds at the fins; `jet` = u_n |u_n|, u_n = advance n being where eta = 1.
    """

    s: Number
    e: Number
    jet: Number


class Turn(NamedTuple):
    """Sines and cosines of the Euler angles, and 1 / cos(theta)."""

    s_phi: Number
    c_phi: Number
    s_theta: Number
    c_theta: Number
    s_psi: Number
    c_psi: Number
    sec: Number


def cross(a: Triple, b: Triple) -> Triple:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def total(*vectors: Triple) -> Triple:
    """The sum of vectors."""
    x, y, z = (sum(parts) for parts in zip(*vectors, strict=True))
    return x, y, z


def inertia(nu: Motion, nu_dot: Motion, c: Any) -> Six:
    """M_RB nu_dot + C_RB(nu) nu (N, N m): Newton and Euler about the origin, the centre of gravity anywhere."""
    velocity, omega, r_G = nu[:3], nu[3:], (c.x_G, c.y_G, c.z_G)
    v_dot, omega_dot = nu_dot[:3], nu_dot[3:]

    def angular(a: Triple) -> Triple:
        p, q, r = a
        return (
            c.I_x * p - c.I_xy * q - c.I_xz * r,
            c.I_y * q - c.I_xy * p - c.I_yz * r,
            c.I_z * r - c.I_xz * p - c.I_yz * q,
        )

    origin = total(v_dot, cross(omega, velocity))
    centre = total(origin, cross(omega_dot, r_G), cross(omega, cross(omega, r_G)))
    x, y, z = (c.m * a for a in centre)
    k, m, n = total(angular(omega_dot), cross(omega, angular(omega)), tuple(c.m * a for a in cross(r_G, origin)))
    return x, y, z, k, m, n


def restoring(turn: Turn, c: Any) -> Six:
    """Weight and buoyancy (N, N m), fully under water."""
    down = (-turn.s_theta, turn.s_phi * turn.c_theta, turn.c_phi * turn.c_theta)
    lever = (c.x_G * c.W - c.x_B * c.B, c.y_G * c.W - c.y_B * c.B, c.z_G * c.W - c.z_B * c.B)
    x, y, z = ((c.W - c.B) * k for k in down)
    return (x, y, z, *cross(lever, down))


def terms(nu: Motion, nu_dot: Motion, fins: Fins, race: Race, c: Any) -> dict[str, Number]:
    """What each coefficient multiplies, m^2/s^2; cross-flow drag, an integral, is in `strip`."""
    u, v, w = nu[:3]
    p, q, r = (c.L * rate for rate in nu[3:])
    u_dot, v_dot, w_dot = (c.L * a for a in nu_dot[:3])
    p_dot, q_dot, r_dot = (c.L**2 * a for a in nu_dot[3:])
    ds, dr, db = fins
    s, e, jet = race
    # fmt: off
    return {
        "X_pp": p * p, "X_qq": q * q, "X_rr": r * r, "X_pr": p * r, "X_udot": u_dot, "X_wq": w * q,
        "X_vp": v * p, "X_vr": v * r, "X_vv": v * v, "X_ww": w * w, "C_d0": jet - s * u,
        "X_qds": u * q * ds, "X_wds": u * w * ds, "X_dsds": s * u * ds * ds,
        "X_rdr": u * r * dr, "X_vdr": u * v * dr, "X_drdr": s * u * dr * dr,
        "X_qdb": u * q * db, "X_wdb": u * w * db,
        "X_qdsn": e * q * ds, "X_wdsn": e * w * ds, "X_dsdsn": s * e * ds * ds,
        "Y_pdot": p_dot, "Y_rdot": r_dot, "Y_vdot": v_dot, "Y_pq": p * q, "Y_qr": q * r,
        "Y_p": u * p, "Y_r": u * r, "Y_v": s * v, "Y_vq": v * q, "Y_wp": w * p, "Y_wr": w * r, "Y_vw": v * w,
        "Y_dr": s * u * dr,
        "Z_qdot": q_dot, "Z_wdot": w_dot, "Z_pp": p * p, "Z_pr": p * r, "Z_rr": r * r,
        "Z_q": u * q, "Z_w": s * w, "Z_vp": v * p, "Z_vr": v * r, "Z_vv": v * v,
        "Z_ds": s * u * ds, "Z_db": s * u * db, "Z_qn": e * q, "Z_wn": e * w, "Z_dsn": s * e * ds,
        "K_pdot": p_dot, "K_rdot": r_dot, "K_vdot": v_dot, "K_pq": p * q, "K_qr": q * r,
        "K_p": s * p, "K_r": u * r, "K_v": u * v, "K_vq": v * q, "K_wp": w * p, "K_wr": w * r, "K_vw": v * w,
        "K_pn": e * p, "K_prop": s * u,
        "M_qdot": q_dot, "M_wdot": w_dot, "M_pp": p * p, "M_pr": p * r, "M_rr": r * r,
        "M_q": s * q, "M_w": u * w, "M_vp": v * p, "M_vr": v * r, "M_vv": v * v,
        "M_ds": s * u * ds, "M_db": s * u * db, "M_qn": e * q, "M_wn": e * w, "M_dsn": s * e * ds,
        "N_pdot": p_dot, "N_rdot": r_dot, "N_vdot": v_dot, "N_pq": p * q, "N_qr": q * r,
        "N_p": u * p, "N_r": s * r, "N_v": u * v, "N_vq": v * q, "N_wp": w * p, "N_wr": w * r, "N_vw": v * w,
        "N_dr": s * u * dr, "N_prop": s * u,
    }
    # fmt: on


def strip(v: Number, w: Number, speed: Number, c: Any) -> tuple[tuple[Number, Number], tuple[Number, Number]]:
    """What C_dy and C_dz multiply in the cross-flow drag (Y, Z) of a strip, over `scale` and the strip's length.

    The strip at x meets the flow v = v + x r, w = w - x q; `speed` = sqrt(v^2 + w^2). The drag opposes the flow.
    """
    along_v, along_w = -c.h_y * v * v / speed, -c.h_z * w * w / speed
    return (along_v * v, along_v * w), (along_w * v, along_w * w)


def water(turn: Turn, x_c: Number, y_c: Number, z_c: Number) -> Triple:
    """The velocity of the water (x_c, y_c, z_c), m/s north, east and down, in body axes."""
    s_phi, c_phi, s_theta, c_theta, s_psi, c_psi, _ = turn
    ahead, across = c_psi * x_c + s_psi * y_c, c_psi * y_c - s_psi * x_c
    return (
        c_theta * ahead - s_theta * z_c,
        s_phi * (s_theta * ahead + c_theta * z_c) + c_phi * across,
        c_phi * (s_theta * ahead + c_theta * z_c) - s_phi * across,
    )


def euler_rates(turn: Turn, p: Number, q: Number, r: Number) -> Triple:
    """phi_dot, theta_dot, psi_dot from body rates (Fossen 2011, Eq. 2.28)."""
    lateral = q * turn.s_phi + r * turn.c_phi
    return p + lateral * turn.s_theta * turn.sec, q * turn.c_phi - r * turn.s_phi, lateral * turn.sec
