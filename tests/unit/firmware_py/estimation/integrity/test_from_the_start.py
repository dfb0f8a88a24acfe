"""Sensors that lie from the moment they are switched on: no noise was heard of them, and no depth to compare with."""

from __future__ import annotations

from firmware_py.records.command import Applied
from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Dvl

from .voyage import Seen, frozen, named, voyage

F = SourceFault
LEVEL = (90.0, 95.0)
RESTS = Applied((0.0,) * 4, 0.0, False, False)


def suspects(seen: list[Seen]) -> set[tuple[str, SourceFault]]:
    return {(name, health.fault) for _, name, health in named(iter(seen)) if health.state is SourceState.SUSPECT}


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


def test_an_altimeter_frozen_at_the_start_is_named_in_a_dive_and_not_the_dvl() -> None:
    seen = list(voyage(30.0, {"altitude": frozen(0.0)}))
    assert ("altitude", F.FROZEN) in suspects(seen)
    assert suspects(seen) <= {("altitude", F.FROZEN), ("altitude", F.UNDECIDED), ("dvl", F.UNDECIDED)}
    assert seen[-1].health.dvl.state is SourceState.GOOD
