"""The only altitude stays while the vehicle dives: it is in doubt, and the bottom of before holds, until it reacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from firmware_py.estimation.integrity.still_altitude import LENGTH, Sounding, bottom_before
from firmware_py.records.health import SourceFault, SourceState
from firmware_py.records.sensing import Dvl

from .voyage import BOTTOM, Fault, Seen, voyage

F = SourceFault
DIVE = (40.0, 80.0)
"""By 8 deg: 10 m."""


def stuck(t_stuck: float, off: float, noise: float = 0.05) -> Callable[[float, float], float]:
    """Return an altitude that stays, but for its noise, from a time on, when it jumps by so much."""
    rng = np.random.default_rng(7)
    at: list[float] = []

    def says(t: float, altitude: float) -> float:
        if t < t_stuck:
            return altitude
        at.append(altitude)
        return float(at[0] + off + noise * rng.standard_normal())

    return says


def alone(which: str, says: Callable[[float, float], float]) -> dict[str, Fault]:
    """Return the faults of a sensor that says an altitude, while the other tells none."""
    if which == "altitude":
        return {"altitude": says, "dvl": lambda _t, v: v._replace(altitude=math.nan)}
    return {"altitude": lambda _t, _a: None, "dvl": lambda t, v: v._replace(altitude=says(t, v.altitude))}


def flown(which: str, faults: dict[str, Fault], seconds: float = 80.0) -> Iterator[Seen]:
    return voyage(seconds, faults, dive=DIVE)


def told(seen: Seen, which: str) -> float:
    """Return the altitude that is passed on, m."""
    if which == "altitude":
        return seen.believed.altitude.value
    ping: Dvl = seen.believed.dvl.value
    return ping.altitude


@pytest.mark.parametrize("which", ["altitude", "dvl"])
@pytest.mark.parametrize("off", [0.0, 0.9, 2.4])
@pytest.mark.parametrize("t_stuck", [10.0, 38.0, 50.0], ids=["long before", "just before", "in the dive"])
def test_an_altitude_that_stays_in_a_dive_is_in_doubt_after_3_m_and_the_bottom_of_before_holds(
    which: str, t_stuck: float, off: float
) -> None:
    seen = list(flown(which, alone(which, stuck(t_stuck, off))))
    began = next(s.z for s in seen if s.t >= max(t_stuck, DIVE[0]))
    doubted = [s for s in seen if getattr(s.health, which).fault is F.UNDECIDED]
    assert doubted[0].z - began < 3.2
    assert doubted[-1].t > 79.9  # and stays so
    unseen = off if t_stuck < 15.0 else 0.0  # a bottom that leapt away long ago counts as the bottom
    for s in doubted[20:]:
        assert told(s, which) == pytest.approx(BOTTOM + unseen - s.z, abs=0.7)


def track(falls: Callable[[float], float], lag: float, seconds: int, noise: float) -> Iterator[tuple[Sounding, ...]]:
    """Yield the track, second by second, of a vehicle that keeps its altitude of 5 m over a bottom, `lag` s late."""
    rng = np.random.default_rng(11)
    past: tuple[Sounding, ...] = ()
    bottom, z = 20.0, 15.0
    for k in range(10 * seconds):
        bottom += 0.1 * falls(0.1 * k)
        z += 0.1 * (bottom - 5.0 - z) / lag
        if k % 10 == 0:
            past = (*past[-LENGTH + 1 :], Sounding(bottom + noise * float(rng.standard_normal()), z))
            yield past


SLOPES: dict[str, Callable[[float], float]] = {
    "3 deg": lambda t: 0.094 * (t > 20.0),
    "6 deg": lambda t: 0.19 * (t > 20.0),
    "10 deg": lambda t: 0.31 * (t > 20.0),
    "ever steeper": lambda t: 0.004 * t,
    "down and up": lambda t: 0.2 * math.sin(0.05 * t),
    "waves": lambda t: 0.3 * math.sin(0.5 * t) + 0.05,
    "steps": lambda t: 0.6 * (t % 15.0 < 2.0),
}


@pytest.mark.parametrize("falls", SLOPES.values(), ids=SLOPES)
@pytest.mark.parametrize("lag", [4.0, 8.0])
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.035])
def test_an_altitude_that_is_kept_above_a_bottom_that_falls_is_not_in_doubt(
    falls: Callable[[float], float], lag: float, noise: float
) -> None:
    assert all(math.isnan(bottom_before(past)) for past in track(falls, lag, 150, noise))


def test_a_bottom_that_falls_as_the_vehicle_dives_is_believed_again_once_the_altitude_reacts() -> None:
    """By chance the bottom goes down just as the vehicle does, and goes on for 4 s when this has levelled out."""
    rng = np.random.default_rng(7)
    begun: list[float] = []

    def altitude(t: float, a: float) -> float:
        if t >= DIVE[0]:
            begun.append(a)
        fallen = begun[0] - a if begun else 0.0
        return a + fallen + 0.25 * min(max(0.0, t - DIVE[1] - 4.0), 4.0) + 0.03 * float(rng.standard_normal())

    seen = list(flown("altitude", alone("altitude", altitude), 100.0))
    assert {s.health.altitude.fault for s in seen} >= {F.UNDECIDED}
    assert seen[-1].health.altitude.state is SourceState.GOOD


@pytest.mark.parametrize(("drift", "doubted"), [(0.2, False), (0.0, True)])
def test_an_altitude_that_stays_is_in_doubt_only_if_the_depth_that_is_believed_has_changed_too(
    drift: float, doubted: bool
) -> None:
    """Without DVL eddies carry the hull: pitch and speed say that it dives by 0.2 m/s, and the pressure stays."""
    bottoms = [20.0 + 0.2 * max(0, t - 10) for t in range(LENGTH)]
    past = [Sounding(bottom, bottom - 5.0, drift * max(0, t - 10)) for t, bottom in enumerate(bottoms)]
    assert math.isfinite(bottom_before(past)) is doubted
