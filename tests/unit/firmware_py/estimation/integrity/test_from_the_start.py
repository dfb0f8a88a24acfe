"""Sensors that lie from the moment they are switched on: no noise was heard of them, and no depth to compare with."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from firmware_py.records.command import Applied
from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Dvl, Heard, SensorFrame

from .voyage import APPLIED, RESTS, Seen, frozen, named, voyage

G = 9806.65
F = SourceFault
LEVEL = (90.0, 95.0)
FAST = Applied((0.0,) * 4, 11.0, True, False)
"""So fast that the model, which begins at rest, is as fast as the voyage when this dives."""


def suspects(seen: list[Seen]) -> set[tuple[str, SourceFault]]:
    return {(name, health.fault) for _, name, health in named(iter(seen)) if health.state is SourceState.SUSPECT}


def depth_when(seen: list[Seen], sensor: str) -> float:
    """Return the true depth when a sensor was first suspect."""
    return next(s.z for s in seen if getattr(s.health, sensor).state is SourceState.SUSPECT)


def blocked(depth: float, noise: float) -> Any:
    """Return the fault of a pressure port that lets nothing through, before a sensor with noise, m."""
    rng = np.random.default_rng(3)
    return lambda _t, _p: 101325.0 + G * (depth + noise * rng.standard_normal())


def test_a_pressure_frozen_at_the_surface_is_named_when_the_vehicle_has_sunk() -> None:
    seen = list(voyage(25.0, {"pressure": frozen(0.0)}, start=0.3))
    assert suspects(seen) == {("pressure", F.FROZEN)}
    assert depth_when(seen, "pressure") < 1.7
    (error,) = [s.depth_corrected - s.z for s in seen if not math.isnan(s.depth_corrected)]
    assert abs(error) < 0.6


def test_so_it_is_without_dvl_by_propeller_and_pitch() -> None:
    seen = list(voyage(55.0, {"pressure": frozen(0.0)}, start=0.3, dive=(30.0, 60.0), silent=("dvl",), applied=FAST))
    assert suspects(seen) == {("pressure", F.FROZEN)}
    assert depth_when(seen, "pressure") < 5.0


@pytest.mark.parametrize("depth", [0.0, 0.3, 0.8])
def test_of_a_blocked_port_the_deeper_depth_that_is_carried_on_holds(depth: float) -> None:
    seen = list(voyage(30.0, {"pressure": blocked(depth, 0.02)}, start=depth))
    assert ("pressure", F.UNDECIDED) in suspects(seen)
    assert depth_when(seen, "pressure") < 2.0
    assert not seen[-1].believed.pressure.fresh
    assert abs(next(s.depth_corrected - s.z for s in seen if not math.isnan(s.depth_corrected))) < 0.7


@pytest.mark.parametrize("silent", [(), ("dvl",)], ids=["DVL", "no DVL"])
def test_a_sound_vehicle_that_bobs_through_the_surface_is_believed(silent: tuple[str, ...]) -> None:
    """Waves pass over it, and in their troughs it is in the air."""

    rng = np.random.default_rng(4)

    def waves(t: float, _: float) -> float:
        return 101325.0 + G * (max(0.3 + 0.4 * math.sin(0.9 * t), 0.0) + 0.01 * rng.standard_normal())

    seen = list(voyage(90.0, {"pressure": waves}, start=0.3, dive=LEVEL, noise=2.0, silent=silent))
    assert not [found for found in suspects(seen) if found[0] != "fix"]


def test_a_dvl_frozen_at_the_start_is_named_when_the_propeller_has_driven_and_accuses_nobody() -> None:
    seen = list(voyage(30.0, {"dvl": lambda _t, _v: Dvl(0.0, 0.0, 0.0, 0.01, 30.0)}, dive=LEVEL))
    assert ("dvl", F.FROZEN) in suspects(seen)
    assert suspects(seen) <= {("dvl", F.FROZEN), ("dvl", F.UNDECIDED), ("altitude", F.UNDECIDED)}
    assert next(s.t for s in seen if s.health.dvl.fault is F.FROZEN) < 10.0
    assert seen[-1].health.altitude.state is SourceState.GOOD
    assert seen[-1].health.dvl.fault is F.FROZEN


def test_a_dvl_that_repeats_zeros_on_the_bench_is_no_fault() -> None:
    still = {"dvl": lambda _t, _v: Dvl(0.0, 0.0, 0.0, 0.01, 0.4), "altitude": lambda _t, _a: 0.4}
    seen = list(voyage(30.0, {**still, "pressure": lambda _t, _p: 101325.0}, speed=0.0, start=0.0, applied=RESTS))
    assert suspects(seen) == set()


def test_sensors_without_noise_are_believed_on_a_voyage() -> None:
    assert not named(voyage(45.0, noise=0.0))


def drives(t: float, frame: SensorFrame) -> SensorFrame:
    """Let the propeller turn faster from 2 s on."""
    return replace(frame, n=Heard(APPLIED.n if t < 2.0 else FAST.n, t, True, True))


@pytest.mark.parametrize("others", [(), ("pressure",), ("pressure", "dvl")])
def test_an_ahrs_frozen_at_the_start_is_named_when_the_propeller_has_driven(others: tuple[str, ...]) -> None:
    """With a frozen pressure beside it nothing was named, and the vehicle dived at its first order."""
    stuck = {name: frozen(0.0) for name in ("ahrs", *others)}
    seen = list(voyage(30.0, stuck, start=0.3, dive=LEVEL, change=drives))
    assert next(s.t for s in seen if s.health.ahrs.fault is F.FROZEN) < 15.0
    assert seen[-1].health.ahrs.fault is F.FROZEN
    assert suspects(seen) <= {(name, fault) for name in stuck for fault in (F.FROZEN, F.UNDECIDED)}


def test_an_ahrs_that_repeats_itself_on_the_bench_is_no_fault() -> None:
    still = {"ahrs": frozen(0.0), "dvl": frozen(0.0), "altitude": frozen(0.0), "pressure": frozen(0.0)}
    seen = list(voyage(30.0, still, speed=0.0, start=0.0, applied=RESTS))
    assert suspects(seen) == set()


def test_an_altimeter_frozen_at_the_start_is_named_in_a_dive_and_not_the_dvl() -> None:
    seen = list(voyage(30.0, {"altitude": frozen(0.0)}))
    assert ("altitude", F.FROZEN) in suspects(seen)
    assert suspects(seen) <= {("altitude", F.FROZEN), ("altitude", F.UNDECIDED), ("dvl", F.UNDECIDED)}
    assert seen[-1].health.dvl.state is SourceState.GOOD
