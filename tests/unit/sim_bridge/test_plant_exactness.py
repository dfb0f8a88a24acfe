"""How exactly the plant moves: in a current, over time, through the vertical, twice."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.marine import Eta, Nu, body_to_ned
from sim_bridge.plant.environment import EnvironmentParams
from sim_bridge.plant.packing import S, mass_matrix
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import PlantCoefficients

from .plants import CENTRED, CRUISE, DEEP, TRIM, TRUTH, new_plant, run


def motion(plant: Plant) -> str:
    """Return all that can be seen of a plant, to the bit."""
    return repr((plant.eta, plant.nu, plant.nu_dot, plant.nu_r, plant.n, plant.n_dot, plant.fins, plant.current_ned))


# --- the current -----------------------------------------------------------------------------------------------------


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.tuples(*[st.floats(-1.4, 1.4)] * 3))
@settings(max_examples=20)
def test_a_drifting_vehicle_goes_with_the_water_and_feels_nothing(
    current: tuple[float, float, float], attitude: tuple[float, float, float]
) -> None:
    body = dataclasses.replace(TRUTH.body, r_G=(0.0, 0.0, 0.0))  # no righting moment: any attitude is at rest
    phi, theta, psi = attitude
    axes = [body_to_ned(phi, theta, psi, *axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    drift = Nu(*(float(np.dot(axis, current)) for axis in axes), 0.0, 0.0, 0.0)
    sea = EnvironmentParams(current)
    plant = new_plant(
        dataclasses.replace(TRUTH, body=body), sea=sea, nu0=drift, eta0=DEEP._replace(phi=phi, theta=theta, psi=psi)
    )
    assert plant.nu_dot == pytest.approx((0.0,) * 6, abs=1e-12)
    run(plant, 1.0)
    assert plant.eta[:3] == pytest.approx(tuple(np.array(DEEP[:3]) + current), abs=1e-9)
    assert plant.nu_r == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_in_a_uniform_current_the_path_is_that_of_still_water_carried_along() -> None:
    current = np.array([0.4, -0.3, 0.05])
    still = new_plant(nu0=CRUISE, n0=TRIM)
    drift = Nu(*(np.array(CRUISE[:3]) + current), 0.0, 0.0, 0.0)
    carried = new_plant(sea=EnvironmentParams(tuple(current)), nu0=drift, n0=TRIM)
    for k in range(3000):
        fins = (0.1, 0.1, 0.2 if k < 1500 else -0.2, 0.1)
        still.step(fins, TRIM)
        carried.step(fins, TRIM)
    assert carried.eta[:3] == pytest.approx(tuple(np.array(still.eta[:3]) + 30.0 * current), abs=1e-8)
    assert carried.eta[3:] == pytest.approx(still.eta[3:], abs=1e-9)
    assert carried.nu_r == pytest.approx(still.nu[:3], abs=1e-9)
    assert carried.current_ned == tuple(current)


def test_a_vehicle_at_rest_is_taken_along_by_the_current() -> None:
    plant = run(new_plant(dt=0.05, sea=EnvironmentParams((0.0, 0.3, 0.0))), 200.0)
    assert plant.nu_dot[1] > 0.0
    assert plant.eta.y > 30.0
    assert 0.2 < plant.nu.v < 0.3


def test_turbulence_shakes_it_the_same_way_for_the_same_seed() -> None:
    rough = EnvironmentParams(turbulence=0.1, turbulence_time=2.0)
    paths = [run(new_plant(sea=rough, nu0=CRUISE, n0=TRIM), 20.0, n=TRIM) for _ in range(2)]
    assert motion(paths[0]) == motion(paths[1])
    assert paths[0].eta.y != 0.0
    assert 1e-3 < abs(paths[0].eta.y) < 5.0


# --- exactness -------------------------------------------------------------------------------------------------------


def end_of(dt: float) -> np.ndarray:
    fins = (0.1, 0.05, 0.15, 0.1)
    servo = dataclasses.replace(TRUTH.servo, backlash=0.0)
    eta0 = Eta(0.0, 0.0, 200.0, 0.2, 0.1, 0.0)
    nu0 = Nu(1.8, 0.3, -0.2, 0.1, 0.1, -0.1)
    plant = new_plant(dataclasses.replace(TRUTH, servo=servo), dt=dt, eta0=eta0, nu0=nu0, n0=TRIM, fins0=fins)
    run(plant, 6.4, fins, TRIM)
    return np.array([*plant.eta, *plant.nu])


def test_the_integration_is_of_fourth_order() -> None:
    exact = end_of(0.0125)
    errors = [np.abs(end_of(dt) - exact).max() for dt in (0.4, 0.2, 0.1)]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.35)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.35)
    assert errors[2] < 1e-5


def test_substeps_are_steps() -> None:
    one = new_plant(dt=0.04, substeps=4, nu0=CRUISE, n0=TRIM)
    four = new_plant(dt=0.01, nu0=CRUISE, n0=TRIM)
    fins = (0.1, 0.1, -0.1, -0.1)
    run(one, 8.0, fins, TRIM)
    run(four, 8.0, fins, TRIM)
    assert one.eta == pytest.approx(four.eta, abs=1e-12)
    assert one.t == pytest.approx(four.t)
    assert (one.k, four.k) == (200, 800)


def test_without_drag_energy_is_kept() -> None:
    """A heavy-tailed light body tumbles up a fluid that neither drags nor lifts: kinetic and potential energy trade."""
    truth = dataclasses.replace(
        TRUTH,
        body=dataclasses.replace(TRUTH.body, r_G=(0.05, 0.02, 0.2), W=52000.0),
        hull=dataclasses.replace(TRUTH.hull, C_dy=0.0, C_dz=0.0),
        propeller=dataclasses.replace(TRUTH.propeller, C_d0=0.0),
        coefficients=PlantCoefficients(**{field.name: 0.0 for field in dataclasses.fields(PlantCoefficients)}),
    )
    plant = new_plant(truth, eta0=Eta(0.0, 0.0, 2000.0, 1.0, 0.5, 0.0), nu0=Nu(0.5, 0.3, -0.4, 0.3, -0.2, 0.4))
    M, body = mass_matrix(truth), truth.body

    def energies() -> tuple[float, float]:
        phi, theta = plant.eta.phi, plant.eta.theta
        down = np.array([-math.sin(theta), math.cos(theta) * math.sin(phi), math.cos(theta) * math.cos(phi)])
        nu = np.array(plant.nu)
        return 0.5 * nu @ M @ nu, body.B * plant.eta.z - body.W * (plant.eta.z + down @ np.array(body.r_G))

    start = energies()
    traded, lost = 0.0, 0.0
    for _ in range(3000):
        plant.step(CENTRED, 0.0)
        kinetic, potential = energies()
        traded = max(traded, abs(kinetic - start[0]))
        lost = max(lost, abs(kinetic + potential - sum(start)))
    assert traded > 1000.0
    assert lost < 1e-7 * traded


def test_nu_dot_is_the_slope_of_nu() -> None:
    rough = EnvironmentParams((0.2, 0.1, 0.0))
    plant = run(new_plant(dt=0.001, sea=rough, nu0=CRUISE, n0=TRIM), 2.0, (0.1, 0.1, 0.2, 0.2), TRIM)
    before = np.array(plant.nu)
    plant.step((0.1, 0.1, 0.2, 0.2), TRIM)
    slope = np.array(plant.nu_dot)
    plant.step((0.1, 0.1, 0.2, 0.2), TRIM)
    np.testing.assert_allclose((np.array(plant.nu) - before) / 0.002, slope, rtol=1e-4, atol=1e-7)


@given(st.tuples(*[st.floats(-1.5, 1.5)] * 3))
def test_the_attitude_given_is_the_attitude_read(attitude: tuple[float, float, float]) -> None:
    assert new_plant(eta0=Eta(1.0, 2.0, 50.0, *attitude)).eta == pytest.approx((1.0, 2.0, 50.0, *attitude), abs=1e-7)


def test_it_passes_the_vertical_without_a_jump() -> None:
    """A loop: 20 deg of stern planes, no righting moment."""
    body = dataclasses.replace(TRUTH.body, r_G=(0.0, 0.0, 0.0))
    plant = new_plant(dataclasses.replace(TRUTH, body=body), nu0=CRUISE, n0=TRIM, eta0=DEEP._replace(z=500.0))
    down, rates = [], []
    for _ in range(12000):
        plant.step((-0.35, -0.35, 0.0, 0.0), TRIM)
        down.append(-math.sin(plant.eta.theta))
        rates.append(plant.nu.q)
    assert min(down) < -0.9999
    assert max(abs(b - a) for a, b in pairwise(down)) < 0.005
    assert max(abs(b - a) for a, b in pairwise(rates)) < 0.005


def test_the_attitude_stays_a_rotation_however_coarse_the_step() -> None:
    plant = new_plant(dt=0.25, nu0=Nu(1.0, 0.5, 0.5, 1.5, 1.0, -1.0), eta0=DEEP._replace(z=1000.0))
    for _ in range(400):
        plant.step(CENTRED, 0.0)
        assert np.linalg.norm(plant._state[S.e0 : S.u]) == pytest.approx(1.0, abs=1e-14)


def test_the_same_commands_give_the_same_bytes() -> None:
    states = []
    for _ in range(2):
        plant = new_plant(sea=EnvironmentParams((0.1, 0.0, 0.0), 0.05))
        for k in range(1000):
            plant.step((0.2 * math.sin(k / 50.0), 0.1, -0.1, 0.05), TRIM)
        states.append(motion(plant))
    assert states[0] == states[1]
