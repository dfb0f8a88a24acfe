"""What any model of a body in water must obey, whatever its numbers."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_py.marine import Eta, Nu
from sim_bridge.plant.dynamics import rigid_body
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.packing import constants, mass_matrix
from sim_bridge.plant.plant import AT_REST, Plant
from sim_bridge.plant.propulsion import propulsion, race
from sim_bridge.plant.strips import NODES, WEIGHTS, cross_flow, hydrostatics, immersed
from sim_bridge.plant.truth import Truth

from .plants import TRUTH

CONSTANTS = constants(TRUTH)
DEEP = Eta(0.0, 0.0, 100.0, 0.0, 0.0, 0.0)
TRIM = 500.0 / 60.0, 1.8288

speeds = st.floats(-3.0, 3.0)
velocities = st.tuples(speeds, speeds, speeds, speeds, speeds, speeds)
angles = st.floats(-0.4, 0.4)


def plant(truth: Truth = TRUTH, eta: Eta = DEEP, nu: Nu = AT_REST, n: float = 0.0, fins: object = None) -> Plant:
    return Plant(truth, Environment(EnvironmentParams(), 0, 0.01), 0.01, 1, eta, nu, n, fins)  # type: ignore[arg-type]


@given(velocities, st.tuples(speeds, speeds, speeds), st.tuples(*[st.floats(-500.0, 500.0)] * 3))
def test_coriolis_forces_do_no_work(nu: tuple[float, ...], r_G: tuple[float, ...], products: tuple[float, ...]) -> None:
    I_xy, I_yz, I_xz = products
    body = dataclasses.replace(TRUTH.body, r_G=r_G, I_xy=I_xy, I_yz=I_yz, I_xz=I_xz)
    c, tau = constants(dataclasses.replace(TRUTH, body=body)), np.zeros(6)
    rigid_body(c, np.array(nu), tau)
    assert abs(np.dot(nu, tau)) <= 1e-13 * (1.0 + np.abs(np.multiply(nu, tau)).sum())


@given(velocities)
def test_cross_flow_takes_power_in_every_state(nu: tuple[float, ...]) -> None:
    tau = np.zeros(6)
    cross_flow(CONSTANTS, np.array(nu), np.ones(10), tau)
    across = [math.hypot(nu[1] + x * nu[5], nu[2] - x * nu[4]) for x in (-2.65, 0.0, 2.65)]
    power = float(np.dot(nu, tau))
    assert power <= 0.0
    assert power < 0.0 or max(across) < 1e-6


@given(speeds)
def test_axial_drag_takes_power_ahead_and_astern(u: float) -> None:
    tau = np.zeros(6)
    propulsion(CONSTANTS, u, 0.0, 1.0, 1.0, tau)
    assert u * tau[0] <= 0.0
    assert tau[0] == pytest.approx(-math.copysign(500.0 * 5.3**2 * 0.00385 * u * u, u))


@given(speeds, speeds, speeds, angles, angles)
def test_a_vehicle_alone_in_the_water_slows_down(u: float, p: float, q: float, ds: float, dr: float) -> None:
    """Direct damping and fin drag oppose surge, roll, pitch and yaw ahead and astern, one motion at a time."""
    assume(min(abs(u), abs(p), abs(q)) > 0.01)
    for i, rate in ((1, q), (2, q), (3, p), (4, q), (5, q)):
        nu = [u, 0.0, 0.0, 0.0, 0.0, 0.0]
        still = mass_matrix(TRUTH) @ np.array(plant(nu=Nu(*nu)).nu_dot)
        nu[i] = rate
        moved = mass_matrix(TRUTH) @ np.array(plant(nu=Nu(*nu)).nu_dot)
        assert (moved - still)[i] * rate < 0.0
    straight = plant(nu=Nu(u, 0.0, 0.0, 0.0, 0.0, 0.0))
    steered = plant(nu=Nu(u, 0.0, 0.0, 0.0, 0.0, 0.0), fins=(ds, ds, dr, dr))
    tau = mass_matrix(TRUTH) @ (np.array(steered.nu_dot) - np.array(straight.nu_dot))
    assert tau[0] * u <= 1e-9


def test_the_quadrature_rule_is_gauss_and_legendres() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(10)
    np.testing.assert_allclose(NODES, nodes, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(WEIGHTS, weights, rtol=1e-14)
    assert sum(WEIGHTS) * 5.3 / 2.0 == pytest.approx(5.3, rel=1e-14)


MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


@given(velocities, st.tuples(angles, angles, angles, angles), st.tuples(angles, angles, speeds), st.floats(-12.0, 12.0))
def test_port_and_starboard_are_alike(
    nu: tuple[float, ...], fins: tuple[float, ...], attitude: tuple[float, ...], n: float
) -> None:
    """All but the products of inertia I_xy and I_yz of the published data is symmetric."""
    truth = dataclasses.replace(TRUTH, body=dataclasses.replace(TRUTH.body, I_xy=0.0, I_yz=0.0))
    phi, theta, psi = attitude
    port, starboard, upper, lower = fins
    one = plant(truth, Eta(0.0, 0.0, 9.0, phi, theta, psi), Nu(*nu), n, fins)
    other_fins = (starboard, port, -upper, -lower)
    other = plant(truth, Eta(0.0, 0.0, 9.0, -phi, theta, -psi), Nu(*(MIRROR * nu)), n, other_fins)
    size = np.abs(one.nu_dot).max()
    np.testing.assert_allclose(other.nu_dot, MIRROR * one.nu_dot, rtol=1e-10, atol=1e-12 * (1.0 + size))


def test_the_mass_matrix_is_symmetric_and_positive_definite() -> None:
    M = mass_matrix(TRUTH)
    np.testing.assert_allclose(M, M.T, rtol=0.0, atol=1e-9)
    assert np.linalg.eigvalsh(M).min() > 0.0


def test_500_rpm_trims_at_6_ft_per_s_exactly() -> None:
    n, u = TRIM
    assert np.abs(plant(nu=Nu(u, 0.0, 0.0, 0.0, 0.0, 0.0), n=n).nu_dot).max() < 1e-15
    assert plant(nu=Nu(u - 1e-6, 0.0, 0.0, 0.0, 0.0, 0.0), n=n).nu_dot[0] > 0.0
    assert plant(nu=Nu(u + 1e-6, 0.0, 0.0, 0.0, 0.0, 0.0), n=n).nu_dot[0] < 0.0


@pytest.mark.parametrize(
    ("fins", "signs"),
    [
        ((0.1, 0.1, 0.0, 0.0), {2: -1, 4: -1}),  # stern planes down: lift at the stern, bow down
        ((0.0, 0.0, 0.1, 0.1), {1: +1, 5: -1}),  # rudder to port: stern to starboard, bow to port
    ],
)
def test_the_sign_of_a_fin_ahead_and_its_reversal_astern(fins: tuple[float, ...], signs: dict[int, int]) -> None:
    for u, way in ((1.5, 1), (-1.5, -1)):
        nu = Nu(u, 0.0, 0.0, 0.0, 0.0, 0.0)
        tau = mass_matrix(TRUTH) @ (np.array(plant(nu=nu, fins=fins).nu_dot) - np.array(plant(nu=nu).nu_dot))
        for i, sign in signs.items():
            assert tau[i] * sign * way > 1.0


def printed_eps(u: float, n: float) -> float:
    """n in rev/s, u in m/s; for propeller and motion the same way."""
    eta = 0.012 * n * 60.0 / (u / 0.3048)
    C_t, C_t1 = 0.008 * 5.3**2 * eta * abs(eta) / 2.0, 0.008 * 5.3**2 / 2.0
    signs = math.copysign(1.0, n) / math.copysign(1.0, u)
    return -1.0 + signs * (math.sqrt(C_t + 1.0) - 1.0) / (math.sqrt(C_t1 + 1.0) - 1.0)


@given(st.floats(0.05, 4.0), st.floats(0.01, 16.0), st.sampled_from([1.0, -1.0]))
def test_the_race_is_the_printed_one_while_propeller_and_motion_agree(u: float, n: float, way: float) -> None:
    u_eps, abs_u_eps = race(CONSTANTS, way * u, way * n, 1.0)
    expected = printed_eps(way * u, way * n)
    assert u_eps == pytest.approx(way * u * expected, rel=1e-6, abs=1e-9)
    assert abs_u_eps == pytest.approx(u * expected, rel=1e-6, abs=1e-9)


@given(st.floats(0.05, 4.0), st.floats(0.01, 16.0), st.sampled_from([1.0, -1.0]))
def test_damping_in_the_race_is_the_printed_one_also_when_they_oppose(u: float, n: float, way: float) -> None:
    assume(0.012 * n * 60.0 / (u / 0.3048) < 2.9)  # beyond that the printed root is not real
    assert race(CONSTANTS, way * u, -way * n, 1.0)[1] == pytest.approx(u * printed_eps(way * u, -way * n), rel=1e-6)


@given(st.floats(-16.0, 16.0))
def test_the_race_passes_through_rest_without_a_step(n: float) -> None:
    before, at, after = (race(CONSTANTS, u, n, 1.0) for u in (-1e-9, 0.0, 1e-9))
    np.testing.assert_allclose(before, at, rtol=1e-3, atol=1e-2)
    np.testing.assert_allclose(after, at, rtol=1e-3, atol=1e-2)
    assert race(CONSTANTS, 0.0, 0.0, 1.0) == (0.0, 0.0)


@given(st.floats(-4.0, 4.0), st.floats(-16.0, 16.0))
def test_a_disc_half_out_of_the_water_makes_half_the_race_and_one_in_the_air_none(u: float, n: float) -> None:
    assert race(CONSTANTS, u, n, 0.5) == pytest.approx(race(CONSTANTS, u, n * math.sqrt(0.5), 1.0), rel=1e-9, abs=1e-6)
    assert race(CONSTANTS, u, n, 0.0) == pytest.approx((-u, -abs(u)), rel=1e-9, abs=1e-6)


def test_the_immersed_part_is_the_area_of_the_segment() -> None:
    x = np.linspace(-1.0, 1.0, 200_001)
    chord = 2.0 * np.sqrt(1.0 - x**2)
    for s in (-0.9, -0.3, 0.0, 0.4, 0.97):
        assert immersed(s) == pytest.approx(np.trapezoid(np.where(x <= s, chord, 0.0), x) / math.pi, abs=1e-4)
    assert (immersed(-1.0), immersed(0.0), immersed(1.0)) == (0.0, 0.5, 1.0)


@given(st.floats(-0.6, 0.1), st.floats(-1.2, 1.2), st.floats(-0.25, 0.25))
def test_weight_and_buoyancy_have_a_potential_through_the_surface(z: float, phi: float, theta: float) -> None:
    """Z, K and M are the slopes of the potential energy, found by differences."""
    body = dataclasses.replace(TRUTH.body, r_G=(0.05, 0.02, 0.061), r_B=(0.03, -0.01, 0.02))
    c = constants(dataclasses.replace(TRUTH, body=body))
    wet = np.zeros(10)

    def potential(z: float, phi: float, theta: float) -> float:
        k = np.array([-math.sin(theta), math.cos(theta) * math.sin(phi), math.cos(theta) * math.cos(phi)])
        energy = -body.W * (z + k @ np.array(body.r_G))
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            s = (z + 0.265 + k @ np.array(body.r_B) + k[0] * 2.65 * node) / 0.265
            s_ = min(max(s, -1.0), 1.0)
            area = 0.5 * s_ + (math.sqrt(1.0 - s_**2) * (2.0 + s_**2) / 3.0 + s_ * math.asin(s_)) / math.pi
            energy += body.B * 0.5 * weight * 0.265 * (area + max(s - 1.0, 0.0))
        return energy

    k = -math.sin(theta), math.cos(theta) * math.sin(phi), math.cos(theta) * math.cos(phi)
    tau, h = np.zeros(6), 1e-5
    hydrostatics(c, z, *k, wet, tau)
    down = float(np.dot(k, tau[:3]))
    roll = tau[3]
    pitch = math.cos(phi) * tau[4] - math.sin(phi) * tau[5]
    slope = -(potential(z + h, phi, theta) - potential(z - h, phi, theta)) / (2.0 * h)
    assert down == pytest.approx(slope, rel=1e-5, abs=2.0)
    slope = -(potential(z, phi + h, theta) - potential(z, phi - h, theta)) / (2.0 * h)
    assert roll == pytest.approx(slope, rel=1e-5, abs=2.0)
    slope = -(potential(z, phi, theta + h) - potential(z, phi, theta - h)) / (2.0 * h)
    assert pitch == pytest.approx(slope, rel=1e-5, abs=2.0)
