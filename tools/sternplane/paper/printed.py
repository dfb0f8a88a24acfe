"""What the paper prints (J.-Y. Kim, "Controller Design for an Autonomous Underwater Vehicle Using Estimated
Hydrodynamic Coefficients"), and where it cannot be meant as printed.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.estimation.coefficient_params import TEN

TABLE_1 = {
    "ekf": dict(zip(TEN, (0.12, 0.26, 0.33, 0.58, 0.13, 0.05, 0.09, 14.53, 9.61, 23.29), strict=True)),
    "smo": dict(zip(TEN, (1.10, 1.46, 24.67, 17.78, 30.35, 3.07, 2.48, 49.34, 102.57, 44.22), strict=True)),
}
"""Steady-state error, %, without signs."""
SIGNS = {"M_q": 1.0, "M_ds": 1.0, "Y_v": -1.0, "Y_r": 1.0, "Y_dr": 1.0}
"""Signs of the EKF's column with which Eq. 27 and the first row of Eq. 31 follow; any will do for the rest."""
U = 1.832
"""Speed of the design, m/s: Eq. 27, third row."""


class Number(NamedTuple):
    """A number of the design: where it is printed, what it is called in `design.numbers`, and as it is printed."""

    equation: str
    key: str
    what: str
    printed: str

    @property
    def value(self) -> float:
        """As a number."""
        return float(self.printed)

    @property
    def box(self) -> tuple[float, float]:
        """The least and the greatest number that is printed so."""
        half = 0.5 * 10.0 ** -len(self.printed.partition(".")[2])
        return self.value - half, self.value + half


NUMBERS = (
    Number("27", "a_qq", "q_dot by q, 1/s", "-1.002"),
    Number("27", "a_qt", "q_dot by theta, 1/s²", "-0.066"),
    Number("27", "a_zt", "z_dot by theta, m/s", "-1.8320"),
    Number("27", "b_q", "q_dot by delta_s, 1/s²", "-0.209"),
    Number("28", "s_q", "sigma_s by q, m s", "28.18"),
    Number("28", "s_theta", "sigma_s by theta, m", "14.37"),
    Number("29", "k_q", "delta_s by q, s", "2.3531"),
    Number("29", "k_theta", "delta_s by theta", "0.0062"),
    Number("29", "k_zd_dot", "delta_s by z_d_dot, s/m", "-0.1698"),
    Number("31", "a_vv", "v_dot by v, 1/s", "-0.209"),
    Number("31", "a_vr", "v_dot by r, m/s", "-0.605"),
    Number("31", "b_v", "v_dot by delta_r, m/s²", "0.145"),
    Number("31", "a_rv", "r_dot by v, 1/(m s)", "-0.054"),
    Number("31", "a_rr", "r_dot by r, 1/s", "-0.569"),
    Number("31", "b_r", "r_dot by delta_r, 1/s²", "-0.152"),
    Number("32", "s_v", "sigma_r by v, s/m", "0.15"),
    Number("32", "s_r", "sigma_r by r, s", "1.65"),
    Number("33", "k_v", "delta_r by v, s/m", "0.5260"),
    Number("33", "k_r", "delta_r by r, s", "0.1621"),
    Number("33", "k_psid_dot", "delta_r by psi_d_dot, s", "4.3465"),
)
"""Eq. 27 to 33; the factors of the tanh terms, 2.3 and 1.5, are chosen, not computed."""

ERRATA = (
    ("Eq. 1, lines of Y, K, N", "w r - w p", "u r - w p, as in the appendix's own Y_m"),
    ("Eq. 1, lines of X and Z", "q_dot²", "q² (the term q_dot z_G of the line of X is right)"),
    ("Eq. 1, line of K", "q_dot² - r²", "q² - r²"),
    ("Section 2, the ten by name", "dotted", "without dots: damping and control, not added mass"),
    ("Eq. 13", "second row 0", "xi(k+1) = xi(k) + eta(k)"),
    ("Eq. 26 and 30, left-hand sides", "M_q, Y_v, Y_r, N_v, N_r", "dotted: added mass, as Eq. 27 shows"),
    ("Eq. 30, term of Y_dr", "L³", "L²: a force; with L³ the estimates that give the printed 0.145 give 0.80"),
    ("Eq. 29", "+2.3531 q + 0.0062 theta - 0.1698 z_d_dot", "all three with the other sign: Eq. 25 with Eq. 27, 28"),
    ("Eq. 33", "+0.5260 v + 0.1621 r + 4.3465 psi_d_dot", "all three with the other sign: Eq. 25 with Eq. 31, 32"),
    ("Appendix, M", "X_wdot; every scale L³; K_x, N_x", "X_udot; L³, L⁴ and L⁵ by equation; K_vdot, N_vdot"),
    ("Appendix, K_e", "u³ K_prop", "u²; it is 0 in the data"),
    ("Appendix, X_e, Z_e, M_e", "no terms X_wds(n), Z_pr, M_pr", "they are in the data, and in both models here"),
)
"""Where, what is printed, what is right."""
