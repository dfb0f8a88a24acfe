"""What a table leaves out, and the hull gives: the other plane of a round hull, and what added mass does in turns."""

from __future__ import annotations

import math
from collections.abc import Iterable

from firmware_py.params import ParamError
from sternplane.vehicles.conversion import Became, Converted, added
from sternplane.vehicles.munk_moment import MUNK, munk_moments
from sternplane.vehicles.particulars import Particulars

_NONE = 1e-12
"""What rounding leaves of two that are equal."""
_CROSS_FLOW, _ROLL_DAMPING = 1.0, 0.3
_DECIDES = {
    "C_dy": "a cylinder across the flow; no Yvv. It decides turns, and may be 0.3: give C_dy if it is known",
    "C_dz": "the same in dives; no Zww",
}
"""Why drag across the hull is assumed, and what depends on it."""

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
    ("X_vv", "X_ww", 1.0),
    ("X_rdr", "X_qds", 1.0),
    ("X_vdr", "X_wds", -1.0),
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
    ("K_vw", (("Z_wdot", 1.0), ("Y_vdot", -1.0))),
    ("K_qr", (("N_rdot", 1.0), ("M_qdot", -1.0))),
    ("K_vq", (("Z_qdot", 1.0), ("Y_rdot", 1.0))),
    ("K_wr", (("Y_rdot", -1.0), ("Z_qdot", -1.0))),
    ("M_vp", (("Y_rdot", -1.0),)),
    ("M_pr", (("K_pdot", 1.0), ("N_rdot", -1.0))),
    ("N_wp", (("Z_qdot", 1.0),)),
    ("N_pq", (("K_pdot", -1.0), ("M_qdot", 1.0))),
)
"""Terms of -C_A(nu) nu without u (Fossen 2011, Eq. 6.43): those with u are in what is measured as Y_v, M_w, N_r..."""
_LINEAR = (
    *MUNK.items(),
    ("Y_r", (("X_udot", 1.0),)),
    ("Z_q", (("X_udot", -1.0),)),
    ("N_r", (("Y_rdot", 1.0),)),
    ("M_q", (("Z_qdot", -1.0),)),
    ("N_p", (("Y_pdot", 1.0),)),
)
"""Terms of -C_A(nu) nu with u: a table that has damping and lift, and computes C_A, does not have them."""
TURNING, FULL, NO = "true", "full", "false"
"""What `coriolis` may be: terms of C_A without u; all of C_A; none."""


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


def coriolis(made: Converted, how: str, where: str) -> None:
    """Take the turning of added mass from added mass, as far as `how` says; tell what is not taken.

    Args:
        made: what the table has; terms of C_A that it has itself stay, but those with u add to lift and damping.
        how: `TURNING`, `FULL` or `NO`.
        where: the file.

    Raises:
        ParamError: all of C_A is wanted, and there is no added mass.
    """
    absent = []
    if how == FULL and not any(made.coefficients.get(name) for name in ("Y_vdot", "Z_wdot")):
        raise ParamError(f'{where}: coriolis = "full" takes C_A from added mass: write Xudot, Yvdot, Zwdot, ...')
    for name, parts in _CORIOLIS:
        value = sum(sign * made.coefficients.get(given, 0.0) for given, sign in parts)
        if name in made.coefficients or abs(value) < _NONE:
            continue
        absent.append(name)
        if how != NO:
            made.coefficients[name] = value
            made.rows.append(
                Became("", "", f"{name} = {value:.4g}", f"turning of added mass, from {_names(made, parts)}")
            )
    if absent and how == NO:
        why = "not in the table; coriolis = true takes them from added mass"
        made.rows.append(Became("", "", "0", f"{', '.join(absent)}: {why}"))
    if how == FULL:
        _add_linear(made)
    else:
        _tell_munk(made)


def _add_linear(made: Converted) -> None:
    for name, parts in _LINEAR:
        value = sum(sign * made.coefficients.get(given, 0.0) for given, sign in parts)
        if abs(value) > _NONE:
            before = made.coefficients.get(name, 0.0)
            what = "Munk moment" if name in MUNK else "C_A with u"
            total = f", together {before + value:.4g}" if before else ""
            said = f"{what}, from {_names(made, parts)}{total}"
            made.rows.append(Became("", "", added(made, name, value), said))


def _tell_munk(made: Converted) -> None:
    """Say that N_v and M_w are taken for all of the moment, and what part of it added mass would be."""
    known = {name: munk for name, munk in munk_moments(made.coefficients).items() if name in made.coefficients}
    if known:
        alone = ", ".join(f"{name} = {munk:.4g}" for name, munk in known.items())
        said = f"of the table are taken as total; added mass alone would give {alone}"
        hint = 'coriolis = "full" adds it, where the table\'s C_A is computed'
        made.rows.append(Became("", "", ", ".join(known), f"{said}; {hint}"))


def _names(made: Converted, parts: Iterable[tuple[str, float]]) -> str:
    return ", ".join(name for name, _ in parts if made.coefficients.get(name))


def assume_damping(made: Converted, hull: Particulars) -> None:
    """Assume what no hull is without: drag across it, and some damping of roll; both are told."""
    given = {**made.drag, **{key: hull.values[key] for key in _DECIDES if key in hull.values}}
    for key, other in zip(_DECIDES, reversed(_DECIDES), strict=True):
        if key not in given:
            hull.assume(key, given.get(other, _CROSS_FLOW), f"that of {other}" if other in given else _DECIDES[key])
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
