"""Angle and gyro of an AHRS are one witness; a sensor under suspicion convicts nobody, and comes back by agreement."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Ahrs, SensorFrame, never

from .voyage import DEG, Fault, Seen, after, named, voyage

G = 9806.65
F = SourceFault
LEVEL = (190.0, 195.0)


def lying(rate: float) -> dict[str, Fault]:
    """Return an AHRS whose pitch follows its own wrong gyro, deg/s, from 20 s on."""
    lie = after(20.0, lambda age, a: a._replace(theta=a.theta + rate * age * DEG, q=a.q + rate * DEG))
    return {"ahrs": lie}


def no_dvl(t: float, frame: SensorFrame) -> SensorFrame:
    return frame if t < 5.0 else replace(frame, dvl=never(frame.dvl.value))


def bottomless(t: float, frame: SensorFrame) -> SensorFrame:
    """Let neither altimeter nor DVL reach the bottom, from 5 s on."""
    return frame if t < 5.0 else replace(frame, dvl=never(frame.dvl.value), altitude=never(math.nan))


def faults(seen: list[Seen], sensor: str) -> set[SourceFault]:
    return {getattr(one.health, sensor).fault for one in seen}


@pytest.mark.parametrize("rate", [0.5, -0.5, 0.3])
def test_a_pitch_that_its_own_gyro_confirms_is_convicted_by_dvl_and_pressure_and_they_are_not(rate: float) -> None:
    seen = list(voyage(50.0, lying(rate), dive=LEVEL))
    assert faults(seen, "ahrs") == {F.NONE, F.UNDECIDED, F.CONTRADICTED}
    assert faults(seen, "dvl") <= {F.NONE, F.UNDECIDED}
    assert faults(seen, "pressure") == {F.NONE}
    assert seen[-1].health.ahrs.fault is F.CONTRADICTED
    convicted = next(one.t for one in seen if one.health.ahrs.fault is F.CONTRADICTED)
    assert convicted - 20.0 <= 10.0 / abs(rate)  # at 10 deg at the latest
    assert not seen[-1].believed.ahrs.ok


def test_a_pitch_that_is_off_and_stays_off_is_not_believed_again_and_one_that_comes_back_is() -> None:
    def turn(t: float) -> float:
        return 0.5 * DEG * ((20.0 <= t < 36.0) - (44.0 <= t < 60.0))

    def lie(t: float, report: Ahrs) -> Ahrs:
        angle = 0.5 * DEG * (min(max(t - 20.0, 0.0), 16.0) - min(max(t - 44.0, 0.0), 16.0))
        return report._replace(theta=report.theta + angle, q=report.q + turn(t))

    seen = list(voyage(115.0, {"ahrs": lie}, dive=LEVEL))
    suspect = [one.t for one in seen if one.health.ahrs.state is SourceState.SUSPECT]
    assert max(b - a for a, b in itertools.pairwise(suspect)) < 0.1  # without a break
    assert 60.0 < suspect[-1] < 110.0
    assert faults(seen, "pressure") == {F.NONE}


def test_a_dvl_that_stepped_does_not_come_back_with_its_step_and_convicts_no_pressure() -> None:
    stepped = after(20.0, lambda _, v: v._replace(w=v.w + 0.5))
    seen = list(voyage(70.0, {"dvl": stepped}, dive=LEVEL))
    assert [name for _, name, _ in named(iter(seen))] == ["dvl"]  # once, and for good
    assert faults(seen, "pressure") == {F.NONE}


def test_a_dvl_whose_step_is_over_is_believed_again() -> None:
    stepped = after(20.0, lambda _, v: v._replace(w=v.w + 0.5), until=30.0)
    changes = named(voyage(90.0, {"dvl": stepped}, dive=LEVEL))
    assert [health.state for _, name, health in changes if name == "dvl"] == [SourceState.SUSPECT, SourceState.GOOD]
    assert 30.0 < changes[-1][0] < 85.0


def test_a_pressure_that_stepped_does_not_come_back_with_its_step() -> None:
    stepped = after(20.0, lambda _, p: p - 2.0 * G)
    seen = list(voyage(150.0, {"pressure": stepped}, dive=LEVEL))
    assert seen[-1].health.pressure.fault is F.STEP


@pytest.mark.parametrize(
    ("rate", "within", "water"),
    [(-0.15, 30.0, bottomless), (-0.3, 12.0, bottomless), (-0.3, 12.0, no_dvl)],
)
def test_without_dvl_a_slow_drift_of_the_pressure_is_seen_over_20_and_60_s(rate, within, water) -> None:  # type: ignore[no-untyped-def]
    drift = after(40.0, lambda age, p: p + rate * age * G)
    seen = list(voyage(40.0 + within + 1.0, {"pressure": drift}, dive=(20.0, 30.0), change=water))
    t, name, health = next(change for change in named(iter(seen)) if change[1] == "pressure")
    assert (name, health.state) == ("pressure", SourceState.SUSPECT)
    assert 0.0 < t - 40.0 <= within


def test_a_bottom_that_leaps_away_from_the_only_altimeter_holds_for_a_minute_and_is_followed_slowly() -> None:
    leapt = after(20.0, lambda _, a: a + 10.0)
    seen = list(voyage(100.0, {"altitude": leapt}, dive=LEVEL, silent=("dvl",)))
    (t, _, first), (t_back, _, last) = [change for change in named(iter(seen)) if change[1] == "altitude"]
    assert (first.state, first.fault) == (SourceState.SUSPECT, F.STEP)
    assert 0.0 < t - 20.0 <= 0.5
    assert last.state is SourceState.GOOD
    assert 80.0 <= t_back <= 87.0
    held = [one for one in seen if t_back + 0.2 < one.t]
    truth = [one.heard.altitude.value - 10.0 for one in held]
    above = [one.believed.altitude.value - z for one, z in zip(held, truth, strict=True)]
    assert all(one.believed.altitude.ok for one in held)
    assert -0.3 < above[0] < 0.5
    assert above[-1] == pytest.approx(0.2 * (held[-1].t - t_back), abs=0.4)


def test_a_bottom_that_leaps_away_and_back_is_used_again_after_5_s() -> None:
    leapt = after(20.0, lambda _, a: a + 10.0, until=26.0)
    changes = named(voyage(40.0, {"altitude": leapt}, dive=LEVEL, silent=("dvl",)))
    assert [health.state for _, name, health in changes if name == "altitude"] == [
        SourceState.SUSPECT,
        SourceState.GOOD,
    ]
    assert changes[-1][0] == pytest.approx(31.0, abs=0.3)


def eddies(strength: float, seed: int) -> Callable[[float, float], float]:
    """Return a pressure, Pa, of a hull that eddies of so many m/s (1 sigma) carry up and down from 5 s on."""
    random, step, now, carried, t_last = np.random.default_rng(seed), 0.05, 0.0, 0.0, 5.0

    def carry(t: float, pressure: float) -> float:
        nonlocal now, carried, t_last
        while t_last < t:
            now += -step * now / 10.0 + strength * math.sqrt(2.0 * step / 10.0) * random.standard_normal()
            carried, t_last = carried + now * step, t_last + step
        return pressure + carried * G

    return carry


@pytest.mark.parametrize("seed", [1001, 1006, 1011])
def test_without_dvl_or_bottom_eddies_of_0_2_m_s_are_no_drift_of_the_pressure(seed: int) -> None:
    seen = list(voyage(120.0, {"pressure": eddies(0.2, seed)}, start=40.0, dive=LEVEL, change=bottomless))
    assert faults(seen, "pressure") == {F.NONE}


def test_headings_that_are_thrown_away_leave_no_gaps_in_the_depth_that_pitch_and_dvl_carry() -> None:
    def spikes(t: float, report: Ahrs) -> Ahrs:
        return report._replace(psi=report.psi + 1.5) if round(t * 100) % 8 == 0 and t > 9.0 else report

    seen = list(voyage(100.0, {"ahrs": spikes}, dive=(10.0, 95.0), start=1.5))
    assert seen[-1].z > 20.0
    assert faults(seen, "ahrs") == {F.NONE, F.OUTLIERS}
    assert faults(seen, "pressure") == {F.NONE}
    assert faults(seen, "dvl") == {F.NONE}
