"""The estimated state: what follows from its numbers."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from firmware_py.marine import Eta, Nu, body_to_ned, ned_to_body
from firmware_py.records.estimate import StateEstimate


@pytest.mark.parametrize(("phi", "theta"), [(0.0, 0.0), (0.0, -0.7), (0.9, 0.2), (-3.0, 1.4)])
def test_the_vertical_velocity_is_that_of_the_whole_rotation(phi: float, theta: float) -> None:
    nu = Nu(1.5, 0.2, -0.3, 0.0, 0.0, 0.0)
    state = StateEstimate(Eta(0, 0, 9, phi, theta, 2.0), nu, 1.0, 0.1, 0.01, 50.0, True, True, True, False)
    assert state.z_dot == pytest.approx(body_to_ned(phi, theta, 2.0, *nu[:3])[2], abs=1e-12)


@pytest.mark.parametrize("angle", [math.nan, math.inf])
def test_without_attitude_the_vertical_velocity_is_not_known(angle: float) -> None:
    eta, nu = Eta(0, 0, 9, 0.0, angle, 2.0), Nu(1.5, 0.2, -0.3, 0.0, 0.0, 0.0)
    assert math.isnan(StateEstimate(eta, nu, 1.0, 0.1, 0.01, 50.0, False, True, True, False).z_dot)


@pytest.mark.parametrize(("psi", "theta"), [(0.0, 0.0), (2.0, -0.7), (-3.0, 0.4)])
def test_the_speed_through_the_water_is_that_over_the_ground_less_the_water_s(psi: float, theta: float) -> None:
    water = (0.3, -0.2)
    along, *_ = ned_to_body(0.0, theta, psi, *water, 0.0)
    eta, nu = Eta(0, 0, 9, 0.0, theta, psi), Nu(1.5, 0.2, -0.3, 0.0, 0.0, 0.0)
    still = StateEstimate(eta, nu, 1.0, 0.1, 0.01, 50.0, True, True, True, False)
    assert still.through_water == 1.5  # nothing is known of the water
    assert replace(still, water=(0.1, math.inf)).through_water == 1.5
    assert replace(still, water=water).through_water == pytest.approx(1.5 - along, abs=1e-12)
