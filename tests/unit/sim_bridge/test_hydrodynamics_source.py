"""The plant against an independent reading of its source: every coefficient alone, then all of them together.

The table is Healey and Lienard's data with the terms of the paper's appendix, errata applied; the reference works with
Euler angles, printed component equations and adaptive quadrature where the plant has quaternions, vectors and strips.
"""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad_vec

from firmware_py import params
from firmware_py.marine import Eta, Nu
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.packing import mass_matrix
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import FinStation, PlantCoefficients, PlantFin, Truth

CONFIG = Path(__file__).resolve().parents[3] / "configs" / "npsauv2" / "truth.toml"
BOW = (
    PlantFin("bow_port", FinStation.BOW, 0.0, (1.4, -0.42, 0.0), 0.05),
    PlantFin("bow_starboard", FinStation.BOW, 0.0, (1.4, 0.42, 0.0), 0.05),
)
AS_BUILT = params.load(Truth, tomllib.loads(CONFIG.read_text()), "truth.toml")
TRUTH = dataclasses.replace(AS_BUILT, fins=(*AS_BUILT.fins, *BOW))
RHO, L = 1000.0, 5.3

# coefficient, value, power of L, what it multiplies
TABLE = """
X_pp 7e-3 4 p*p        | X_qq -1.5e-2 4 q*q        | X_rr 4e-3 4 r*r          | X_pr 7.5e-4 4 p*r
X_wq -2e-1 3 w*q       | X_vp -3e-3 3 v*p          | X_vr 2e-2 3 v*r          | X_qds 2.5e-2 3 u*q*ds
X_rdr -1e-3 3 u*r*dr   | X_vv 5.3e-2 2 v*v         | X_ww 1.7e-1 2 w*w        | X_vdr 1.7e-3 2 u*v*dr
X_wds 4.6e-2 2 u*w*ds  | X_dsds -1e-2 2 u*u*ds*ds  | X_drdr -1e-2 2 u*u*dr*dr | X_qdsn 2e-3 3 u*q*ds*eps
X_wdsn 3.5e-3 2 u*w*ds*eps | X_dsdsn -1.6e-3 2 u*u*ds*ds*eps | X_qdb -1.3e-3 3 u*q*(bp+bs)
X_wdb 5e-3 2 u*w*(bp+bs)   | X_dbdb -4e-3 2 u*u*(bp*bp+bs*bs)
Y_pq 4e-3 4 p*q        | Y_qr -6.5e-3 4 q*r        | Y_p 3e-3 3 u*p           | Y_r 3e-2 3 u*r
Y_vq 2.4e-2 3 v*q      | Y_wp 2.3e-1 3 w*p         | Y_wr -1.9e-2 3 w*r       | Y_v -1e-1 2 u*v
Y_vw 6.8e-2 2 v*w      | Y_dr 2.7e-2 2 u*u*dr
Z_pp 1.3e-4 4 p*p      | Z_pr 6.7e-3 4 p*r         | Z_rr -7.4e-3 4 r*r       | Z_q -1.4e-1 3 u*q
Z_vp -4.8e-2 3 v*p     | Z_vr 4.5e-2 3 v*r         | Z_w -3e-1 2 u*w          | Z_vv -6.8e-2 2 v*v
Z_ds -7.3e-2 2 u*u*ds  | Z_qn -2.9e-3 3 u*q*eps    | Z_wn -5.1e-3 2 u*w*eps   | Z_dsn -1e-2 2 u*u*ds*eps
Z_db -1.3e-2 2 u*u*(bp+bs)
K_pq -6.9e-5 5 p*q     | K_qr 1.7e-2 5 q*r         | K_p -1.1e-2 4 u*p        | K_r -8.4e-4 4 u*r
K_vq -5.1e-3 4 v*q     | K_wp -1.3e-4 4 w*p        | K_wr 1.4e-2 4 w*r        | K_v 3.1e-3 3 u*v
K_vw -1.9e-1 3 v*w     | K_pn -5.7e-4 4 u*p*eps    | K_prop 0 3 u*u
M_pp 5.3e-5 5 p*p      | M_pr 5e-3 5 p*r           | M_rr 2.9e-3 5 r*r        | M_q -6.8e-2 4 u*q
M_vp 1.2e-3 4 v*p      | M_vr 1.7e-2 4 v*r         | M_w 1e-1 3 u*w           | M_vv -2.6e-2 3 v*v
M_ds -4.1e-2 3 u*u*ds  | M_qn -1.6e-3 4 u*q*eps    | M_wn -2.9e-3 3 u*w*eps   | M_dsn -5.2e-3 3 u*u*ds*eps
M_db 3.5e-3 3 u*u*(bp+bs)
N_pq -2.1e-2 5 p*q     | N_qr 2.7e-3 5 q*r         | N_p -8.4e-4 4 u*p        | N_r -1.6e-2 4 u*r
N_vq -1e-2 4 v*q       | N_wp -1.7e-2 4 w*p        | N_wr 7.4e-3 4 w*r        | N_v -7.4e-3 3 u*v
N_vw -2.7e-2 3 v*w     | N_dr -1.3e-2 3 u*u*dr     | N_prop 0 3 u*u
"""
ADDED_MASS = """
X_udot -7.6e-3 3 | Y_pdot 1.2e-4 4  | Y_rdot 1.2e-3 4  | Y_vdot -5.5e-2 3 | Z_qdot -6.8e-3 4 | Z_wdot -2.4e-1 3
K_pdot -1e-3 5   | K_rdot -3.4e-5 5 | K_vdot 1.2e-4 4  | M_qdot -1.7e-2 5 | M_wdot -6.8e-3 4 | N_pdot -3.4e-5 5
N_rdot -3.4e-3 5 | N_vdot 1.2e-3 4
"""


def rows(table: str) -> list[list[str]]:
    return [cell.split() for line in table.strip().splitlines() for cell in line.split("|")]


TERMS = [(name, float(value), int(power), term) for name, value, power, term in rows(TABLE)]
DOTS = [(name, float(value), int(power)) for name, value, power in rows(ADDED_MASS)]
AXES = "XYZKMN"


@dataclasses.dataclass(frozen=True)
class Case:
    """A state ahead: attitude (rad), velocity through the water, controls (rad), shaft (rev/s)."""

    attitude: tuple[float, float, float]
    nu: tuple[float, ...]
    ds: float
    dr: float
    bp: float
    bs: float
    n: float

    @staticmethod
    def random(generator: np.random.Generator) -> Case:
        u, n = generator.uniform(0.3, 3.0), generator.uniform(1.0, 15.0)
        rest = generator.uniform(-0.6, 0.6, 5)
        ds, dr, bp, bs = generator.uniform(-0.4, 0.4, 4)
        phi, theta, psi = generator.uniform(-1.3, 1.3, 3)
        return Case((phi, theta, psi), (u, *rest), ds, dr, bp, bs, n)

    @property
    def eps(self) -> float:
        """As printed; n in rpm, u in ft/s."""
        eta = 0.012 * self.n * 60.0 / (self.nu[0] / 0.3048)
        C_t, C_t1 = 0.008 * L**2 * eta * abs(eta) / 2.0, 0.008 * L**2 / 2.0
        return -1.0 + (math.sqrt(C_t + 1.0) - 1.0) / (math.sqrt(C_t1 + 1.0) - 1.0)

    def term(self, text: str) -> float:
        names = dict(zip("uvwpqr", self.nu, strict=True))
        values = {**names, "ds": self.ds, "dr": self.dr, "bp": self.bp, "bs": self.bs, "eps": self.eps}
        return float(eval(text, {"__builtins__": {}}, values))

    def tau(self, truth: Truth) -> np.ndarray:
        """M nu_dot of the plant in this state, deep down and without a current."""
        fins = (self.ds, self.ds, self.dr, self.dr, self.bp, self.bs)
        eta = Eta(0.0, 0.0, 100.0, *self.attitude)
        plant = Plant(truth, Environment(EnvironmentParams(), 0, 0.01), 0.01, 1, eta, Nu(*self.nu), self.n, fins)
        return mass_matrix(truth) @ np.array(plant.nu_dot)


def with_coefficients(**values: float) -> Truth:
    """The vehicle with these coefficients, and all others 0 but the added masses."""
    kept = {name: value for name, value, _ in DOTS}
    zero = {field.name: 0.0 for field in dataclasses.fields(PlantCoefficients)}
    return dataclasses.replace(TRUTH, coefficients=PlantCoefficients(**{**zero, **kept, **values}))


def test_the_file_holds_the_published_value_of_every_coefficient_and_no_other() -> None:
    published = {name: value for name, value, *_ in (*TERMS, *DOTS)}
    assert dataclasses.asdict(TRUTH.coefficients) == published


@pytest.mark.parametrize(("name", "value", "power", "term"), TERMS, ids=[row[0] for row in TERMS])
def test_each_coefficient_alone_gives_its_own_term_with_its_sign(
    name: str, value: float, power: int, term: str
) -> None:
    value = value or 0.01
    case = Case.random(np.random.default_rng(sum(map(ord, name))))
    change = case.tau(with_coefficients(**{name: value})) - case.tau(with_coefficients())
    expected = np.zeros(6)
    expected[AXES.index(name[0])] = value * 0.5 * RHO * L**power * case.term(term)
    assert abs(expected).max() > 0.0
    np.testing.assert_allclose(change, expected, rtol=1e-9, atol=1e-8)


@pytest.mark.parametrize(("name", "value", "power"), DOTS, ids=[row[0] for row in DOTS])
def test_each_added_mass_stands_at_its_place_in_the_mass_matrix(name: str, value: float, power: int) -> None:
    without = dataclasses.replace(TRUTH, coefficients=dataclasses.replace(TRUTH.coefficients, **{name: 0.0}))
    expected = np.zeros((6, 6))
    expected[AXES.index(name[0]), "uvwpqr".index(name[2])] = -value * 0.5 * RHO * L**power
    np.testing.assert_allclose(mass_matrix(TRUTH) - mass_matrix(without), expected, rtol=1e-9, atol=1e-9)


def rigid_body_as_printed(truth: Truth, nu: tuple[float, ...]) -> np.ndarray:
    """X_m to N_m of the appendix."""
    b = truth.body
    m, Ix, Iy, Iz, Ixy, Iyz, Ixz = b.m, b.I_x, b.I_y, b.I_z, b.I_xy, b.I_yz, b.I_xz
    (xG, yG, zG), (u, v, w, p, q, r) = b.r_G, nu
    return np.array(
        [
            m * (v * r - w * q + xG * (q**2 + r**2) - yG * p * q - zG * p * r),
            -m * (u * r - w * p + xG * p * q - yG * (p**2 + r**2) + zG * q * r),
            m * (u * q - v * p - xG * p * r - yG * q * r + zG * (p**2 + q**2)),
            -(Iz - Iy) * q * r - Ixy * p * r + Iyz * (q**2 - r**2) + Ixz * p * q
            - m * (yG * (v * p - u * q) - zG * (u * r - w * p)),
            -(Ix - Iz) * p * r + Ixy * q * r - Iyz * p * q - Ixz * (p**2 - r**2)
            + m * (xG * (v * p - u * q) - zG * (w * q - v * r)),
            -(Iy - Ix) * p * q + Ixy * (p**2 - q**2) + Iyz * p * r - Ixz * q * r
            - m * (xG * (u * r - w * p) - yG * (w * q - v * r)),
        ]
    )  # fmt: skip


def restoring_as_printed(truth: Truth, phi: float, theta: float) -> np.ndarray:
    b = truth.body
    (xG, yG, zG), (xB, yB, zB), W, B = b.r_G, b.r_B, b.W, b.B
    s1, c1, s2, c2 = math.sin(phi), math.cos(phi), math.sin(theta), math.cos(theta)
    return np.array(
        [
            -(W - B) * s2,
            (W - B) * c2 * s1,
            (W - B) * c2 * c1,
            (yG * W - yB * B) * c2 * c1 - (zG * W - zB * B) * c2 * s1,
            -(xG * W - xB * B) * c2 * c1 - (zG * W - zB * B) * s2,
            (xG * W - xB * B) * c2 * s1 + (yG * W - yB * B) * s2,
        ]
    )


def cross_flow_by_quadrature(nu: tuple[float, ...], height: float, width: float) -> np.ndarray:
    _, v, w, _, q, r = nu

    def density(x: float) -> np.ndarray:
        v_x, w_x = v + x * r, w - x * q
        force = 0.5 * RHO * (0.5 * height * v_x**2 + 0.6 * width * w_x**2) / math.hypot(v_x, w_x)
        return -force * np.array([0.0, v_x, w_x, 0.0, -x * w_x, x * v_x])

    return quad_vec(density, -L / 2.0, L / 2.0, epsabs=1e-9, epsrel=1e-12)[0]


def no_drag(truth: Truth) -> Truth:
    return dataclasses.replace(truth, hull=dataclasses.replace(truth.hull, C_dy=0.0, C_dz=0.0))


def test_all_forces_but_cross_flow_together_are_those_of_the_source() -> None:
    generator = np.random.default_rng(1993)
    body = dataclasses.replace(TRUTH.body, r_G=(0.11, -0.05, 0.061), r_B=(0.02, 0.01, -0.03), B=53000.0, I_xy=310.0)
    for truth in (TRUTH, dataclasses.replace(TRUTH, body=body)):
        for _ in range(50):
            case = Case.random(generator)
            expected = rigid_body_as_printed(truth, case.nu) + restoring_as_printed(truth, *case.attitude[:2])
            for name, value, power, term in TERMS:
                expected[AXES.index(name[0])] += value * 0.5 * RHO * L**power * case.term(term)
            u, eta = case.nu[0], 0.012 * case.n * 60.0 / (case.nu[0] / 0.3048)
            expected[0] += 0.5 * RHO * L**2 * u**2 * 0.00385 * (eta * abs(eta) - 1.0)
            np.testing.assert_allclose(case.tau(no_drag(truth)), expected, rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize(("height", "width"), [(0.53, 0.53), (0.42, 0.69)])
def test_cross_flow_is_the_integral_along_the_hull(height: float, width: float) -> None:
    truth = dataclasses.replace(TRUTH, hull=dataclasses.replace(TRUTH.hull, height=height, width=width))
    generator = np.random.default_rng(10)
    for _ in range(50):
        case = Case.random(generator)
        drag, expected = case.tau(truth) - case.tau(no_drag(truth)), cross_flow_by_quadrature(case.nu, height, width)
        # ten points are not exact where the flow turns within the hull: 1 % of the largest component
        np.testing.assert_allclose(drag, expected, rtol=0.0, atol=0.01 * abs(expected).max())
        straight = dataclasses.replace(case, nu=(*case.nu[:4], 0.0, 0.0))
        drag = straight.tau(truth) - straight.tau(no_drag(truth))
        expected = cross_flow_by_quadrature(straight.nu, height, width)
        np.testing.assert_allclose(drag, expected, rtol=1e-9, atol=1e-7)
