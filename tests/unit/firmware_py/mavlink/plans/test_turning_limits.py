"""Plans and setpoints are held to the turns that the vehicle can make now."""

from __future__ import annotations

import dataclasses
from typing import Any

from firmware_py.mavlink.plans.plan_store import PlanStore
from firmware_py.records.limits import OperatingLimits
from firmware_py.records.manoeuvrability import RESERVE, UNLIMITED
from firmware_py.records.turning import Turning
from tests.unit.firmware_py.mavlink.station import cycle

TURNING = Turning(30.0, 20.0, 0.07, 1.8, 2.5)


def seen(store: PlanStore, radius: float) -> float:
    """Return the tightest turn of the checks after a cycle in which the vehicle turns with this radius, m."""
    store.update(dataclasses.replace(cycle(0), left=UNLIMITED._replace(turn=1.0 / (RESERVE * radius))))
    return store.limits.turning.turn_radius


def test_circles_are_checked_by_the_tightest_turn_of_the_model_in_force() -> None:
    frame: Any = None
    store = PlanStore(frame, OperatingLimits(30.0, 2.0, TURNING))
    assert seen(store, 16.0) == 20.0
    assert seen(store, 57.3) == 58.0
    assert seen(store, 55.0) == 58.0  # no new check of the whole mission for so little
    store.set_limits(OperatingLimits(25.0, 2.0, TURNING._replace(turn_radius=25.0)))
    assert (store.limits.depth_max, store.limits.turning.turn_radius) == (25.0, 58.0)
    assert seen(store, 69.5) == 70.0
    assert seen(store, 16.0) == 25.0
