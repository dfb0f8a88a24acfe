"""An AHRS that was away and comes back with a wrong pitch is to blame; pressure and DVL, which agree, are not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import SensorFrame, never

from .voyage import DEG, Fault, Seen, after, named, voyage

F = SourceFault
G = 9806.65
LEVEL = (190.0, 195.0)
AWAY = (40.0, 48.0)
Change = Callable[[float, SensorFrame], SensorFrame]


def away(t: float, frame: SensorFrame) -> SensorFrame:
    """Let the AHRS be silent for 8 s, as one that restarts."""
    if not AWAY[0] < t < AWAY[1]:
        return frame
    return replace(frame, ahrs=replace(frame.ahrs, fresh=False, t_valid=AWAY[0]))


def bottomless(t: float, frame: SensorFrame) -> SensorFrame:
    """Take away both altitudes beside."""
    frame = away(t, frame)
    dvl = replace(frame.dvl, value=frame.dvl.value._replace(altitude=math.nan))
    return replace(frame, altitude=never(math.nan), dvl=dvl)


def blind(t: float, frame: SensorFrame) -> SensorFrame:
    """Take away the DVL beside; the altimeter still sees the bottom."""
    frame = away(t, frame)
    return frame if t < 20.0 else replace(frame, dvl=never(frame.dvl.value))


def blind_and_bottomless(t: float, frame: SensorFrame) -> SensorFrame:
    return blind(t, bottomless(t, frame))


def pitch_off(begin: float, degrees: float) -> Fault:
    return after(begin, lambda _, a: a._replace(theta=a.theta + degrees * DEG))


def suspects(seen: list[Seen]) -> set[tuple[str, SourceFault]]:
    return {(name, health.fault) for _, name, health in named(iter(seen)) if health.state is SourceState.SUSPECT}


@pytest.mark.parametrize("degrees", [-30.0, -10.0, 10.0])
@pytest.mark.parametrize("change", [away, bottomless, blind, blind_and_bottomless])
@pytest.mark.parametrize("begin", [38.0, 44.0], ids=["convicted before", "off since it is back"])
def test_a_pitch_that_comes_back_wrong_convicts_no_pressure_and_no_dvl(
    begin: float, change: Change, degrees: float
) -> None:
    """Long after it is no newcomer any more, too: it was in doubt all the time."""
    seen = list(voyage(150.0, {"ahrs": pitch_off(begin, degrees)}, start=25.0, dive=LEVEL, change=change))
    assert {name for name, _ in suspects(seen)} & {"ahrs", "pressure", "dvl"} == {"ahrs"}
    assert all(s.believed.pressure.fresh for s in seen if s.heard.pressure.fresh)
    assert all(s.health.ahrs.state is not SourceState.GOOD for s in seen if s.t > 70.0)


def test_a_sound_pitch_that_was_away_still_lets_a_flat_bottom_convict_the_pressure() -> None:
    drifts: dict[str, Fault] = {"pressure": after(60.0, lambda age, p: p - 0.3 * age * G)}
    seen = list(voyage(70.0, drifts, start=25.0, dive=LEVEL, change=away))
    assert suspects(seen) == {("pressure", F.DRIFT)}


@pytest.mark.parametrize("begin", [60.0, 120.0], ids=["new", "long back"])
def test_without_a_bottom_a_pitch_that_agreed_for_a_minute_speaks_against_the_pressure_again(begin: float) -> None:
    def drifting(age: float, p: Any) -> Any:
        return p - 0.3 * age * G

    seen = list(voyage(begin + 12.0, {"pressure": after(begin, drifting)}, start=25.0, dive=LEVEL, change=bottomless))
    assert ("pressure" in {name for name, _ in suspects(seen)}) == (begin == 120.0)
