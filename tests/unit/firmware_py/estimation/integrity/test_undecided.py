"""Two sensors contradict each other: both are suspect, and the safer reading holds until something decides."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from firmware_py.estimation.integrity.depth_arbitration import Accused, judge_again
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Dvl, SensorFrame, never

from .voyage import BOTTOM, Fault, Seen, after, named, voyage

G = 9806.65
F = SourceFault
UNDECIDED = (SourceState.SUSPECT, F.UNDECIDED)
LEVEL = (90.0, 95.0)


def bottomless(t: float, frame: SensorFrame) -> SensorFrame:
    """Take away both altitudes: no bottom in reach."""
    dvl = replace(frame.dvl, value=frame.dvl.value._replace(altitude=math.nan))
    return replace(frame, altitude=never(math.nan), dvl=dvl)


def rough(t: float, frame: SensorFrame) -> SensorFrame:
    """Let the bottom rise and fall by a metre."""
    hill = math.sin(0.5 * t)
    dvl = replace(frame.dvl, value=frame.dvl.value._replace(altitude=frame.dvl.value.altitude + hill))
    return replace(frame, altitude=replace(frame.altitude, value=frame.altitude.value + hill), dvl=dvl)


def drifting(rate: float) -> Fault:
    return after(20.0, lambda age, p: p + rate * age * G)


def sinking_dvl(rate: float) -> Fault:
    """A DVL whose w is off, so that the depth that it carries leaves the pressure."""
    return after(20.0, lambda _, v: v._replace(w=v.w + rate))


def suspects(seen: list[Seen]) -> set[tuple[str, SourceFault]]:
    return {(name, health.fault) for _, name, health in named(iter(seen)) if health.state is SourceState.SUSPECT}


@pytest.mark.parametrize("water", [bottomless, rough])
@pytest.mark.parametrize(
    ("faults", "pressure_used"),
    [
        ({"pressure": drifting(-0.15)}, False),
        ({"dvl": sinking_dvl(0.15)}, False),
        ({"pressure": drifting(0.15)}, True),
        ({"dvl": sinking_dvl(-0.15)}, True),
    ],
    ids=["pressure shallower", "DVL deeper", "pressure deeper", "DVL shallower"],
)
def test_pressure_and_dvl_are_both_suspect_and_the_deeper_one_holds_whichever_is_wrong(
    faults: dict[str, Fault], pressure_used: bool, water: Callable[[float, SensorFrame], SensorFrame]
) -> None:
    seen = list(voyage(27.0, faults, dive=LEVEL, change=water))
    assert suspects(seen) == {("pressure", F.UNDECIDED), ("dvl", F.UNDECIDED)}
    first = next(s.t for s in seen if s.health.pressure.state is SourceState.SUSPECT)
    after_it = [s for s in seen if s.t >= first]
    assert {s.believed.pressure.fresh for s in after_it if s.heard.pressure.fresh} == {pressure_used}
    assert all(s.believed.dvl.ok for s in after_it)
    corrected = [s.depth_corrected - s.z for s in after_it if not math.isnan(s.depth_corrected)]
    assert len(corrected) == (not pressure_used)
    assert all(error > -0.1 for error in corrected)  # never believed less deep than it is


@pytest.mark.parametrize(
    ("fault", "kind", "guilty"),
    [("pressure", drifting(-0.15), "pressure"), ("dvl", sinking_dvl(0.4), "dvl")],
    ids=["pressure", "DVL"],
)
def test_a_flat_bottom_tells_which_is_wrong(fault: str, kind: Fault, guilty: str) -> None:
    assert suspects(list(voyage(26.0, {fault: kind}, dive=LEVEL))) == {(guilty, F.DRIFT)}


@pytest.mark.parametrize(
    ("faults", "guilty"),
    [
        ({"pressure": drifting(-0.6)}, "pressure"),
        ({"dvl": after(20.0, lambda age, v: v._replace(w=v.w + min(0.25 * age, 0.6)))}, "dvl"),
    ],
    ids=["pressure", "DVL"],
)
def test_without_a_bottom_propeller_and_pitch_tell_it_when_it_has_become_much(
    faults: dict[str, Fault], guilty: str
) -> None:
    changes = named(voyage(30.0, faults, dive=LEVEL, change=bottomless))
    undecided = [(name, health) for _, name, health in changes if health == UNDECIDED]
    assert {name for name, _ in undecided} == {"pressure", "dvl"}
    told = [(t, name) for t, name, health in changes if health == (SourceState.SUSPECT, F.DRIFT)]
    assert [name for _, name in told] == [guilty]
    assert told[0][0] < 30.0


def test_a_pitch_that_was_off_from_the_start_is_not_laid_upon_the_dvl_alone() -> None:
    fault = after(0.0, lambda _, a: a._replace(theta=a.theta + 0.08))
    assert suspects(list(voyage(20.0, {"ahrs": fault}, dive=LEVEL))) >= {("ahrs", F.UNDECIDED), ("dvl", F.UNDECIDED)}


def test_a_pitch_that_comes_back_wrong_after_a_silence_is_to_blame_alone() -> None:
    def away(t: float, frame: SensorFrame) -> SensorFrame:
        return replace(frame, ahrs=replace(frame.ahrs, fresh=False, t_valid=6.0)) if 6.0 < t < 8.0 else frame

    fault = after(7.0, lambda _, a: a._replace(theta=a.theta + 0.08))
    seen = list(voyage(40.0, {"ahrs": fault}, dive=LEVEL, change=away))
    assert suspects(seen) == {("ahrs", F.UNDECIDED)}


@pytest.mark.parametrize("gap", [0.2, 0.3, 0.4])
def test_a_gap_in_which_no_ahrs_is_lost_acquits_no_dvl(gap: float) -> None:
    def stutters(t: float, frame: SensorFrame) -> SensorFrame:
        bare = bottomless(t, frame)
        return replace(bare, ahrs=replace(bare.ahrs, fresh=False, t_valid=10.0)) if 10.0 < t < 10.0 + gap else bare

    seen = list(voyage(27.0, {"dvl": sinking_dvl(0.15)}, dive=LEVEL, change=stutters))
    assert suspects(seen) == {("pressure", F.UNDECIDED), ("dvl", F.UNDECIDED)}


@pytest.mark.parametrize("w", [-0.2, 0.2, 0.3])
@pytest.mark.parametrize("away", [(0.0, 7.0), (10.0, 12.0)], ids=["late", "gap"])
def test_after_an_ahrs_was_away_a_dvl_that_lies_is_named(w: float, away: tuple[float, float]) -> None:
    def silent(t: float, ahrs: Any) -> Any:
        return None if away[0] <= t < away[1] else ahrs

    lies = after(30.0, lambda _, v: v._replace(w=v.w + w))
    assert ("dvl", F.DRIFT) in suspects(list(voyage(60.0, {"ahrs": silent, "dvl": lies}, dive=(20.0, 50.0))))


def _always(says: tuple[bool, Accused]) -> tuple[bool, Accused]:
    return says


def test_beside_a_dvl_that_is_convicted_a_pitch_stays_suspect_while_the_hull_speaks_against_it() -> None:
    ahrs, dvl = SourceWatch(0.5, 0.5, 9), SourceWatch(1.0, 0.5, 2)
    ahrs.accuse(F.UNDECIDED, 0.0)
    dvl.accuse(F.STEP, 0.0)
    for k in range(200):
        t = 0.1 * k
        says = (True, Accused.PITCH if t < 10.0 else Accused.CARRIED)
        judge_again(t, 0.0, ahrs, dvl, partial(_always, says))
        for watch in (ahrs, dvl):
            watch.memory.t_ok = t
            watch.judge(t, 0.1, 5.0, 0.0)
        assert ahrs.memory.fault is (F.UNDECIDED if t < 14.8 else F.NONE) or 14.8 <= t < 15.2
        assert dvl.memory.fault is F.STEP


@pytest.mark.parametrize("fault", [F.CONTRADICTED, F.CURRENT, F.DRIFT, F.STEP])
def test_a_pitch_in_doubt_beside_a_dvl_that_is_convicted_then_is_believed_again(fault: SourceFault) -> None:
    ahrs, dvl = SourceWatch(0.5, 0.5, 9), SourceWatch(1.0, 0.5, 2)
    for watch in (ahrs, dvl):
        watch.accuse(F.UNDECIDED, 0.0)
    dvl.accuse(fault, 0.0)
    for k in range(100):
        t = 0.1 * k
        judge_again(t, 0.0, ahrs, dvl, lambda: (True, Accused.CARRIED))
        for watch in (ahrs, dvl):
            watch.memory.t_ok = t
            watch.judge(t, 0.1, 5.0, 0.0)
    assert ahrs.memory.fault is F.NONE


def wandering(which: str, rate: float) -> dict[str, Fault]:
    """One of the two altitudes drifts."""
    if which == "altitude":
        return {"altitude": after(20.0, lambda age, a: a + rate * age)}
    return {"dvl": after(20.0, lambda age, v: v._replace(altitude=v.altitude + rate * age))}


@pytest.mark.parametrize("which", ["altitude", "dvl"])
@pytest.mark.parametrize("rate", [-0.3, 0.3])
def test_altitudes_that_part_at_one_depth_are_both_suspect_and_the_nearer_one_holds(which: str, rate: float) -> None:
    seen = list(voyage(25.0, wandering(which, rate), dive=LEVEL))
    assert suspects(seen) == {("altitude", F.UNDECIDED), ("dvl", F.UNDECIDED)}
    last = seen[-1]
    said = {"altitude": last.heard.altitude.value, "dvl": last.heard.dvl.value.altitude}
    nearer = min(said, key=lambda name: said[name])
    for s in seen[-20:]:
        altimeter, ping = s.believed.altitude, s.believed.dvl.value
        assert (altimeter.fresh or not s.heard.altitude.fresh) is (nearer == "altitude") or not s.heard.altitude.fresh
        assert math.isnan(ping.altitude) is (nearer == "altitude")
        assert math.isfinite(ping.u)


@pytest.mark.parametrize("which", ["altitude", "dvl"])
def test_of_two_altitudes_the_one_that_stays_while_the_vehicle_dives_is_suspect(which: str) -> None:
    def stuck(age: float, value: Any) -> Any:
        altitude = 30.0 + 0.03 * math.sin(37.0 * age)
        return value._replace(altitude=altitude) if isinstance(value, Dvl) else altitude

    changes = named(voyage(18.0, {which: after(9.0, stuck)}, start=BOTTOM - 30.0, dive=(9.0, 30.0)))
    assert (which, F.CONTRADICTED) in {(name, health.fault) for _, name, health in changes}


@pytest.mark.parametrize("seed", range(6))
def test_two_altitudes_that_parted_long_ago_are_not_told_apart_by_their_noise(seed: int) -> None:
    """An altimeter 3 s late was 0.5 m off throughout a dive; a sound DVL whose bottom moved by 8 cm was to blame."""
    parted = {
        "altitude": after(5.0, lambda age, a: a + 0.46 * min(age / 30.0, 1.0)),
        "dvl": after(35.0, lambda age, v: v._replace(altitude=v.altitude - 0.01 * age)),
    }
    seen = list(voyage(60.0, parted, dive=(20.0, 50.0), seed=seed))
    assert {fault for _, fault in suspects(seen)} == {F.UNDECIDED}


@pytest.mark.parametrize("stuck", ["altitude", "dvl"])
@pytest.mark.parametrize("rises", [0.2, 0.5])
def test_over_a_rising_bottom_a_dive_acquits_no_altitude_that_is_stuck(stuck: str, rises: float) -> None:
    """Both bottoms wander then, that of the stuck one down, and the nearer one counts."""
    rng = np.random.default_rng(5)

    def risen(t: float) -> float:
        return rises * max(t - 5.0, 0.0)

    def altitude(t: float, a: float) -> float:
        return 34.0 + 0.03 * rng.standard_normal() if stuck == "altitude" else a - risen(t)

    def ping(t: float, v: Dvl) -> Dvl:
        return v._replace(altitude=34.0 + 0.03 * rng.standard_normal() if stuck == "dvl" else v.altitude - risen(t))

    seen = list(voyage(30.0, {"altitude": altitude, "dvl": ping}, dive=(8.0, 30.0)))
    sound = "dvl" if stuck == "altitude" else "altitude"
    assert {fault for name, fault in suspects(seen) if name == sound} == {F.UNDECIDED}
    last = seen[-1].believed
    assert math.isnan(last.dvl.value.altitude) is (stuck == "dvl")
    used = [s.believed.altitude.fresh for s in seen[-20:] if s.heard.altitude.fresh]
    assert any(used) is (stuck == "dvl")


def over(bottom: Callable[[float], float], behind: float) -> dict[str, Fault]:
    """Return what both altitudes measure over a bottom that rises by so many m, by time; the DVL sees it later."""
    return {
        "altitude": lambda t, a: a - bottom(t),
        "dvl": lambda t, v: v._replace(altitude=v.altitude - bottom(t - behind)),
    }


def sawtooth(period: float) -> Callable[[float], float]:
    return lambda t: 12.0 * abs((t / period) % 1.0 - 0.5)


def boulders(t: float) -> float:
    return max(0.0, min(3.2, 9.0 * (0.55 - abs((t % 9.0) - 4.0))))


UNEVEN = {
    "teeth of 6 m every 5 m": (sawtooth(2.8), 0.0),
    "teeth of 6 m every 10 m": (sawtooth(5.6), 0.0),
    "the same, 2 m apart": (sawtooth(5.6), 1.1),
    "teeth of 6 m every 20 m": (sawtooth(11.1), 0.0),
    "up by 8 m": (lambda t: 8.0 * (t > 20.0), 0.25),
    "down by 8 m": (lambda t: -8.0 * (t > 20.0), 0.25),
    "a slope of 30 deg": (lambda t: 1.04 * min(max(t - 12.0, 0.0), 10.0), 0.25),
    "boulders of 3 m": (boulders, 0.2),
}


@pytest.mark.parametrize(("bottom", "behind"), UNEVEN.values(), ids=UNEVEN)
def test_over_an_uneven_bottom_no_altitude_is_suspect(bottom: Callable[[float], float], behind: float) -> None:
    seen = list(voyage(40.0, over(bottom, behind), dive=LEVEL))
    assert suspects(seen) == set()


def test_over_an_uneven_bottom_an_altimeter_that_shows_1_m_is_still_named() -> None:
    teeth = over(sawtooth(5.6), 0.0)
    false = {**teeth, "altitude": after(20.0, lambda _, a: 1.0)}
    seen = list(voyage(25.0, {**false, "dvl": teeth["dvl"]}, dive=LEVEL))
    assert ("altitude", F.STEP) in suspects(seen)
