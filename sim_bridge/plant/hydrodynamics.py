"""Forces of the water on hull and fins: every term of the NPS AUV II (Healey and Lienard 1993), SI.

Each kernel adds to tau = (X, Y, Z, K, M, N). Velocities are relative to the water. The five direct damping terms (Y_v,
Z_w, K_p, M_q, N_r, with their eps(n) parts) take |u| and the fins u|u| where the source, which knows only motion ahead,
has u and u^2: ahead that is the same, and astern damping damps and a rudder works the other way round.
"""

from __future__ import annotations

from firmware_py.compiled import kernel
from sim_bridge.plant.packing import Array, C, F
from sim_bridge.plant.propulsion import square


@kernel("void(f8[::1],f8[::1],f8,f8,f8,f8[::1])")
def hull(c: Array, nu: Array, u_eps: float, abs_u_eps: float, wet: float, tau: Array) -> None:
    """Add the hull forces at relative velocity `nu` (6,): `u_eps`, `abs_u_eps` from `race`, `wet` the immersed part."""
    u, v, w, p, q, r = nu[0], nu[1], nu[2], nu[3], nu[4], nu[5]
    s = abs(u)
    tau[0] += wet * (
        c[C.X_pp] * p * p
        + c[C.X_qq] * q * q
        + c[C.X_rr] * r * r
        + c[C.X_pr] * p * r
        + c[C.X_wq] * w * q
        + c[C.X_vp] * v * p
        + c[C.X_vr] * v * r
        + c[C.X_vv] * v * v
        + c[C.X_ww] * w * w
    )
    tau[1] += wet * (
        c[C.Y_pq] * p * q
        + c[C.Y_qr] * q * r
        + c[C.Y_p] * u * p
        + c[C.Y_r] * u * r
        + c[C.Y_vq] * v * q
        + c[C.Y_wp] * w * p
        + c[C.Y_wr] * w * r
        + c[C.Y_v] * s * v
        + c[C.Y_vw] * v * w
    )
    tau[2] += wet * (
        c[C.Z_pp] * p * p
        + c[C.Z_pr] * p * r
        + c[C.Z_rr] * r * r
        + (c[C.Z_q] * u + c[C.Z_qn] * u_eps) * q
        + c[C.Z_vp] * v * p
        + c[C.Z_vr] * v * r
        + (c[C.Z_w] * s + c[C.Z_wn] * abs_u_eps) * w
        + c[C.Z_vv] * v * v
    )
    tau[3] += wet * (
        c[C.K_pq] * p * q
        + c[C.K_qr] * q * r
        + (c[C.K_p] * s + c[C.K_pn] * abs_u_eps) * p
        + c[C.K_r] * u * r
        + c[C.K_vq] * v * q
        + c[C.K_wp] * w * p
        + c[C.K_wr] * w * r
        + c[C.K_v] * u * v
        + c[C.K_vw] * v * w
    )
    tau[4] += wet * (
        c[C.M_pp] * p * p
        + c[C.M_pr] * p * r
        + c[C.M_rr] * r * r
        + (c[C.M_q] * s + c[C.M_qn] * abs_u_eps) * q
        + c[C.M_vp] * v * p
        + c[C.M_vr] * v * r
        + (c[C.M_w] * u + c[C.M_wn] * u_eps) * w
        + c[C.M_vv] * v * v
    )
    tau[5] += wet * (
        c[C.N_pq] * p * q
        + c[C.N_qr] * q * r
        + c[C.N_p] * u * p
        + c[C.N_r] * s * r
        + c[C.N_vq] * v * q
        + c[C.N_wp] * w * p
        + c[C.N_wr] * w * r
        + c[C.N_v] * u * v
        + c[C.N_vw] * v * w
    )


@kernel("void(f8[::1],f8[::1],f8[:,::1],f8[::1],f8,f8,f8,f8,f8,f8[::1])")
def fins(
    c: Array,
    nu: Array,
    table: Array,
    delta: Array,
    u_eps: float,
    depth: float,
    k_x: float,
    k_y: float,
    k_z: float,
    tau: Array,
) -> None:
    """Add the fin forces. Every fin of `table` counts by its share, its effectiveness and its immersed part.

    Args:
        c: constants.
        nu: velocity relative to the water, (6,).
        table: one row per fin, see `packing.F`.
        delta: true fin angles, rad.
        u_eps: u eps(n), m/s.
        depth: depth of the origin under the surface, m.
        k_x: first component of the downward unit vector in the body frame; `k_y` and `k_z` are the others.
        tau: out, (6,).
    """
    u, v, w, q, r = nu[0], nu[1], nu[2], nu[4], nu[5]
    ds, dr, db, db_2 = 0.0, 0.0, 0.0, 0.0
    for i in range(len(delta)):
        fin = table[i]
        under = depth + k_x * fin[F.x] + k_y * fin[F.y] + k_z * fin[F.z]
        wet = min(max(0.5 + under / fin[F.span], 0.0), 1.0)
        angle = delta[i] * fin[F.effectiveness] * wet
        ds += fin[F.to_s] * angle
        dr += fin[F.to_r] * angle
        db += fin[F.to_b] * angle
        db_2 += fin[F.to_b] * angle * angle
    uu, su = square(u), abs(u) * u_eps
    tau[0] += (
        ((c[C.X_qds] * u + c[C.X_qdsn] * u_eps) * q + (c[C.X_wds] * u + c[C.X_wdsn] * u_eps) * w) * ds
        + (c[C.X_rdr] * r + c[C.X_vdr] * v) * u * dr
        + (c[C.X_dsds] * uu + c[C.X_dsdsn] * su) * ds * ds
        + c[C.X_drdr] * uu * dr * dr
        + (c[C.X_qdb] * q + c[C.X_wdb] * w) * u * db
        + c[C.X_dbdb] * uu * db_2
    )
    tau[1] += c[C.Y_dr] * uu * dr
    tau[2] += (c[C.Z_ds] * uu + c[C.Z_dsn] * su) * ds + c[C.Z_db] * uu * db
    tau[4] += (c[C.M_ds] * uu + c[C.M_dsn] * su) * ds + c[C.M_db] * uu * db
    tau[5] += c[C.N_dr] * uu * dr
