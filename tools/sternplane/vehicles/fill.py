"""What a table leaves out, and the hull gives: the other plane of a round hull, and what added mass does in turns."""

from __future__ import annotations

import math

from sternplane.vehicles.conversion import Became, Converted
from sternplane.vehicles.particulars import Particulars

_CROSS_FLOW, _ROLL_DAMPING = 1.0, 0.3

_MIRRORED = (
    ("Y_v", "Z_w", 1.0),
    ("Y_r", "Z_q", -1.0),
    ("Y_vdot", "Z_wdot", 1.0),
    ("Y_rdot", "Z_qdot", -1.0),
    ("Y_dr", "Z_ds", -1.0),
    ("N_v", "M_w", -1.0),
    ("N_r", "M_q", 1.0),
    ("N_vdot", "M_wdot", -1.0),
    ("N_rdot", "M_qdot", 1.0),
    ("N_dr", "M_ds", 1.0),
    ("X_drdr", "X_dsds", 1.0),
    ("X_rr", "X_qq", 1.0),
    ("X_vr", "X_wq", -1.0),
)
"""(sway and yaw, heave and pitch, sign) of a hull of revolution with equal fins, seen after a quarter turn about x."""
_CORIOLIS = (
    ("X_wq", (("Z_wdot", 1.0),)),
    ("X_qq", (("Z_qdot", 1.0),)),
    ("X_vr", (("Y_vdot", -1.0),)),
    ("X_rr", (("Y_rdot", -1.0),)),
    ("Y_wp", (("Z_wdot", -1.0),)),
    ("Y_pq", (("Z_qdot", -1.0),)),
    ("Z_vp", (("Y_vdot", 1.0),)),
    ("Z_pr", (("Y_rdot", 1.0),)),
    ("M_vp", (("Y_rdot", -1.0),)),
    ("M_pr", (("K_pdot", 1.0), ("N_rdot", -1.0))),
    ("N_wp", (("Z_qdot", 1.0),)),
    ("N_pq", (("K_pdot", -1.0), ("M_qdot", 1.0))),
)
"""Terms of -C_A(nu) nu without u (Fossen 2011, Eq. 6.43): those with u are in what is measured as Y_v, M_w, N_r..."""


def symmetric(made: Converted) -> None:
    """Take what is missing of one plane from the other."""
    for across, upright, sign in _MIRRORED:
        for missing, given in ((across, upright), (upright, across)):
            if missing not in made.coefficients and given in made.coefficients:
                value = sign * made.coefficients[given]
                made.coefficients[missing] = value
                made.rows.append(Became("", "", f"{missing} = {value:.4g}", f"by symmetry, from {given}"))
    for missing, given in (("C_dy", "C_dz"), ("C_dz", "C_dy")):
        if missing not in made.drag and given in made.drag:
            made.drag[missing] = made.drag[given]
            made.rows.append(Became("", "", f"{missing} = {made.drag[given]:.4g}", f"by symmetry, from {given}"))


def coriolis(made: Converted, fill: bool) -> None:
    """Take what is missing of the turning of added mass from added mass; tell what is missing if not to `fill`."""
    absent = []
    for name, parts in _CORIOLIS:
        value = sum(sign * made.coefficients.get(given, 0.0) for given, sign in parts)
        if name in made.coefficients or not value:
            continue
        absent.append(name)
        if fill:
            made.coefficients[name] = value
            given = ", ".join(part for part, _ in parts)
            made.rows.append(Became("", "", f"{name} = {value:.4g}", f"turning of added mass, from {given}"))
    if absent and not fill:
        why = "not in the table; coriolis = true takes them from added mass"
        made.rows.append(Became("", "", "0", f"{', '.join(absent)}: {why}"))


def assume_damping(made: Converted, hull: Particulars) -> None:
    """Assume what no hull is without: drag across it, and some damping of roll; both are told."""
    if not made.drag.keys() & {"C_dy", "C_dz"} and not hull.values.keys() & {"C_dy", "C_dz"}:
        for key in ("C_dy", "C_dz"):
            hull.assume(key, _CROSS_FLOW, "a cylinder across the flow; no Yvv, no Zww")
    if "K_p" in made.coefficients:
        return
    v = hull.values
    scale = 0.5 * v["density_kg_m3"] * v["length_m"] ** 4
    inertia = v["I_x_kg_m2"] - scale * v["length_m"] * made.coefficients.get("K_pdot", 0.0)
    moment = v.get("z_G_m", 0.0) * v["weight_n"] - v.get("z_B_m", 0.0) * v["buoyancy_n"]
    if moment > 0.0 and inertia > 0.0:
        made.coefficients["K_p"] = -2.0 * _ROLL_DAMPING * math.sqrt(moment * inertia) / (scale * v["speed_m_s"])
        why = f"no K_p; {_ROLL_DAMPING:g} of the critical damping of roll at {v['speed_m_s']:g} m/s"
        hull.assumed.append(f"K_p = {made.coefficients['K_p']:.4g}: {why}")
