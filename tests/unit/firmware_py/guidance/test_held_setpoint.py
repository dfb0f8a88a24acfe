"""What a station's order makes of what is held; above all, that a vehicle that drifts gets under way."""

from __future__ import annotations

import math

import pytest

from firmware_py.guidance.guidance_params import GuidanceParams
from firmware_py.guidance.held_setpoint import held, under_way
from firmware_py.records.order import KEEP_SETPOINT, Setpoint

NAN = math.nan
TURNING = GuidanceParams().turning
DRIFTING, SAILING = Setpoint(5.0, 1.0, 0.2), Setpoint(5.0, 1.0, 0.9)


def test_what_is_not_ordered_stays() -> None:
    for wanted in (DRIFTING, SAILING):
        assert held(wanted, KEEP_SETPOINT, TURNING) == wanted
        assert held(wanted, KEEP_SETPOINT._replace(psi_d=2.0), TURNING) == wanted._replace(psi_d=2.0)


@pytest.mark.parametrize("order", [KEEP_SETPOINT._replace(z_d=8.0), KEEP_SETPOINT._replace(x=60.0, y=0.0)])
def test_a_depth_or_a_place_out_of_a_drift_is_gone_to_at_cruising_speed(order: Setpoint) -> None:
    assert held(DRIFTING, order, TURNING).u_d == TURNING.cruise_speed
    assert held(SAILING, order, TURNING).u_d == SAILING.u_d
    assert held(DRIFTING, order._replace(u_d=0.3), TURNING).u_d == 0.3


def test_what_cannot_be_held_is_cut() -> None:
    assert held(SAILING, Setpoint(-1.0, NAN, 99.0), TURNING) == Setpoint(0.0, 1.0, TURNING.speed_max)
    assert under_way(0.49, TURNING) == TURNING.cruise_speed
    assert under_way(0.5, TURNING) == 0.5
