"""The hydrodynamic coefficients that the autopilot believes in: nondimensional with rho/2 L^n, named as SNAME does."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Coefficients:
    """The set of Healey and Lienard (1993). One that the vehicle file does not give is believed to be zero.

    The name spells the term: force or moment, then the factors it multiplies. `dot` marks added mass; ds, dr and db are
    stern planes, rudders and *one* bow plane; a last n marks what works in the propeller's race, times eps(n).
    """

    X_pp: float = 0.0
    X_qq: float = 0.0
    X_rr: float = 0.0
    X_pr: float = 0.0
    X_udot: float = 0.0
    X_wq: float = 0.0
    X_vp: float = 0.0
    X_vr: float = 0.0
    X_vv: float = 0.0
    X_ww: float = 0.0
    X_qds: float = 0.0
    X_wds: float = 0.0
    X_dsds: float = 0.0
    X_rdr: float = 0.0
    X_vdr: float = 0.0
    X_drdr: float = 0.0
    X_qdb: float = 0.0
    X_wdb: float = 0.0
    X_qdsn: float = 0.0
    X_wdsn: float = 0.0
    X_dsdsn: float = 0.0

    Y_pdot: float = 0.0
    Y_rdot: float = 0.0
    Y_vdot: float = 0.0
    Y_pq: float = 0.0
    Y_qr: float = 0.0
    Y_p: float = 0.0
    Y_r: float = 0.0
    Y_v: float = 0.0
    Y_vq: float = 0.0
    Y_wp: float = 0.0
    Y_wr: float = 0.0
    Y_vw: float = 0.0
    Y_dr: float = 0.0

    Z_qdot: float = 0.0
    Z_wdot: float = 0.0
    Z_pp: float = 0.0
    Z_pr: float = 0.0
    Z_rr: float = 0.0
    Z_q: float = 0.0
    Z_w: float = 0.0
    Z_vp: float = 0.0
    Z_vr: float = 0.0
    Z_vv: float = 0.0
    Z_ds: float = 0.0
    Z_db: float = 0.0
    Z_qn: float = 0.0
    Z_wn: float = 0.0
    Z_dsn: float = 0.0

    K_pdot: float = 0.0
    K_rdot: float = 0.0
    K_vdot: float = 0.0
    K_pq: float = 0.0
    K_qr: float = 0.0
    K_p: float = 0.0
    K_r: float = 0.0
    K_v: float = 0.0
    K_vq: float = 0.0
    K_wp: float = 0.0
    K_wr: float = 0.0
    K_vw: float = 0.0
    K_pn: float = 0.0
    K_prop: float = 0.0

    M_qdot: float = 0.0
    M_wdot: float = 0.0
    M_pp: float = 0.0
    M_pr: float = 0.0
    M_rr: float = 0.0
    M_q: float = 0.0
    M_w: float = 0.0
    M_vp: float = 0.0
    M_vr: float = 0.0
    M_vv: float = 0.0
    M_ds: float = 0.0
    M_db: float = 0.0
    M_qn: float = 0.0
    M_wn: float = 0.0
    M_dsn: float = 0.0

    N_pdot: float = 0.0
    N_rdot: float = 0.0
    N_vdot: float = 0.0
    N_pq: float = 0.0
    N_qr: float = 0.0
    N_p: float = 0.0
    N_r: float = 0.0
    N_v: float = 0.0
    N_vq: float = 0.0
    N_wp: float = 0.0
    N_wr: float = 0.0
    N_vw: float = 0.0
    N_dr: float = 0.0
    N_prop: float = 0.0
