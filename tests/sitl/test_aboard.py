"""Faults aboard the vehicle, in a flight: a station that falls silent, and a rule that says what becomes of it."""

from __future__ import annotations

from pathlib import Path

import pytest
from sternplane.sitl.flight import FlightRequest, fly, prepare

from firmware_py.records.event import Cause
from firmware_py.records.order import Mode
from tests.shared_flights import LEARNING_OFF

SCENARIO = """
description = "Four seconds at 5 m."
duration_s = 4.0
completes = "time"
[start]
depth_m = 5.0
u_m_s = 1.8
n_rpm = 492.0
[autopilot.safety.station]
hold_time_s = 1.0
hold_action = "surface"
[[orders]]
t_s = 0.2
arming = "arm"
mode = "hold"
depth_m = 5.0
heading_deg = 0.0
speed_m_s = 1.8
"""


@pytest.mark.parametrize(
    ("faults", "lost_at"), [((), None), (("lost:station@1.5",), 2.5), (("lost:station@1+0.9",), None)]
)
def test_a_station_that_falls_silent_is_lost_after_the_time_of_the_rule(tmp_path: Path, faults, lost_at) -> None:
    (tmp_path / "hold.toml").write_text(SCENARIO + LEARNING_OFF)
    changed = []
    before = [Mode.DISARMED]

    def watch(cycle) -> None:
        if cycle.mode.mode is not before[-1]:
            before.append(cycle.mode.mode)
            changed.append((cycle.tick.t, cycle.mode.mode, cycle.mode.cause))

    flight = prepare(FlightRequest(scenario=str(tmp_path / "hold.toml"), faults=faults), {})
    fly(flight, tmp_path / "log.mcap", watch)
    assert [mode for _, mode, _ in changed] == [Mode.HOLD] + [Mode.SURFACE] * (lost_at is not None)
    if lost_at is not None:
        t, _, cause = changed[-1]
        assert cause is Cause.STATION_LOST
        assert t == pytest.approx(lost_at, abs=0.05)
