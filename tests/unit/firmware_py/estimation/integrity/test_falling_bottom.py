"""The bottom falls just as the pressure drifts: alone it does not clear a pressure that all else speaks against."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from firmware_py.records.command import Applied
from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Dvl

from .voyage import BOTTOM, START, Fault, Seen, named, voyage

G = 9806.65
F = SourceFault
DIVE = (60.0, 110.0)
SLOW = Applied((0.0,) * 4, 246.0 / 60.0, True, False)
"""Makes 0.9 m/s, by which a dive of 8 deg goes down by 0.125 m/s."""


def followed(share: float, blind: bool = False) -> dict[str, Fault]:
    """Return a pressure that shows the depth from before the dive, over a bottom that falls by a share of the dive."""
    rng = np.random.default_rng(3)

    def falls(altitude: float) -> float:
        return altitude + share * (BOTTOM - START - altitude)

    def ping(t: float, v: Dvl) -> Any:
        return None if blind and t > 5.0 else v._replace(altitude=falls(v.altitude))

    return {
        "pressure": lambda _t, _p: 101325.0 + G * START + 50.0 * rng.standard_normal(),
        "altitude": lambda _t, a: falls(a),
        "dvl": ping,
    }


def undecided(seen: list[Seen]) -> Seen:
    """Return when the pressure became suspect, which nothing decided before or after."""
    faults = [h.fault for _, name, h in named(iter(seen)) if name == "pressure" and h.state is SourceState.SUSPECT]
    assert set(faults) == {F.UNDECIDED}
    return next(s for s in seen if s.health.pressure.fault is F.UNDECIDED)


@pytest.mark.parametrize("share", [0.7, 1.0, 1.3])
def test_a_pressure_that_the_bottom_alone_speaks_for_is_used_for_3_m_and_then_the_deeper_depth_holds(
    share: float,
) -> None:
    seen = list(voyage(110.0, followed(share), speed=0.9, dive=DIVE, applied=SLOW))
    told = undecided(seen)
    assert told.z - START < 3.5
    assert told.depth_corrected == pytest.approx(told.z, abs=0.4)
    after_it = [s for s in seen if s.t >= told.t]
    assert after_it[-1].z - START > 5.0
    assert not any(s.believed.pressure.fresh for s in after_it)
    assert after_it[-1].health.pressure.fault is F.UNDECIDED  # the bottom does not clear it again
    assert {fault for s in seen for fault in (s.health.ahrs.fault, s.health.dvl.fault)} == {F.NONE, F.UNDECIDED}


def test_so_it_is_without_dvl_by_propeller_and_pitch() -> None:
    seen = list(voyage(110.0, followed(0.8, blind=True), dive=DIVE))
    told = undecided(seen)
    assert told.z - START < 6.0
    assert told.depth_corrected == pytest.approx(told.z, abs=0.5)


def test_a_pressure_that_comes_back_to_the_depth_carried_on_is_believed_again() -> None:
    rng = np.random.default_rng(3)
    faults = followed(1.0)
    lie = faults["pressure"]
    faults["pressure"] = lambda t, p: lie(t, p) if t < 95.0 else p + 50.0 * rng.standard_normal()
    seen = list(voyage(110.0, faults, speed=0.9, dive=DIVE, applied=SLOW))
    assert undecided(seen).t < 95.0
    assert seen[-1].health.pressure.state is SourceState.GOOD
    assert any(s.believed.pressure.fresh for s in seen[-100:])
    assert not math.isnan(seen[-1].believed.pressure.value)
