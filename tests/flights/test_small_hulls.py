"""A hull whose buoyancy is a good part of its thrust: it dives more slowly than it swims, and its model knows it."""

from __future__ import annotations

import numpy as np
import pytest
from sternplane.study.safety.campaign import Job
from sternplane.study.safety.flight import written

from firmware_py.records.estimate import VelocitySource
from firmware_py.records.health import SourceState
from tests.shared_flights import Flights
from tests.straight_run import hold, under_way

LEVEL, DOWN = hold(5.0).replace("1.8", "1.5"), "[[orders]]\nt_s = 40.0\ndepth_m = 18.0\n"
DIVE = under_way(80.0, 5.0, LEVEL, DOWN, faults=("off:dvl@36",), rpm=1461.0)


@pytest.mark.parametrize("vehicle", ["remus100", "torpedo_x"])
def test_without_dvl_its_model_dives_as_fast_as_it_does_and_no_pressure_is_accused(
    flown: Flights, vehicle: str
) -> None:
    outcome, log = flown(DIVE, vehicle=vehicle)
    assert outcome.completed
    assert all(cycle.state.sensors.pressure.state is SourceState.GOOD for cycle in log.cycles)
    deep = (log.columns["t"] > 40.0) & (np.degrees(log.truth["eta.theta"]) < -10.0)
    assert deep.sum() > 1000
    true, modelled = log.truth["nu.u"][deep], log.columns["state.nu.u"][deep]
    assert true.mean() < 1.45  # on a level course it would be 1.5 m/s
    assert np.abs(modelled - true).max() < 0.05
    sources = {cycle.state.velocity_source for cycle, at in zip(log.cycles, deep, strict=True) if at}
    assert sources == {VelocitySource.HULL_MODEL}


def test_slow_in_eddies_an_eighth_of_its_speed_it_flies_its_mission(flown: Flights) -> None:
    """Its planes held its bow down against the righting moment, it lost its way, and stood at 50 deg of pitch."""
    outcome, log = flown(written(Job("REMUS 100 at 0.8 m/s: no fault", 0, 1003)), seed=1003, vehicle="remus100")
    assert outcome.completed
    assert log.truth["eta.z"].max() < 29.0
    assert np.degrees(log.truth["eta.theta"]).min() > -45.0


SLOW, DEEPER = hold(8.0).replace("1.8", "0.6"), "[[orders]]\nt_s = 20.0\ndepth_m = 16.0\n"
CREEP = under_way(160.0, 8.0, SLOW, DEEPER, rpm=585.0)


@pytest.mark.parametrize("vehicle", ["remus100", "torpedo_x"])
def test_at_its_least_speed_its_planes_do_not_hold_it_down_beyond_the_depth_that_is_asked(
    flown: Flights, vehicle: str
) -> None:
    """They held against the righting moment at the ends of their travel, and it dived on, at 39 deg, past its limit."""
    outcome, log = flown(CREEP, vehicle=vehicle)
    assert outcome.completed
    z, theta = log.truth["eta.z"], np.degrees(log.truth["eta.theta"])
    assert np.abs(z[-2000:] - 16.0).max() < 0.3
    assert z.max() < 16.8
    assert theta.min() > -35.0
