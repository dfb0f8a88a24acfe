"""Thrust, and the propeller race over the fins; both finite at rest, in reverse, and when they oppose the motion.

Published (Healey and Lienard 1993): eta = 0.012 n / u with n in rpm and u in ft/s, X_prop = C_d0 (eta|eta| - 1) times
u^2, and eps(n) = -1 + sign(n)/sign(u) (sqrt(1 + C_t) - 1) / (sqrt(1 + C_t1) - 1), singular at u = 0.

Here u_n = advance n is the speed at which eta = 1, so u|u| X_prop = C_d0 (u_n|u_n| - u|u|): the drag opposes the motion
also astern. With the race u_s, the signed root of u|u| + a u_n|u_n| (a = C_t1, momentum theory), u eps(n) becomes
(u_s - u) / knee - u wherever propeller and motion agree, and continues through rest and reversal without a step.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from sim_bridge.plant.packing import Array, C


@kernel("f8(f8)")
def square(x: float) -> float:
    """Return x |x|."""
    return x * abs(x)


@kernel("f8(f8)")
def root(x: float) -> float:
    """Return the inverse of `square`."""
    return math.copysign(math.sqrt(abs(x)), x)


@kernel("UniTuple(f8,2)(f8[::1],f8,f8,f8)")
def race(c: Array, u: float, n: float, wet: float) -> tuple[float, float]:
    """Return (u eps, |u| eps), m/s, at water speed u, shaft speed n (rev/s) and immersed part `wet` of the disc.

    The second goes with direct damping, which opposes the motion whichever way the race runs; ahead they are equal.
    """
    added = (root(square(u) + c[C.k_race] * square(c[C.advance] * n) * wet) - u) / c[C.knee]
    return added - u, abs(added) - abs(u)


@kernel("void(f8[::1],f8,f8,f8,f8,f8[::1])")
def propulsion(c: Array, u: float, n: float, wet: float, hull_wet: float, tau: Array) -> None:
    """Add thrust less axial drag to `tau`, and the (published as zero) moments of the propeller."""
    tau[0] += c[C.k_thrust] * (square(c[C.advance] * n) * wet - square(u) * hull_wet)
    tau[3] += c[C.K_prop] * square(u) * wet
    tau[5] += c[C.N_prop] * square(u) * wet
