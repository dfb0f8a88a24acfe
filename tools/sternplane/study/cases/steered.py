"""Is a value right that is called valid where the vehicle only steers: missions, mostly in eddies, fins move little.

There the water moves the vehicle as much as its fins do, and they answer to the water: what is learned of the flow and
what is believed of the eddies may stand in for each other. `honesty` excites the vehicle. A value may be wrong for a
while and right in the end, so each coefficient is judged at all times at which it is valid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from sternplane.study.cases.honesty import FAR, SHARE, Signs, Tables, judged, nothing, ten
from sternplane.study.chance import share_of
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.waypoints import waypoint
from sternplane.study.wrong_vehicle import Factors

DURATION = 90.0
"""s: four passes have taken over by then."""
SCENARIO = """
description = "The estimation study: is valid right on missions."
duration_s = {duration}
completes = "time"
[environment]
turbulence_m_s = {turbulence}
current_ned_m_s = [0.06, 0.08, 0.0]
bottom_depth_m = 40.0   # within range of the DVL
[start]
depth_m = 8.0
u_m_s = {speed}
n_rpm = {n_rpm}
[autopilot.safety]
depth_max_m = 40.0
[[orders]]
t_s = 0.5
arming = "arm"
mode = "mission"
"""
MOST = 6.0
"""So many sigmas no valid value may ever be off: beyond chance; slopes that knew the future made 5 to 13 of them."""
Legs = Sequence[tuple[float, float, float]]
"""Waypoints: north, east, depth, m."""
STRAIGHT: Legs = ((400.0, 0.0, 8.0),)
WINDING: Legs = tuple((50.0 * k, 20.0 * (k % 2), (8.0, 12.0, 16.0)[k // 2 % 3]) for k in range(1, 9))
"""Turns of 40 deg every 30 s, and dives of 4 m."""


class Steered(NamedTuple):
    """A mission, its water, and how the vehicle file is wrong."""

    label: str
    legs: Legs
    turbulence: float
    factors: Callable[[Tables, Signs], Factors] = nothing
    unknown_max: float | None = None
    hull: str = "npsauv2"
    speed: float = 1.8
    n_rpm: float = 492.0

    @property
    def scenario(self) -> str:
        """Its text."""
        legs = "".join([waypoint(place, self.speed) for place in self.legs])
        head = SCENARIO.format(duration=DURATION, turbulence=self.turbulence, speed=self.speed, n_rpm=self.n_rpm)
        return head + legs


SLOW = Steered(
    "REMUS 100 at 1.2 m/s, winding, the ten +-40 %",
    WINDING,
    0.0,
    ten(0.4),
    unknown_max=5.5,
    hull="remus100",
    speed=1.2,
    n_rpm=1169.0,
)
"""It steers little, and most of the ten are wrong by much when the filter is first contradicted."""
WAYS = (
    SLOW,
    Steered("winding, eddies 0.05 m/s", WINDING, 0.05, unknown_max=7.0),
    Steered("straight, eddies 0.05 m/s", STRAIGHT, 0.05),
    Steered("winding, eddies 0.1 m/s", WINDING, 0.1, unknown_max=7.0),
    Steered("winding, eddies 0.05 m/s, the ten +-30 %", WINDING, 0.05, ten(0.3)),
    Steered("winding, eddies 0.02 m/s", WINDING, 0.02),
)
"""`unknown_max`: coefficients of a flight, of ten, that are never valid, on average."""


def _run(seed: int, k: int) -> RunArrays:
    way = WAYS[k % len(WAYS)]
    completed, off, valid = judged(way.scenario, way.hull, way.factors, seed)
    return {
        "way": np.array(k % len(WAYS)),
        "completed": np.array(completed),
        "valid": valid.any(axis=0),
        "z": np.where(valid, np.abs(off), 0.0).max(axis=0),
    }


def evaluate(runs: Sequence[RunArrays]) -> Results:
    """Return the rows: of all flights, then of each way."""
    case = f"valid values, missions, SITL on virtual, current 0.1 m/s, {DURATION:g} s"
    count = max(sum(int(run["valid"].sum()) for run in runs), 1)
    wrong = sum(int((run["z"] > FAR).sum()) for run in runs) / count
    failed = float(sum(not run["completed"] for run in runs))
    share = f"share of the coefficients that were beyond {FAR:g} sigma while valid, all flights"
    rows = [
        Row(case, share, wrong, share_of(count, SHARE), len(runs)),
        Row(case, "flights that were not completed", failed, 0.0),
    ]
    for i, way in enumerate(WAYS):
        of_way = [run for run in runs if int(run["way"]) == i]
        if not of_way:
            continue
        unknown = 10.0 - float(np.mean([run["valid"].sum() for run in of_way]))
        most, n = max(float(run["z"].max()) for run in of_way), len(of_way)
        rows.append(Row(case, f"{way.label}: coefficients that are never valid, of ten", unknown, way.unknown_max, n))
        rows.append(Row(case, f"{way.label}: greatest valid value off at any time, sigmas", most, MOST, n))
    return Results(rows)


CASES = (
    Case(
        "valid is right, steered",
        "Missions of NPS AUV II in eddies, without an excitation, the vehicle file right or the ten 30 % wrong, and of "
        "REMUS 100, slow, the ten 40 % wrong; what is called valid is held against the truth all the time.",
        *(_run, evaluate, 10 * len(WAYS), 3),
    ),
)
