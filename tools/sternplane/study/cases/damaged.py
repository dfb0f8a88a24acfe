"""Is a value right that is called valid after fins were damaged, or the current changed: missions with a wrong file.

The motion alone tells of it: fins go on to report the angles that they were told. What was learned before that is found
is wrong in everything, and must not stay. Values count from `FOUND` s after the damage on.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sternplane.study.cases.honesty import FAR, judged, ten
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import FINS
from sternplane.study.waypoints import waypoint

HULL = "npsauv2"
DURATION, FOUND = 200.0, 30.0
"""s; within the second a mission makes fins move that have been still: what they do not move cannot tell of them."""
MOST = 0.05
"""Share of seconds at which a valid value may be `FAR` off: of a vehicle that is damaged while it still learns for the
first time nobody knows what it was, and what it has become is learned slowly (2 % in eight flights)."""
WRONG = 0.4
"""The ten of the file are off by this share."""
CYCLES_PER_SECOND = 100
SCENARIO = """
description = "The estimation study: is valid right after damage."
duration_s = {duration}
completes = "time"
faults = {faults}
[environment]
turbulence_m_s = {turbulence}
current_ned_m_s = [0.06, 0.08, 0.0]
bottom_depth_m = 40.0
[[orders]]
t_s = 1.0
arming = "arm"
[[orders]]
t_s = 2.0
mode = "mission"
"""
LEGS = ((110.0, -20.0, 5.0), (220.0, 15.0, 10.0), (270.0, 80.0, 6.0), (250.0, 200.0, 10.0), (150.0, 250.0, 6.0))
"""Waypoints: north, east, depth, m; a turn or a change of depth every 40 s."""


class Damaged(NamedTuple):
    """What fails or changes, and when, s; the eddies, m/s; how many of ten may stay unknown, on average."""

    label: str
    faults: tuple[str, ...]
    t: float
    turbulence: float = 0.0
    unknown_max: float | None = 5.0

    @property
    def written(self) -> list[str]:
        """Return the faults as a scenario has them: those without a time of their own at `t`."""
        return [fault if "@" in fault else f"{fault}@{self.t:g}" for fault in self.faults]


def front(axis: str, before: float, behind: float, t: float, lasts: float) -> tuple[str, ...]:
    """Return the current of one axis, m/s, as the hull passes a front: from t on, s, in steps of 0.1 s."""
    steps = round(10.0 * lasts)
    return tuple(
        [
            f"set:current.{axis}={before + (behind - before) * i / steps:.4f}@{t + 0.1 * i:.1f}"
            for i in range(1, steps + 1)
        ]
    )


WAYS = (
    Damaged("all fins halved", tuple([f"weak:{fin}=50" for fin in FINS]), 80.0),
    Damaged("half a rudder as learning begins", ("lost:rudder_upper",), 80.0),
    Damaged("the weight shifts forward by 2 cm", ("ballast:x_G=0.02",), 80.0),
    Damaged("a front with 0.56 m/s less current, in 3 s", front("north", 0.06, -0.5, 80.0, 3.0), 80.0),
    Damaged("the current changes by 0.32 m/s in 10 s", front("east", 0.08, 0.4, 80.0, 10.0), 80.0),
    Damaged("a step of current of 0.36 m/s", ("set:current.north=-0.3",), 80.0),
    Damaged("half a rudder", ("lost:rudder_upper",), 120.0),
    Damaged("half a stern plane as it dives", ("lost:stern_port",), 80.0),
    Damaged("half a rudder, eddies 0.05 m/s", ("lost:rudder_upper",), 120.0, 0.05, None),
)


def _run(seed: int, k: int) -> RunArrays:
    way = WAYS[k % len(WAYS)]
    legs = "".join([waypoint(place, 1.8) for place in LEGS])
    scenario = SCENARIO.format(duration=DURATION, faults=json.dumps(way.written), turbulence=way.turbulence) + legs
    completed, off, valid = judged(scenario, HULL, ten(WRONG), seed)
    after = slice(round((way.t + FOUND) * CYCLES_PER_SECOND), None, CYCLES_PER_SECOND)
    return {
        "way": np.array(k % len(WAYS)),
        "completed": np.array(completed),
        "valid": valid[after].sum(axis=0),
        "wrong": (valid & (np.abs(off) > FAR))[after].sum(axis=0),
        "known": valid[-1],
    }


def evaluate(runs: Sequence[RunArrays]) -> Results:
    """Return the rows: of all flights, then of each way."""
    case = f"valid values after damage, missions, SITL on virtual, current 0.1 m/s, {DURATION:g} s"
    count = max(sum(int(run["valid"].sum()) for run in runs), 1)
    wrong = sum(int(run["wrong"].sum()) for run in runs) / count
    failed = float(sum(not run["completed"] for run in runs))
    share = f"share of valid values beyond {FAR:g} sigma, each second from {FOUND:g} s after the damage on, all flights"
    rows = [
        Row(case, share, wrong, MOST, len(runs)),
        Row(case, "flights that were not completed", failed, 0.0),
    ]
    for i, way in enumerate(WAYS):
        of_way = [run for run in runs if int(run["way"]) == i]
        if of_way:
            unknown = 10.0 - float(np.mean([run["known"].sum() for run in of_way]))
            figure = f"{way.label}: coefficients that are not valid in the end, of ten"
            rows.append(Row(case, figure, unknown, way.unknown_max, len(of_way)))
    return Results(rows)


CASES = (
    Case(
        "valid is right after damage",
        "Missions of NPS AUV II, the ten coefficients of the file 40 % wrong; a fin loses its force and goes on to "
        "report its angle, or the vehicle is sound and its trim or the current changes. What is called valid is held "
        "against what is left of the vehicle.",
        *(_run, evaluate, 10 * len(WAYS), 7),
    ),
)
