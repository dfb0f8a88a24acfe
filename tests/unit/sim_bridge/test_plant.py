"""The vehicle in motion, deep under: what it does and what it refuses."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from firmware_py import params
from firmware_py.marine import Eta, Nu
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.packing import mass_matrix
from sim_bridge.plant.plant import AT_REST, Plant
from sim_bridge.plant.plant_error import PlantError
from sim_bridge.plant.truth import FinStation, PlantDropWeight, PlantFin, Truth, without_weight

from .plants import CENTRED, CRUISE, DEEP, TRIM, TRUTH, new_plant, run

# --- the propeller ---------------------------------------------------------------------------------------------------


def test_from_rest_it_reaches_the_trim_speed() -> None:
    plant = new_plant(dt=0.05)
    assert plant.nu_dot == pytest.approx((0.0,) * 6, abs=1e-12)
    run(plant, 1.0, n=TRIM)
    assert plant.nu.u > 0.0
    run(plant, 900.0, n=TRIM)
    assert plant.nu.u == pytest.approx(1.8288, abs=1e-4)


def test_it_stops_and_goes_astern_through_rest() -> None:
    plant = new_plant(dt=0.05, nu0=CRUISE, n0=TRIM)
    speeds = [run(plant, 1.0, n=-TRIM).nu.u for _ in range(600)]
    assert all(b < a for a, b in pairwise(speeds[:101]))
    assert min(abs(u) for u in speeds) < 0.05
    assert speeds[-1] == pytest.approx(-1.8288, abs=0.01)
    assert max(abs(b - a) for a, b in pairwise(speeds)) < 0.1


def test_without_thrust_it_coasts_down_as_quadratic_drag_tells() -> None:
    plant = run(new_plant(nu0=CRUISE), 100.0)
    k = 500.0 * 5.3**2 * 0.00385 / (5454.54 + 500.0 * 5.3**3 * 7.6e-3)
    assert plant.nu.u == pytest.approx(1.8288 / (1.0 + k * 1.8288 * 100.0), rel=1e-4)


@pytest.mark.parametrize("n", [-TRIM, 0.0, TRIM])
def test_any_tumble_dies_down(n: float) -> None:
    generator = np.random.default_rng(3)
    for _ in range(5):
        nu0 = Nu(*generator.uniform(-1.5, 1.5, 3), *generator.uniform(-0.5, 0.5, 3))
        eta0 = Eta(0.0, 0.0, 500.0, *generator.uniform(-1.5, 1.5, 3))
        plant = run(new_plant(dt=0.05, nu0=nu0, eta0=eta0, n0=n), 400.0, n=n)
        assert math.hypot(*plant.nu[:3]) < 2.0
        assert math.hypot(*plant.nu[3:]) < 0.2


# --- steering --------------------------------------------------------------------------------------------------------


def test_positive_rudder_turns_to_port_and_positive_stern_planes_dive() -> None:
    steered = run(new_plant(nu0=CRUISE, n0=TRIM), 20.0, (0.0, 0.0, 0.2, 0.2), TRIM)
    assert steered.nu.r < -0.01
    assert steered.eta.psi < -0.5
    assert steered.eta.y < -1.0
    diving = run(new_plant(nu0=CRUISE, n0=TRIM), 20.0, (0.2, 0.2, 0.0, 0.0), TRIM)
    assert diving.eta.theta < -0.1
    assert diving.eta.z > 55.0
    # the products of inertia alone couple the planes into the horizontal plane
    assert abs(diving.eta.y) < 0.01


def x_layout(truth: Truth) -> Truth:
    hinges = zip(truth.fins, (45.0, 135.0, 45.0, 135.0), strict=True)
    fins = tuple(dataclasses.replace(fin, hinge=math.radians(hinge)) for fin, hinge in hinges)
    return dataclasses.replace(truth, fins=fins)


def test_an_x_layout_steers_as_a_plus_layout_does() -> None:
    """With delta_s = sum 1/2 cos(hinge) d and delta_r = sum 1/2 sin(hinge) d, d = (s cos + r sin) of each fin."""
    ds, dr = 0.12, -0.07
    root = math.sqrt(0.5)
    crossed = ((ds + dr) * root, (dr - ds) * root) * 2
    plus = new_plant(nu0=CRUISE, n0=TRIM, fins0=(ds, ds, dr, dr))
    cross = new_plant(x_layout(TRUTH), nu0=CRUISE, n0=TRIM, fins0=crossed)
    assert cross.nu_dot == pytest.approx(plus.nu_dot, rel=1e-12, abs=1e-15)
    assert max(map(abs, plus.nu_dot)) > 0.001


def with_bow() -> Truth:
    bow = tuple(
        PlantFin(f"bow_{side}", FinStation.BOW, 0.0, (1.4, y, 0.0), 0.05) for side, y in (("port", -0.4), ("stbd", 0.4))
    )
    return dataclasses.replace(TRUTH, fins=(*TRUTH.fins, *bow))


def test_bow_planes_lift_bow_and_body_each_side_with_half() -> None:
    still = mass_matrix(TRUTH) @ np.array(new_plant(with_bow(), nu0=CRUISE, n0=TRIM).nu_dot)
    both = new_plant(with_bow(), nu0=CRUISE, n0=TRIM, fins0=(*CENTRED, 0.1, 0.1))
    port = new_plant(with_bow(), nu0=CRUISE, n0=TRIM, fins0=(*CENTRED, 0.1, 0.0))
    tau, one = (mass_matrix(TRUTH) @ np.array(plant.nu_dot) - still for plant in (both, port))
    assert tau[2] == pytest.approx(2.0 * -1.3e-2 * 500.0 * 5.3**2 * 1.8288**2 * 0.1)
    assert tau[4] == pytest.approx(2.0 * 3.5e-3 * 500.0 * 5.3**3 * 1.8288**2 * 0.1)
    np.testing.assert_allclose(one, tau / 2.0, atol=1e-9)
    rising = run(new_plant(with_bow(), nu0=CRUISE, n0=TRIM), 1.0, (*CENTRED, 0.2, 0.2), TRIM)
    assert rising.eta.theta > 0.0
    assert run(rising, 20.0, (*CENTRED, 0.2, 0.2), TRIM).eta.z < 49.8


def test_without_its_drop_weight_the_vehicle_is_lighter_by_it_and_rises() -> None:
    plant = new_plant()
    run(plant, 5.0)
    assert plant.eta == pytest.approx(DEEP, abs=1e-9)
    plant.release_weight()
    plant.release_weight()
    assert plant.drop_weight == 0.0
    plant.step(CENTRED, 0.0)
    left = dataclasses.replace(TRUTH, body=without_weight(TRUTH.body, TRUTH.drop_weight))
    pull = (0.0, 0.0, -1335.0, 0.0, 1335.0 * 1.75, 0.0)  # of what is missing
    assert plant.nu_dot == pytest.approx(np.linalg.solve(mass_matrix(left), pull), abs=1e-3)
    run(plant, 60.0)
    assert plant.eta.z < 30.0


def test_the_body_without_its_drop_weight_balances_about_what_is_left() -> None:
    weight = TRUTH.drop_weight
    left = without_weight(TRUTH.body, weight)
    share = weight.W / TRUTH.body.W
    assert left.m / TRUTH.body.m == left.W / TRUTH.body.W == pytest.approx(1.0 - share)
    moment = [left.m * g + share * TRUTH.body.m * r for g, r in zip(left.r_G, weight.r, strict=True)]
    assert moment == pytest.approx([TRUTH.body.m * g for g in TRUTH.body.r_G])
    assert TRUTH.body.I_y - left.I_y == pytest.approx(share * TRUTH.body.m * (1.75**2 + 0.15**2))


def test_a_vehicle_without_a_drop_weight_has_nothing_to_release() -> None:
    plant = new_plant(dataclasses.replace(TRUTH, drop_weight=None))
    plant.release_weight()
    run(plant, 5.0)
    assert plant.drop_weight == 0.0
    assert plant.eta == pytest.approx(DEEP, abs=1e-9)


@pytest.mark.parametrize("W", [53400.0, 50000.0])
def test_a_drop_weight_that_no_body_can_hold_is_refused(W: float) -> None:
    weight = PlantDropWeight(W, (1.75, 0.0, 0.15))
    with pytest.raises(params.ParamError):
        dataclasses.replace(TRUTH, drop_weight=weight)


def test_a_damaged_fin_gives_what_is_left_of_it() -> None:
    one_lost = tuple(dataclasses.replace(fin, effectiveness=float(i != 2)) for i, fin in enumerate(TRUTH.fins))
    whole, half = (
        new_plant(truth, nu0=CRUISE, n0=TRIM, fins0=(0.0, 0.0, 0.1, 0.1))
        for truth in (TRUTH, dataclasses.replace(TRUTH, fins=one_lost))
    )
    run(whole, 1.0, (0.0, 0.0, 0.1, 0.1), TRIM)
    run(half, 1.0, (0.0, 0.0, 0.1, 0.1), TRIM)
    assert half.nu.r == pytest.approx(0.5 * whole.nu.r, rel=0.02)
    lost = tuple(dataclasses.replace(fin, effectiveness=0.0) for fin in TRUTH.fins)
    limp = new_plant(dataclasses.replace(TRUTH, fins=lost), nu0=CRUISE, n0=TRIM)
    run(limp, 5.0, (0.3, 0.3, 0.3, 0.3), TRIM)
    assert limp.nu.r == pytest.approx(0.0, abs=1e-12)


# --- what it shows and refuses ---------------------------------------------------------------------------------------


def test_altitude_is_counted_from_the_flat_bottom() -> None:
    assert new_plant(sea=EnvironmentParams(bottom_depth=80.0)).altitude == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"dt": 0.0}, r"dt = 0.0 s in 1 substeps: both must be positive"),
        ({"dt": math.nan}, "must be positive"),
        ({"substeps": 0}, "in 0 substeps"),
        ({"fins0": (0.0,)}, "1 fin angles for a vehicle with 4 fins"),
    ],
)
def test_a_bad_start_is_refused(start: dict[str, Any], message: str) -> None:
    dt = start.pop("dt", 0.01)
    with pytest.raises(PlantError, match=message):
        Plant(TRUTH, Environment(EnvironmentParams(), 0, 0.01), dt, eta0=DEEP, nu0=AT_REST, **start)


def test_a_bad_command_is_refused_and_a_broken_state_is_told() -> None:
    plant = new_plant(nu0=CRUISE)
    with pytest.raises(PlantError, match="5 fin angles for a vehicle with 4 fins"):
        plant.step((0.0,) * 5, 0.0)
    assert plant.k == 0
    with pytest.raises(PlantError, match=r"no longer finite at t = 0\.010 s"):
        plant.step((0.0, math.nan, 0.0, 0.0), 0.0)
    with pytest.raises(PlantError, match="no longer finite"):
        new_plant().step(CENTRED, math.nan)
