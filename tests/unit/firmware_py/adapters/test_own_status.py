"""What the autopilot says of itself in NodeStatus."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from firmware_py.adapters.drivers.dronecan.own_status import (
    CRITICAL,
    ERROR,
    INITIALIZATION,
    OK,
    OPERATIONAL,
    WARNING,
    OwnStatus,
)
from firmware_py.records.event import Cause
from firmware_py.records.health import ALL_GOOD, ActuatorFault, SourceFault, SourceHealth, SourceState, sound
from firmware_py.records.order import Mode
from firmware_py.tick import Tick

LOST = SourceHealth(SourceState.LOST, SourceFault.SILENT)


def cycle(**parts: Any) -> SimpleNamespace:
    state = {"attitude_ok": True, "depth_ok": True, "velocity_ok": True, "leak": False, "sensors": ALL_GOOD}
    mode = {"mode": Mode.HOLD, "cause": Cause.ORDERED, "failsafe": False, "late": 0}
    frame = {"two_senders": 0, "unhealthy": 0, "replaced": 0}
    tables = [{key: parts.get(key, value) for key, value in table.items()} for table in (state, mode, frame)]
    of_state, of_mode, of_frame = (SimpleNamespace(**table) for table in tables)
    actuators = parts.get("actuators", sound(4))
    return SimpleNamespace(state=of_state, mode=of_mode, frame=of_frame, actuators=actuators)


@pytest.mark.parametrize(
    ("parts", "health"),
    [
        ({}, OK),
        ({"velocity_ok": False}, WARNING),
        ({"late": 1}, WARNING),
        ({"leak": True}, WARNING),
        ({"unhealthy": 4}, WARNING),
        ({"sensors": ALL_GOOD._replace(altitude=LOST)}, WARNING),
        ({"actuators": sound(4).__class__((ActuatorFault.NONE,) * 4, ActuatorFault.LOST)}, WARNING),
        ({"failsafe": True}, ERROR),
        ({"failsafe": True, "attitude_ok": False}, CRITICAL),
        ({"failsafe": True, "depth_ok": False}, CRITICAL),
    ],
    ids=str,
)
def test_health_is_that_of_the_vehicle(parts: dict[str, Any], health: int) -> None:
    status = OwnStatus()
    status.update(cycle())
    status.update(cycle(**parts))
    said = status.message(Tick(1234, 10_000_000))
    assert (said.uptime_sec, said.health, said.mode) == (12, health, OPERATIONAL)


def test_it_is_operational_once_attitude_and_depth_are_known_for_the_first_time() -> None:
    status = OwnStatus()
    assert status.message(Tick(0, 10_000_000)).mode == INITIALIZATION
    for known, mode in ((False, INITIALIZATION), (True, OPERATIONAL), (False, OPERATIONAL)):
        status.update(cycle(depth_ok=known))
        assert status.message(Tick(0, 10_000_000)).mode == mode


def test_the_vendors_code_is_mode_and_cause() -> None:
    status = OwnStatus()
    status.update(cycle(mode=Mode.SURFACE, cause=Cause.LEAK, failsafe=True))
    assert status.message(Tick(0, 10_000_000)).vendor_specific_status_code == Mode.SURFACE | Cause.LEAK << 8
