"""Integrals along the hull, by the ten-point Gauss-Legendre rule (Abramowitz and Stegun, Table 25.4)."""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from sim_bridge.plant.packing import Array, C

NODES = (
    -0.9739065285171717,
    -0.8650633666889845,
    -0.6794095682990244,
    -0.4333953941292472,
    -0.14887433898163122,
    0.14887433898163122,
    0.4333953941292472,
    0.6794095682990244,
    0.8650633666889845,
    0.9739065285171717,
)
"""Abscissae on [-1, 1]."""
WEIGHTS = (
    0.06667134430868814,
    0.1494513491505806,
    0.21908636251598204,
    0.26926671930999635,
    0.29552422471475287,
    0.29552422471475287,
    0.26926671930999635,
    0.21908636251598204,
    0.1494513491505806,
    0.06667134430868814,
)
"""Weights on [-1, 1]; they sum to 2."""
STRIPS = len(NODES)


@kernel("f8(f8)")
def immersed(s: float) -> float:
    """Return the part of a circle that is under water when its centre is `s` radii below the surface."""
    if s >= 1.0:
        return 1.0
    if s <= -1.0:
        return 0.0
    return 0.5 + (s * math.sqrt(1.0 - s * s) + math.asin(s)) / math.pi


@kernel("f8(f8[::1],f8,f8,f8,f8,f8[::1],f8[::1])")
def hydrostatics(c: Array, z: float, k_x: float, k_y: float, k_z: float, wet: Array, tau: Array) -> float:
    """Add weight and buoyancy to `tau` and return the immersed part of the hull.

    The surface lies one hull radius above the frame's z = 0: a level vehicle at z = 0 is just fully immersed,
    so that depth counts from the floating vehicle, as of a depth sensor zeroed at the surface. Each strip's buoyancy
    goes with its immersed volume and acts through its axis, as pressure on a circle must; it therefore has a potential.

    Args:
        c: constants.
        z: depth of the origin, m.
        k_x: first component of the downward unit vector in the body frame; `k_y` and `k_z` are the others.
        wet: out, the immersed part of each strip, shape (10,).
        tau: out, forces and moments, shape (6,).
    """
    W, B, radius = c[C.W], c[C.B], c[C.radius]
    x_G, y_G, z_G = c[C.x_G], c[C.y_G], c[C.z_G]
    x_B, y_B, z_B = c[C.x_B], c[C.y_B], c[C.z_B]
    depth = z + radius + k_x * x_B + k_y * y_B + k_z * z_B
    half = 0.5 * c[C.L]
    part, moment = 0.0, 0.0
    if depth - half * abs(k_x) >= radius:
        part = 1.0
        wet[:] = 1.0
    else:
        for i in range(STRIPS):
            x = half * NODES[i]
            wet[i] = immersed((depth + k_x * x) / radius)
            share = 0.5 * WEIGHTS[i] * wet[i]
            part += share
            moment += share * x
    lift = B * part
    x_lift = B * (moment + part * x_B)
    tau[0] += (W - lift) * k_x
    tau[1] += (W - lift) * k_y
    tau[2] += (W - lift) * k_z
    tau[3] += (y_G * W - y_B * lift) * k_z - (z_G * W - z_B * lift) * k_y
    tau[4] += (z_G * W - z_B * lift) * k_x - (x_G * W - x_lift) * k_z
    tau[5] += (x_G * W - x_lift) * k_y - (y_G * W - y_B * lift) * k_x
    return part


@kernel("void(f8[::1],f8[::1],f8[::1],f8[::1])")
def cross_flow(c: Array, nu: Array, wet: Array, tau: Array) -> None:
    """Add the drag of the flow across the hull (Healey and Lienard 1993), opposed to it at every station.

    With v(x) = v + x r and w(x) = w - x q the force per length is -rho/2 (C_dy h v^2 + C_dz b w^2) (v, w) / |(v, w)|.
    """
    half = 0.5 * c[C.L]
    for i in range(STRIPS):
        x = half * NODES[i]
        v, w = nu[1] + x * nu[5], nu[2] - x * nu[4]
        speed = math.sqrt(v * v + w * w)
        if speed > 0.0:
            drag = half * WEIGHTS[i] * wet[i] * (c[C.k_y] * v * v + c[C.k_z] * w * w) / speed
            tau[1] -= drag * v
            tau[2] -= drag * w
            tau[4] += drag * w * x
            tau[5] -= drag * v * x
