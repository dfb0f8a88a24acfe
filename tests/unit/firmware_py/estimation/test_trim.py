"""The centre of gravity, forward of where the file has it: the coefficients are wrong where it is not learned."""

from __future__ import annotations

import numpy as np

from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.observer_model import X_G, ObserverModel
from firmware_py.records.event import Cause
from tests.estimation.cases import TRUTH, VEHICLE
from tests.estimation.flights import flown, learner, moments, said

SHIFT = 0.02
OF_PLANES = ("M_q", "M_ds", "Z_ds")


def sigmas(*nuisances: str) -> tuple[dict[str, float], tuple[float, float]]:
    """How far each valid coefficient of the planes is off after the flight, sigma; x_G and its sigma, m."""
    vehicle = learner(nuisances=nuisances)
    last = said(vehicle, moments(flown(x_G=SHIFT)))[-1]
    truth = [getattr(TRUTH.coefficients, name) for name in TEN]
    each = zip(TEN, last.value, last.std, last.valid, truth, strict=True)
    found = {name: abs(x - true) / std for name, x, std, ok, true in each if ok and name in OF_PLANES}
    known, place = vehicle.ekf.estimate(), vehicle.ekf.model.first + len(TEN)
    return found, (known.mean[place], known.covariance[place, place] ** 0.5)


def test_it_is_learned_and_the_coefficients_are_right_with_it() -> None:
    off, (x_G, std) = sigmas(X_G, "buoyancy")
    assert abs(x_G - SHIFT) < 4.0 * std < 0.5 * SHIFT
    assert {"M_q", "M_ds"} <= off.keys()
    assert max(off.values()) < 4.0


def test_it_may_be_one_of_those_that_are_learned_and_told() -> None:
    vehicle = learner(names=(*TEN, X_G), nuisances=("buoyancy",))
    last = said(vehicle, moments(flown(x_G=SHIFT)))[-1]
    assert abs(last.value[-1] - SHIFT) < 4.0 * last.std[-1] < 0.5 * SHIFT
    assert (last.excited[-1], last.valid[-1]) == (True, True)
    assert Cause.NOT_FINITE not in [part.cause for part in last.report]


def test_without_it_nothing_of_the_planes_is_known() -> None:
    assert sigmas("buoyancy")[0] == {}


def test_a_unit_of_it_is_the_moment_of_the_weight() -> None:
    """In a climb with heel, by the difference of the rates: what inertia adds is small where nothing turns."""
    model = ObserverModel(VEHICLE, [X_G])
    inputs = np.array([0.1, -0.05, 0.0, 8.0])
    ends = []
    for x_G in (-1e-3, 1e-3):
        x = model.state([1.8, 0.05, 0.02, 0.0, 0.0, 0.0], [0.2, 0.15, 0.5])
        x[model.first] = x_G
        ends.append(np.array(model.rates(x, inputs)[:6]))
    x = model.state([1.8, 0.05, 0.02, 0.0, 0.0, 0.0], [0.2, 0.15, 0.5])
    assert model.advance(x, inputs, 1e-3)
    force = model.unit_forces()[:, 0]
    np.testing.assert_allclose(model.arrays.inverse_mass @ force, (ends[1] - ends[0]) / 2e-3, rtol=0.05, atol=0.02)
    assert force[4] < 0.0 < force[5]
