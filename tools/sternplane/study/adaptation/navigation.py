"""Navigation with the model: a DVL that is lost for two minutes, and a straight leg across a current."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from firmware_py.marine import wrap
from firmware_py.records.cycle import Cycle
from sim_bridge.truth_sample import TruthSample
from sternplane.logs.tracking import Array
from sternplane.study.adaptation.courses import LEG_TIME, demonstration, straight_leg, track
from sternplane.study.adaptation.flight import Course, fly_seen
from sternplane.study.chance import mean_square_at
from sternplane.study.laid_settings import table_now
from sternplane.study.rows import Case, Results, Row, RunArrays

_WITHOUT = "[autopilot.estimation.velocity]\nfilter_std_m_s = 0.0\n"
"""Laid upon a scenario: the velocity of the coefficient filter is never taken."""
_LOST = 120.0
"""The DVL is silent for so long, s."""
_SETTLED = 5.0
"""After so long, s, what the position is off by is no noise of the last pings."""
_SLACK = 1.0
"""What the position may be off by besides the heading's bias, m."""
_CHANCE = 1.96
"""Sigmas within which chance leaves 97.5 % of the walks of pings."""
_STRAIGHT = 0.03
"""What a straight leg may be off by besides look-ahead times the heading's bias, m."""


class Voyage(NamedTuple):
    """Columns over the ticks of a flight, s, m and rad, (ticks,): the truth, the estimate, and the desired depth.

    `completed`: whether its scenario was.
    """

    t: Array
    x: Array
    y: Array
    z: Array
    psi: Array
    est_x: Array
    est_y: Array
    est_psi: Array
    std: Array
    z_d: Array
    completed: bool

    @property
    def yaw_bias(self) -> float:
        """Return what the estimated heading is off by in the mean, rad."""
        return float(np.mean([wrap(off) for off in (self.est_psi - self.psi)[100:].tolist()]))

    def since(self, begin: float, end: float) -> Voyage:
        """Return the part between two times, s."""
        part = (self.t >= begin) & (self.t < end)
        columns = {name: column for name, column in self._asdict().items() if name != "completed"}
        return self._replace(**{name: column[part] for name, column in columns.items()})

    @property
    def path(self) -> float:
        """Return the way over the ground, m."""
        return float(np.sum(np.hypot(np.diff(self.x), np.diff(self.y))))


class _Witness:
    done = False

    def __init__(self) -> None:
        self.rows: list[tuple[float, ...]] = []

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        state, eta = cycle.state, truth.eta
        seen = state.eta.x, state.eta.y, state.eta.psi, state.position_std, cycle.reference.z_d
        self.rows.append((cycle.tick.t, eta.x, eta.y, eta.z, eta.psi, *seen))


def voyage(scenario: str, seed: int, faults: tuple[str, ...] = ()) -> Voyage:
    """Fly a scenario with the vehicle file as it is."""
    witness = _Witness()
    completed = fly_seen(scenario, seed, witness, faults)
    return Voyage._make([*np.array(witness.rows).T, completed])


def lost(voyage: Voyage) -> Array:
    """Return figures of a flight without DVL.

    Its path, m; what the position is off by more than at its beginning, at most, m; the same beyond what the heading's
    bias explains; it over what 1 sigma has grown by; RMS of the depth error, m; and 1. Of one that was not completed:
    no numbers, and 0.
    """
    if not voyage.completed:
        return np.array([*[math.nan] * 5, 0.0])
    off_x, off_y = voyage.est_x - voyage.x, voyage.est_y - voyage.y
    grown = np.hypot(off_x - off_x[0], off_y - off_y[0])
    allowed = voyage.path * abs(voyage.yaw_bias)
    sigma = np.sqrt(np.maximum(voyage.std**2 - voyage.std[0] ** 2, 0.0))  # of what it is off by since
    off = (grown / np.maximum(sigma, 1e-9))[voyage.t > voyage.t[0] + _SETTLED]
    depth = math.sqrt(float(np.mean((voyage.z - voyage.z_d) ** 2)))
    return np.array([voyage.path, np.max(grown), np.max(grown) - allowed, np.max(off), depth, 1.0])


def _lose(seed: int, k: int, course: Callable[[], Course], begin: float, without: bool = True) -> RunArrays:
    """Fly with the velocity of the filter, `without` it too, and with a DVL."""
    del k
    scenario = course().scenario.format(adoption="true")
    silent, end = (f"off:dvl@{begin:g}+{_LOST:g}",), begin + _LOST
    flights = {"filter": (scenario, silent), "oracle": (scenario, ())}
    if without:
        flights["without"] = (_with(scenario, _WITHOUT), silent)
    return {name: lost(voyage(text, seed, faults).since(begin, end)) for name, (text, faults) in flights.items()}


def _judge_loss(runs: Sequence[RunArrays], name: str) -> Results:
    by = {"filter": "by the filter"}
    if all("without" in run for run in runs):
        by["without"] = "by pings and the hull's model alone"
    figures = {key: np.array([run[key] for run in runs]) for key in (*by, "oracle")}
    rows, n = [Row(name, "way over the ground, median, m", float(np.median(figures["filter"][:, 0])), None)], len(runs)
    for key, words in by.items():
        _, grown, beyond, off, depth, _ = figures[key].T
        limits = (_SLACK, 3.0, 1.2) if key == "filter" else (None, None, None)
        rows += [
            Row(name, f"{words}: position, median, m", float(np.median(grown)), None, n),
            Row(name, f"{words}: position less way times yaw bias, worst, m", float(np.max(beyond)), limits[0], n),
            Row(name, f"{words}: position over its sigma, worst", float(np.max(off)), limits[1], n),
            Row(
                name,
                f"{words}: depth RMS over that with DVL, worst",
                float(np.max(depth / figures["oracle"][:, 4])),
                limits[2],
                n,
            ),
        ]
    for key, words in (by | {"oracle": "with a DVL"}).items():
        failed = float(n - np.sum(figures[key][:, 5]))
        rows.append(Row(name, f"{words}: failed flights", failed, None if key == "without" else 0.0, n))
    return Results(rows)


def _cross(seed: int, k: int, biased: bool) -> RunArrays:
    del k
    leg = straight_leg()
    scenario, begin = leg.scenario.format(adoption="true", yaw_bias="0.5" if biased else "0.0"), leg.settled
    flights = {"filter": scenario, "without": _with(scenario, _WITHOUT)}
    return {name: _off_leg(voyage(text, seed), begin) for name, text in flights.items()}


def _off_leg(voyage: Voyage, begin: float) -> Array:
    """Return what a voyage is off the leg from `begin`, s, on, RMS, m; its yaw bias, rad; and 1. See `lost`."""
    if not voyage.completed:
        return np.array([math.nan, math.nan, 0.0])
    part = voyage.since(begin, math.inf)
    aside = part.y + part.x * voyage.yaw_bias  # the leg leads north; the heading's bias leads off it
    return np.array([math.sqrt(float(np.mean(aside**2))), abs(voyage.yaw_bias), 1.0])


def _judge_cross(runs: Sequence[RunArrays], name: str, biased: bool) -> Results:
    rows, n = [], len(runs)
    look_ahead = float(table_now("autopilot")["guidance"]["line_of_sight"]["look_ahead_m"])
    walk, freedom = ping_walk(straight_leg().settled, LEG_TIME)
    chance = math.sqrt(mean_square_at(n * freedom, _CHANCE))
    rows.append(Row(name, "noise of pings added up, RMS over the leg and over boats, m", walk, None))
    for key, words in (("filter", "current by the filter"), ("without", "crab angle low-passed")):
        aside, bias, completed = np.array([run[key] for run in runs]).T
        rms = math.sqrt(float(np.mean(aside**2)))
        limit = math.sqrt(float(np.mean((look_ahead * bias + _STRAIGHT) ** 2))) if biased else walk * chance
        rows += [
            Row(name, f"{words}: off the leg, RMS over seeds, m", rms, limit if key == "filter" else None, n),
            Row(name, f"{words}: off the leg, RMS, worst seed, m", float(np.max(aside)), None, n),
            Row(name, f"{words}: failed flights", float(n - np.sum(completed)), 0.0 if key == "filter" else None, n),
        ]
    return Results(rows)


def ping_walk(begin: float, end: float) -> tuple[float, float]:
    """Return what the noise of pings adds up to across the way, and how many independent squares that is worth.

    A random walk from t = 0 on. Whoever knows how the hull moves through the water, but not the current, knows no more
    of the way over the ground than the mean of the pings tells: the walk is the Cramer-Rao bound of dead reckoning.

    Args:
        begin: of the time over which its mean square is taken, s.
        end: of that time, s.
    """
    dvl = table_now("sensors")["dvl"]
    rate = float(dvl["noise_m_s"]) ** 2 / float(dvl["rate_hz"]) / (1.0 - float(dvl["dropout"]))
    t = np.linspace(begin, end, 200)
    covariance = rate * np.minimum(t[:, None], t[None, :])
    square = float(np.trace(covariance))
    return math.sqrt(square / len(t)), square**2 / float(np.sum(covariance**2))


def _with(scenario: str, over: str) -> str:
    return scenario.replace("[environment]", f"{over}\n[environment]", 1)


def _loss_case(course: Callable[[], Course], begin: float, short: int) -> Case:
    name = f"{course().name}, DVL lost from {begin:g} s"
    about = (
        f"The DVL is silent for {_LOST:g} s. Position: what it is off by more than when the DVL was lost, at most, by "
        "the truth. Three flights of each seed: with the velocity of the coefficient filter, without it (not in the "
        "short form), with a DVL."
    )
    run = functools.partial(_lose, course=course, begin=begin)
    judge = functools.partial(_judge_loss, name=name)
    return Case(name, about, run, judge, 40, short, functools.partial(run, without=False))


def _cross_case(biased: bool, short: int) -> Case:
    name = f"straight leg across 0.2 m/s, {'with' if biased else 'without'} yaw bias"
    about = (
        "A leg to the north in a current to the east, by a DVL without bias. Off the leg: the true path from "
        f"{straight_leg().settled:g} s on, less what dead reckoning itself leads off by the bias of the AHRS's heading "
        "(way times bias). By the RMS over seeds: the noise of pings adds up to a random walk, which nobody can know."
    )
    judge = functools.partial(_judge_cross, name=name, biased=biased)
    return Case(name, about, functools.partial(_cross, biased=biased), judge, 40, short)


NAVIGATION_CASES: tuple[Case, ...] = (
    _loss_case(functools.partial(track, 170.0), 45.0, 1),
    _loss_case(demonstration, 120.0, 1),
    _cross_case(True, 0),
    _cross_case(False, 0),
)
