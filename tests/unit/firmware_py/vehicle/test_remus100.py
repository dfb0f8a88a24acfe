"""The second hull: as its source has it, and by physics: it keeps its course, turns to the right side, trims."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from firmware_py import params
from firmware_py.estimation.integrity.motion_model import MotionModel
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.vehicle.vehicle import Vehicle
from sim_bridge.truth_file import read_truth

FOLDER = Path(__file__).resolve().parents[4] / "configs" / "remus100"
VEHICLE = params.load(Vehicle, tomllib.loads((FOLDER / "vehicle.toml").read_text()), "vehicle.toml")
TRUTH = read_truth(FOLDER / "truth.toml")
U = 1.54
SOURCE = {  # Prestero (2001): linear model at 1.54 m/s, in SI
    "Z_w": (-66.6, 2, 1),
    "Z_q": (-9.67, 3, 1),
    "Z_ds": (-50.6, 2, 2),
    "M_w": (30.7, 3, 1),
    "M_ds": (-34.6, 3, 2),
}
ADDED = {"X_udot": (-0.93, 3), "Y_vdot": (-35.5, 3), "Z_qdot": (-1.93, 4), "M_qdot": (-4.88, 5), "K_pdot": (-0.0704, 5)}


def flown(
    fins: tuple[float, float], seconds: float, nu: tuple[float, ...] = (U, 0.0, 0.0, 0.0, 0.0, 0.0)
) -> np.ndarray:
    """The state after so long under these fins, rad, at the propeller speed of the trim."""
    neutral = dataclasses.replace(VEHICLE, body=dataclasses.replace(VEHICLE.body, buoyancy=VEHICLE.body.weight))
    model = ObserverModel(neutral, ("M_q",))  # with its buoyancy it rises, unless it is steered
    x = model.state(nu, (0.0, 0.0, 0.0))
    inputs = np.array([*fins, 0.0, VEHICLE.propeller.n_trim])
    for _ in range(round(seconds / 0.01)):
        assert model.advance(x, inputs, 0.01)
    return x


@pytest.mark.parametrize("name", SOURCE)
def test_the_linear_model_is_that_of_the_source(name: str) -> None:
    si, power, speeds = SOURCE[name]
    scale = 0.5 * VEHICLE.hull.density * VEHICLE.hull.length**power * U**speeds
    assert getattr(VEHICLE.coefficients, name) * scale == pytest.approx(si, rel=0.01)


@pytest.mark.parametrize("name", ADDED)
def test_the_added_mass_is_that_of_the_source(name: str) -> None:
    si, power = ADDED[name]
    scale = 0.5 * VEHICLE.hull.density * VEHICLE.hull.length**power
    assert getattr(VEHICLE.coefficients, name) * scale == pytest.approx(si, rel=0.001)


def test_what_is_believed_is_true() -> None:
    true, believed = dataclasses.asdict(TRUTH.coefficients), dataclasses.asdict(VEHICLE.coefficients)
    assert {name: value for name, value in believed.items() if true[name] != value} == {}
    assert (TRUTH.body.m, TRUTH.body.W, TRUTH.body.B) == (
        VEHICLE.body.mass,
        VEHICLE.body.weight,
        VEHICLE.body.buoyancy,
    )


def test_it_trims_at_the_speed_of_its_file() -> None:
    assert flown((0.0, 0.0), 30.0)[0] == pytest.approx(U, abs=0.03)


def test_after_a_push_to_the_side_it_goes_straight_again() -> None:
    x = flown((0.0, 0.0), 40.0, (U, 0.05, 0.0, 0.0, 0.0, 0.1))
    assert abs(x[5]) < math.radians(0.05)
    assert abs(x[1]) < 0.002


def test_a_positive_rudder_turns_to_port_and_a_positive_stern_plane_lowers_the_bow() -> None:
    turned, dived = flown((0.0, math.radians(5.0)), 4.0), flown((math.radians(2.0), 0.0), 2.0)
    assert math.degrees(turned[5]) < -3.0
    assert turned[1] > 0.0  # drifts outwards
    assert math.degrees(dived[7]) < -2.0


def test_what_is_lighter_than_water_is_slowed_down_in_a_dive_and_sped_up_in_a_climb() -> None:
    held = MotionModel(VEHICLE)
    speeds = []
    for theta in (-0.25, 0.0, 0.25):
        for _ in range(3000):
            held.step(0.1, VEHICLE.propeller.n_trim, theta, 0.0, 0.0)
        speeds.append(held.memory.u)
    body, hull = VEHICLE.body, VEHICLE.hull
    drag = 0.5 * hull.density * hull.length**2 * VEHICLE.propeller.C_d0
    change = (body.buoyancy - body.weight) * math.sin(0.25) / drag
    assert speeds == pytest.approx([math.sqrt(U * U - change), U, math.sqrt(U * U + change)], rel=1e-3)
