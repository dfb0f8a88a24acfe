"""What the equations leave open: sines, the race where it bends, and the cross-flow drag, an integral along the hull.

The race is the published one (Healey and Lienard 1993) ahead, where eta = u_n / u, C_t = C_t1 eta|eta| and
eps(n) = (sqrt(1 + C_t) - 1) / (sqrt(1 + C_t1) - 1) - 1: with u_s = sqrt(u^2 + C_t1 u_n|u_n|) the product
u eps(n) = (u_s - u) / knee - u needs no division by u.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Matrix, Vector, kernel
from firmware_py.estimation.model.equations import CONSTANTS
from firmware_py.estimation.model.jacobians import strip, strip_slopes

SCALE, LENGTH, ADVANCE, K_RACE, KNEE = (CONSTANTS.index(name) for name in ("scale", "L", "advance", "k_race", "knee"))
U_S_MIN = 0.01
"""Slopes of the race, m/s: it is taken to be no slower, or they would grow without bound about rest."""
COS_MIN = 0.01
"""cos(theta) is kept at least so large, so that a pass through the vertical stays finite."""
NODES = (0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845, 0.9739065285171717)
WEIGHTS = (0.2955242247147529, 0.2692667193099964, 0.2190863625159820, 0.1494513491505806, 0.0666713443086881)
"""Gauss-Legendre, ten points, either side of amidships (Abramowitz and Stegun, Table 25.4)."""
STATIONS = len(NODES)
SWAY, HEAVE, PITCH, YAW = 1, 2, 4, 5
"""Of u v w p q r, and of the equations X Y Z K M N: those that flow across the hull acts on."""


@kernel()
def turn(phi: float, theta: float, psi: float) -> tuple[float, float, float, float, float, float, float]:
    """The sines and cosines of `equations.Turn`."""
    c_theta = math.cos(theta)
    sec = 1.0 / math.copysign(max(abs(c_theta), COS_MIN), c_theta)
    return math.sin(phi), math.cos(phi), math.sin(theta), c_theta, math.sin(psi), math.cos(psi), sec


@kernel()
def behind_disc(c: Vector, u: float, u_n: float) -> float:
    """u_s, m/s, signed."""
    square = u * abs(u) + c[K_RACE] * u_n * abs(u_n)
    return math.copysign(math.sqrt(abs(square)), square)


@kernel()
def race(c: Vector, u: float, n: float) -> tuple[float, float, float]:
    """`equations.Race` at water speed u (m/s) and shaft speed n (rev/s)."""
    u_n = c[ADVANCE] * n
    return abs(u), (behind_disc(c, u, u_n) - u) / c[KNEE] - u, u_n * abs(u_n)


@kernel()
def race_slopes(c: Vector, u: float, n: float) -> tuple[float, float, float, float]:
    """The slopes of `race`: of s and e by u, of e and jet by n."""
    u_n = c[ADVANCE] * n
    u_s = max(abs(behind_disc(c, u, u_n)), U_S_MIN)
    jet_n = 2.0 * abs(u_n) * c[ADVANCE]
    e_u = (abs(u) / u_s - 1.0) / c[KNEE] - 1.0
    return math.copysign(1.0, u), e_u, 0.5 * c[K_RACE] * jet_n / (u_s * c[KNEE]), jet_n


@kernel()
def cross_flow(c: Vector, v: float, w: float, q: float, r: float) -> tuple[float, float, float, float]:
    """(Y, Z, M, N) of the drag across the hull, N and N m."""
    half = 0.5 * c[LENGTH]
    Y, Z, M, N = 0.0, 0.0, 0.0, 0.0
    for i in range(STATIONS):
        for side in (-1.0, 1.0):
            x = side * NODES[i] * half
            across, down = v + x * r, w - x * q
            speed = math.sqrt(across * across + down * down)
            if speed > 0.0:
                y, z = strip(c, across, down, speed)
                Y += WEIGHTS[i] * y
                Z += WEIGHTS[i] * z
                M -= WEIGHTS[i] * x * z
                N += WEIGHTS[i] * x * y
    size = c[SCALE] * half
    return size * Y, size * Z, size * M, size * N


@kernel()
def cross_flow_slopes(c: Vector, v: float, w: float, q: float, r: float, D: Matrix, y: Vector, first: int) -> None:
    """Adds the slopes of `cross_flow` to those of the forces, and fills what C_dy and C_dz multiply.

    Args:
        c: constants.
        v: velocity through the water; `w`, `q`, `r` likewise.
        D: rows X Y Z K M N, columns u v w p q r: added to.
        y: out, from place `first`: Y Z M N of C_dy = 1, then of C_dz = 1.
        first: see `y`.
    """
    half = 0.5 * c[LENGTH]
    size = c[SCALE] * half
    y_Y, y_Z, y_M, y_N, z_Y, z_Z, z_M, z_N = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    Y_v, Y_w, Z_v, Z_w = 0.0, 0.0, 0.0, 0.0
    Y_vx, Y_wx, Z_vx, Z_wx = 0.0, 0.0, 0.0, 0.0
    Y_vxx, Y_wxx, Z_vxx, Z_wxx = 0.0, 0.0, 0.0, 0.0
    for i in range(STATIONS):
        for side in (-1.0, 1.0):
            x = side * NODES[i] * half
            across, down = v + x * r, w - x * q
            speed = math.sqrt(across * across + down * down)
            if speed > 0.0:
                k = size * WEIGHTS[i]
                kx, kxx = k * x, k * x * x
                a_Y, a_Z, b_Y, b_Z, a, b, d, e = strip_slopes(c, across, down, speed)
                y_Y, y_Z, y_M, y_N = y_Y + k * a_Y, y_Z + k * a_Z, y_M - kx * a_Z, y_N + kx * a_Y
                z_Y, z_Z, z_M, z_N = z_Y + k * b_Y, z_Z + k * b_Z, z_M - kx * b_Z, z_N + kx * b_Y
                Y_v, Y_w, Z_v, Z_w = Y_v + k * a, Y_w + k * b, Z_v + k * d, Z_w + k * e
                Y_vx, Y_wx, Z_vx, Z_wx = Y_vx + kx * a, Y_wx + kx * b, Z_vx + kx * d, Z_wx + kx * e
                Y_vxx, Y_wxx, Z_vxx, Z_wxx = Y_vxx + kxx * a, Y_wxx + kxx * b, Z_vxx + kxx * d, Z_wxx + kxx * e
    y[first], y[first + 1], y[first + 2], y[first + 3] = y_Y, y_Z, y_M, y_N
    y[first + 4], y[first + 5], y[first + 6], y[first + 7] = z_Y, z_Z, z_M, z_N
    D[SWAY, SWAY] += Y_v
    D[SWAY, HEAVE] += Y_w
    D[SWAY, PITCH] -= Y_wx
    D[SWAY, YAW] += Y_vx
    D[HEAVE, SWAY] += Z_v
    D[HEAVE, HEAVE] += Z_w
    D[HEAVE, PITCH] -= Z_wx
    D[HEAVE, YAW] += Z_vx
    D[PITCH, SWAY] -= Z_vx
    D[PITCH, HEAVE] -= Z_wx
    D[PITCH, PITCH] += Z_wxx
    D[PITCH, YAW] -= Z_vxx
    D[YAW, SWAY] += Y_vx
    D[YAW, HEAVE] += Y_wx
    D[YAW, PITCH] -= Y_wxx
    D[YAW, YAW] += Y_vxx
