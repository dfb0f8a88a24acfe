"""The speed through the water that fins are judged by, where the hull is other than its file says."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from firmware_py.safety.actuators.water_speed import Surge, WaterSpeedFilter
from tests.unit.firmware_py.safety.actuator_bench import VEHICLE

DT = 0.2


@pytest.mark.parametrize("lighter", [0.01, -0.01])
@pytest.mark.parametrize("current", [0.0, 0.25])
def test_in_a_dive_a_hull_that_is_a_hundredth_lighter_or_heavier_is_no_other_current(
    lighter: float, current: float
) -> None:
    random, water = np.random.default_rng(1), WaterSpeedFilter(VEHICLE, 0.5, 0.1)
    buoyancy = (1.0 + lighter) * VEHICLE.body.weight
    ahead = replace(VEHICLE, body=replace(VEHICLE.body, buoyancy=buoyancy)).lift_ahead
    u, x = 1.8, None
    for k in range(round(140.0 / DT)):
        theta = math.radians(-13.0) if k * DT > 80.0 else 0.0
        pull = 1.8 + 0.5 * math.sin(k * DT / 6.0)
        u += DT * (water.k * (pull * pull - u * u) + ahead * math.sin(theta))
        measured = u + current * math.cos(theta) + 0.01 * random.standard_normal()
        if x is None:
            x = water.begin(measured, 0.0)
        surge = Surge(pull * pull, 0.0, water.lift(theta), DT, water.unweighed(theta))
        x, _ = water.hear_ahead(water.predict(x, surge, 1.0), measured, 0.0, theta)
        x = water.hear_aside(x, 0.01 * random.standard_normal(), 0.0, DT)
    assert x is not None
    assert abs(u - 1.8) > 0.25  # it does make a difference
    assert x.u == pytest.approx(u, abs=0.15)
