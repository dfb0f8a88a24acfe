"""The vehicle at the water surface. z = 0 is afloat and awash: the hull's top touches the surface."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from firmware_py.marine import Eta, Nu
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.packing import mass_matrix
from sim_bridge.plant.plant import Plant

from .plants import CENTRED, CRUISE, TRIM, TRUTH

W, R = 53400.0, 0.265


def new_plant(z: float, theta: float = 0.0, dt: float = 0.01, phi: float = 0.0, **start: Any) -> Plant:
    environment = Environment(EnvironmentParams(), 0, dt)
    return Plant(TRUTH, environment, dt, 1, Eta(0.0, 0.0, z, phi, theta, 0.0), **start)


def tau(plant: Plant) -> np.ndarray:
    return mass_matrix(TRUTH) @ np.array(plant.nu_dot)


@pytest.mark.parametrize(
    ("z", "force"),
    [
        (50.0, 0.0),  # deep: neutral
        (0.0, 0.0),  # awash: neutral
        (-R, W / 2.0),  # half out
        (-2.0 * R, W),  # just out of the water
        (-3.0, W),  # in the air
    ],
)
def test_buoyancy_goes_with_the_volume_in_the_water(z: float, force: float) -> None:
    assert tau(new_plant(z)) == pytest.approx((0.0, 0.0, force, 0.0, 0.0, 0.0), abs=1e-6)


def test_the_force_grows_steadily_as_it_rises() -> None:
    forces = [tau(new_plant(z))[2] for z in np.linspace(0.0, -2.0 * R, 40)]
    assert all(b > a for a, b in pairwise(forces))


def test_the_end_that_comes_out_is_pushed_back() -> None:
    bow_up, bow_down = tau(new_plant(0.0, theta=0.1)), tau(new_plant(0.0, theta=-0.1))
    righting = TRUTH.body.W * 0.061 * np.sin(0.1)  # of the low centre of gravity alone
    assert bow_up[4] < -3.0 * righting
    assert bow_down[4] > 3.0 * righting
    assert tau(new_plant(0.0, phi=0.3))[3] == pytest.approx(-TRUTH.body.W * 0.061 * np.sin(0.3))


def test_lifted_half_out_it_falls_back_and_stays_under() -> None:
    plant = new_plant(-R, dt=0.02)
    depths = []
    for _ in range(6000):
        plant.step(CENTRED, 0.0)
        depths.append(plant.eta.z)
    assert min(depths) >= -R
    assert 0.0 < depths[-1] < 10.0
    assert abs(plant.nu.w) < 0.02


def test_afloat_it_stays_and_dives_under_thrust_alone_when_told() -> None:
    plant = new_plant(0.0, dt=0.02)
    for _ in range(3000):
        plant.step(CENTRED, 0.0)
    assert plant.eta.z == pytest.approx(0.0, abs=1e-9)
    for _ in range(6000):
        plant.step((0.3, 0.3, 0.0, 0.0), TRIM)
    assert plant.eta.z > 5.0


def test_climbing_into_the_surface_it_stays_in_the_water() -> None:
    plant = new_plant(10.0, theta=0.3, dt=0.02, nu0=CRUISE, n0=TRIM)
    highest = plant.eta.z
    for _ in range(6000):
        plant.step(CENTRED, TRIM)
        highest = min(highest, plant.eta.z)
    assert highest < 0.1
    assert highest > -4.0 * R
    assert abs(plant.eta.theta) < 0.3


def fin_effect(z: float, fins: tuple[float, ...]) -> np.ndarray:
    return tau(new_plant(z, nu0=CRUISE, n0=TRIM, fins0=fins)) - tau(new_plant(z, nu0=CRUISE, n0=TRIM))


def test_fins_lose_force_as_they_come_out() -> None:
    upper, lower = (0.0, 0.0, 0.2, 0.0), (0.0, 0.0, 0.0, 0.2)
    deep = fin_effect(10.0, upper)[5]
    assert fin_effect(10.0, lower)[5] == pytest.approx(deep)
    assert fin_effect(0.0, upper)[5] == pytest.approx(0.0, abs=1e-9)  # it stands above an awash hull
    assert fin_effect(0.155, upper)[5] == pytest.approx(deep / 2.0)
    assert fin_effect(0.0, lower)[5] == pytest.approx(deep)
    assert fin_effect(-3.0, (0.2, 0.2, 0.2, 0.2)) == pytest.approx((0.0,) * 6, abs=1e-9)


def test_the_propeller_loses_thrust_as_it_comes_out() -> None:
    def thrust(z: float) -> float:
        return float(tau(new_plant(z, n0=TRIM))[0] - tau(new_plant(z))[0])

    deep = thrust(20.0)
    assert deep == pytest.approx(500.0 * 5.3**2 * 0.00385 * 1.8288**2)
    assert thrust(0.0) == pytest.approx(deep)
    assert thrust(-R) == pytest.approx(deep / 2.0)
    assert thrust(-R - 0.2) == pytest.approx(0.0, abs=1e-9)
    bow_down = new_plant(0.0, theta=-0.3, n0=TRIM)
    assert abs(tau(bow_down)[0] - tau(new_plant(0.0, theta=-0.3))[0]) < 1e-9


def test_in_the_air_there_is_no_water() -> None:
    flying = new_plant(-5.0, nu0=Nu(1.0, 0.5, 0.5, 0.0, 0.0, 0.0), n0=TRIM)
    assert tau(flying) == pytest.approx((0.0, 0.0, W, 0.0, 0.0, 0.0), abs=1e-6)
