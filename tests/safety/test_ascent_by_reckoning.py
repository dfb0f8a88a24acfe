"""Coming up where no pressure is believed: that nothing is gained is told by altitude and dead reckoning together."""

from __future__ import annotations

import math
from typing import Any

import pytest

from firmware_py.records.command import AscentStage
from firmware_py.records.event import Cause

from .test_ascent import Rising

LOST = {"depth_ok": False, "altitude": 20.0}


def come_to_rest(seconds: float, **view: Any) -> Rising:
    """Climb from 10 m to 6 m, as the altitude shows, and gain nothing from there on."""
    vehicle = Rising(**LOST)
    for _ in range(8):
        vehicle.go(1.0, -0.5, altitude=vehicle.view["altitude"] + 0.5)
    vehicle.go(seconds, 0.0, **view)
    return vehicle


def test_a_climb_that_ends_under_water_by_altitude_and_reckoning_releases_the_weight_after_climb_time() -> None:
    assert not come_to_rest(42.0).memory.drop
    vehicle = come_to_rest(47.0)
    assert (vehicle.memory.drop, vehicle.memory.stage) == (True, AscentStage.STOPPED)
    assert vehicle.causes[0] is Cause.NO_CLIMB


@pytest.mark.parametrize(
    "view",
    [
        {"altitude": 30.0},
        {"altitude": math.nan},
        {"speed_ok": False},
        {"attitude_ok": False},
        {"z": 0.3},
        {"fix": True},
    ],
    ids=["up by altitude", "no altitude", "no DVL", "no attitude", "up by reckoning", "fix"],
)
def test_where_one_of_the_two_does_not_tell_of_the_deep_the_weight_waits_for_the_clock(view: dict[str, Any]) -> None:
    vehicle = come_to_rest(47.0, **view)
    assert not vehicle.memory.drop
    assert Cause.NO_CLIMB not in vehicle.causes
