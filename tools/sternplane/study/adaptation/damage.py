"""The questions of damage: half an axis, and a fin that jams, with what is left of it named and used."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.hull_response import PERIOD
from firmware_py.safety.actuators.share_watch import ShareWatch
from sim_bridge.truth_sample import TruthSample
from sternplane.study.adaptation.courses import demonstration, track
from sternplane.study.adaptation.flight import Course, Design, Witness, flown
from sternplane.study.adaptation.matched_filter import MatchedFilter
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import FINS, vehicle

_PAIRS = {"rudder": ("rudder_upper", "rudder_lower"), "stern plane": ("stern_port", "stern_starboard")}
_EXCITED = math.radians(2.0)
"""Fins that are farther than this from amidships tell what they do."""
_JAM = 10.0
_SILENT = 20.0
"""From then on fins that report nothing report nothing, s."""
_SETTLED = 10.0
"""After a jam the error counts from so much later, s."""
_HEALTHY = 600.0
_NAMED = {"rudder": 3.0, "stern plane": 8.0}
"""Within so much time while excited, s."""
_OVER_MATCHED = 1.5


class AlarmWitness(Witness):
    """Takes down how many fins are named."""

    def __init__(self) -> None:
        super().__init__()
        self.alarms = 0

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle and the truth at its tick."""
        super().see(cycle, truth)
        self.alarms += len(named(cycle))


class DamageWitness(AlarmWitness):
    """Takes down when the fins of an axis are named, and when a matched filter that knows the truth names them.

    Times are of excitation alone: those in which the fins are over 2 deg from amidships, since the fault. The right
    fins are no alarms from then on.
    """

    def __init__(self, kind: str, onset: float) -> None:
        super().__init__()
        self._onset, self._names = onset, _PAIRS[kind]
        self._pair = tuple([i for i, fin in enumerate(vehicle().fins) if fin.name in self._names])
        self._matched = MatchedFilter(ActuatorParams(), vehicle(), self._pair[0], onset)
        self._excited = 0.0
        self.named = self.matched = math.inf

    def see(self, cycle: Cycle, truth: TruthSample) -> None:
        """Take one cycle and the truth at its tick."""
        super().see(cycle, truth)
        t = cycle.tick.t
        if t >= self._onset:
            angle = sum([cycle.applied.fins[i] for i in self._pair]) / len(self._pair)
            self._excited += cycle.tick.dt * (abs(angle) > _EXCITED)
        right = [name for name in named(cycle) if name in self._names]
        if right and t >= self._onset:
            self.alarms -= len(right)
            self.named = min(self.named, self._excited)
        if self._matched.update(cycle) and t >= self._onset:
            self.matched = min(self.matched, self._excited)


def named(cycle: Cycle) -> list[str]:
    """Return the fins that are named in a cycle."""
    return [event.names[0] for event in cycle.events if event.kind is EventKind.ACTUATOR_FAULT]


def _half(seed: int, k: int, kind: str) -> RunArrays:
    onset = (184.0 if kind == "rudder" else 222.0) + 0.5 * (k % 8)  # a turn; a climb, in which the planes move
    witness = DamageWitness(kind, onset)
    lost = f"lost:{_PAIRS[kind][k % 2]}@{onset}"
    errors = flown(demonstration(), seed, 0.0, Design.ADAPTIVE, (lost,), witness)
    found = witness.named, witness.matched, float(witness.alarms), float(errors.completed)
    return {"half": np.array(found)}


def _evaluate_half(runs: Sequence[RunArrays], name: str, kind: str) -> Results:
    named, matched, alarms, completed = np.array([run["half"] for run in runs]).T
    n, rows = len(runs), []
    for word, share in (("median", 50.0), ("worst", 100.0)):
        rows.append(Row(name, f"named after, {word}, s excited", _part(named, share), _NAMED[kind], n))
    rows.append(Row(name, "by the matched filter, median, s excited", _part(matched, 50.0), None, n))
    median, bound = _part(named, 50.0), max(_part(matched, 50.0), PERIOD)
    gust = ShareWatch.gust_time
    rows.append(Row(name, "named over matched filter, medians", median / bound, None, n))
    what = f"named over matched filter, or over {gust:g} s that may be a gust, medians"
    rows.append(Row(name, what, median / max(bound, gust), _OVER_MATCHED, n))
    rows.append(Row(name, "other fins named", float(np.sum(alarms)), 0.0, n))
    rows.append(Row(name, "flights not completed", float(n - np.sum(completed)), 0.0, n))
    return Results(rows)


def _part(values: np.ndarray, percent: float) -> float:
    return float(np.percentile(values, percent, method="higher"))


class Limits(NamedTuple):
    """Greatest RMS of depth, m, and of heading, deg, after a jam; None: not judged."""

    depth: float | None
    heading: float | None


def _jam(seed: int, k: int, course: Callable[[], Course], fin: str, mute: Sequence[str]) -> RunArrays:
    onset = 60.0 if course().name == "track" else 150.0
    angle = _JAM if k % 2 == 0 else -_JAM
    faults = (*(f"silent:{name}@{_SILENT:g}" for name in mute), f"jam:{fin}={angle:g}@{onset}")
    errors = flown(course(), seed, 0.0, Design.ADAPTIVE, faults)
    late = errors.figures(onset + _SETTLED)
    figures = [late[figure] for figure in ("depth", "depth_most", "heading", "heading_most")]
    return {"jam": np.array([*figures, float(errors.completed)])}


def _evaluate_jam(runs: Sequence[RunArrays], name: str, limits: Limits) -> Results:
    depth, depth_most, heading, heading_most, completed = np.array([run["jam"] for run in runs]).T
    n = len(runs)
    return Results(
        [
            Row(name, "depth RMS, worst flight, m", float(np.max(depth)), limits.depth, n),
            Row(name, "greatest depth error, worst flight, m", float(np.max(depth_most)), None, n),
            Row(name, "heading RMS, worst flight, deg", float(np.max(heading)), None, n),
            Row(name, "greatest heading error, worst flight, deg", float(np.max(heading_most)), limits.heading, n),
            Row(name, "flights not completed", float(n - np.sum(completed)), 0.0, n),
        ]
    )


def _healthy(seed: int, k: int) -> RunArrays:
    del k
    found = []
    for eddies in (0.0, 0.05):
        witness = AlarmWitness()
        errors = flown(track(_HEALTHY, eddies), seed, 0.0, Design.ADAPTIVE, (), witness)
        found.append((float(witness.alarms), float(not errors.completed)))
    return {"healthy": np.array(found)}


def _evaluate_healthy(runs: Sequence[RunArrays], name: str) -> Results:
    flights = np.concatenate([run["healthy"] for run in runs])
    n = len(flights)
    return Results(
        [
            Row(name, "fins named faulty", float(np.sum(flights[:, 0])), 0.0, n),
            Row(name, "flights not completed", float(np.sum(flights[:, 1])), 0.0, n),
        ]
    )


def _half_case(kind: str) -> Case:
    name = f"half {kind} lost, demonstration"
    about = (
        f"One {kind} of two makes no force from the moment when fins begin to move. Times count while fins are over "
        "2 deg from amidships. The matched filter has the true coefficients, and knows that the water is still and "
        "when the fault began."
    )
    evaluate = functools.partial(_evaluate_half, name=name, kind=kind)
    return Case(name, about, functools.partial(_half, kind=kind), evaluate, 40, 3)  # a median of one is none


def _jam_case(course: Callable[[], Course], fin: str, limits: Limits, mute: Sequence[str] = (), short: int = 1) -> Case:
    name = f"{fin} jams at 10 deg{', no fin reports' if mute else ''}, {course().name}"
    says = f"no fin reports its angle from {_SILENT:g} s on" if mute else "reports so"
    about = f"It stays at 10 deg, to either side, and {says}. Figures from {_SETTLED:g} s after, by the truth."
    run = functools.partial(_jam, course=course, fin=fin, mute=mute)
    return Case(name, about, run, functools.partial(_evaluate_jam, name=name, limits=limits), 40, short)


_QUIET = "no fault, 600 s of track"
DAMAGE_CASES: tuple[Case, ...] = (
    _half_case("rudder"),
    _half_case("stern plane"),
    _jam_case(track, "stern_port", Limits(0.4, None)),
    _jam_case(demonstration, "stern_port", Limits(0.1, None)),
    _jam_case(track, "rudder_upper", Limits(None, 5.0)),
    _jam_case(track, "stern_port", Limits(0.4, None), FINS),
    _jam_case(track, "rudder_upper", Limits(None, 5.0), FINS, 0),
    Case(
        _QUIET,
        "Nothing is wrong, in still water and again in eddies of 0.05 m/s; no fin may be named.",
        _healthy,
        functools.partial(_evaluate_healthy, name=_QUIET),
        50,
        1,
    ),
)
