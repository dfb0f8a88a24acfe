"""Is it the law or the learning: sliding mode beside PID laws whose gains an optimiser found on the nominal vehicle.

All fly the same references with the same feed-forward, on the nominal vehicle, with a vehicle file that is 50 % wrong,
and with fins that lose half of their force.
"""

from __future__ import annotations

import enum
import functools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sternplane.logs.tracking import Array
from sternplane.study.adaptation.courses import halved, slow_turns, track
from sternplane.study.adaptation.flight import Course, flown_as
from sternplane.study.rows import FEW, Case, Results, Row, RunArrays
from sternplane.study.setups import starts
from sternplane.study.wrong_vehicle import coefficients

WRONG = 0.5
HALVED = dict.fromkeys(("M_ds", "Z_ds", "N_dr", "Y_dr"), 0.5)
"""What a vehicle file would have to say of fins that lost half of their force."""
_FIGURES = ("depth", "heading", "travel")
_NAMES_NOTHING = "\n[autopilot.safety.actuators]\nevidence = 1000.0\n"
"""The actuator watch of an oracle: its file says already what fins lose, so what it would name counts that twice, and
guidance would slow its turns by 20 %, an easier course."""
_GAINS = Path(__file__).parent / "gains"


class Knows(enum.Enum):
    """What a law is designed from: the truth, the vehicle file, or the file and what is learned."""

    TRUTH = enum.auto()
    FILE = enum.auto()
    LEARNED = enum.auto()


class Rival(NamedTuple):
    """A law in the comparison: what it knows, and the file in gains/ with its gains; "" are the shipped ones."""

    name: str
    knows: Knows
    gains: str = ""


ORACLE = Rival("oracle", Knows.TRUTH)
FIXED = Rival("fixed", Knows.FILE)
ADAPTIVE = Rival("adaptive", Knows.LEARNED)
PID = Rival("PID of equal travel", Knows.FILE, "pid_equal_travel")
SHIPPED_PID = Rival("PID as shipped", Knows.FILE, "pid_shipped")
ALL = (
    ORACLE,
    FIXED,
    ADAPTIVE,
    PID,
    SHIPPED_PID,
    Rival("free PID", Knows.FILE, "pid_free"),
    Rival("PID of equal travel, feed-forward adaptive", Knows.LEARNED, "pid_equal_travel"),
    Rival("searched poles and layers, fixed", Knows.FILE, "sliding_searched"),
    Rival("searched poles and layers, adaptive", Knows.LEARNED, "sliding_searched"),
)


class Condition(NamedTuple):
    """What is flown, what is wrong, and what the adaptive law may need.

    Attributes:
        name: of the case.
        about: a sentence.
        course: what is flown.
        file: the factors of a seed's vehicle file.
        truth: what the oracle's file has beyond the true one.
        rivals: who flies; the oracle and the fixed and adaptive laws among them.
        targets: by figure and rival, what the adaptive error may be of theirs, in the median and the worst flight:
            flight by flight beside the laws that differ in what they know alone, median by median and worst by worst
            beside other laws.
        runs: how many, and how many in the form for CI.
    """

    name: str
    about: str
    course: Callable[[], Course]
    file: Callable[[int], Mapping[str, float]]
    truth: Mapping[str, float]
    rivals: tuple[Rival, ...]
    targets: Mapping[tuple[str, Rival], tuple[float | None, float | None]]
    runs: tuple[int, int]

    @property
    def judged(self) -> Condition:
        """Return it with those alone who fly in the form for CI: who has a target there."""
        few = self.runs[1] < FEW
        asked = [rival for (_, rival), (median, worst) in self.targets.items() if worst or (median and not few)]
        return self._replace(rivals=tuple([one for one in self.rivals if one in (ORACLE, ADAPTIVE, *asked)]))


def gains(name: str) -> str:
    """Return the tables of a file in gains/, "" for none."""
    return f"\n{(_GAINS / f'{name}.toml').read_text(encoding='utf-8')}" if name else ""


def _right(seed: int) -> Mapping[str, float]:
    del seed
    return {}


def _wrong(seed: int) -> Mapping[str, float]:
    return starts(seed, WRONG)


def _halved() -> Course:
    return halved(track())


def _halved_slowly() -> Course:
    return slow_turns(halved(track()))


def _run(seed: int, k: int, condition: Condition) -> RunArrays:
    del k
    course, found = condition.course(), {}
    for rival in condition.rivals:
        knows = rival.knows
        factors = coefficients(condition.truth if knows is Knows.TRUTH else condition.file(seed))
        laws = gains(rival.gains) + (_NAMES_NOTHING if knows is Knows.TRUTH else "")
        errors = flown_as(course, seed, factors, knows is Knows.LEARNED, laws)
        figures = errors.figures(course.settled, math.inf)
        found[rival.name] = np.array([float(errors.failed), *(figures[figure] for figure in _FIGURES)])
    return found


def _evaluate(runs: Sequence[RunArrays], condition: Condition) -> Results:
    name, n = condition.name, len(runs)
    if not n:
        return Results(())
    late: dict[str, dict[str, Array]] = {}
    rows, rivals = [], [rival for rival in condition.rivals if all(rival.name in run for run in runs)]
    for rival in rivals:
        table = np.array([run[rival.name] for run in runs]).reshape(n, -1)
        late[rival.name] = dict(zip(_FIGURES, table[:, 1:].T, strict=True))
        target = 0.0 if rival in (ORACLE, ADAPTIVE) else None
        rows.append(Row(name, f"{rival.name}: failed flights", float(np.sum(table[:, 0])), target, n))
    oracle = late[ORACLE.name]
    for figure, unit in zip(_FIGURES, ("m", "deg", "deg/s"), strict=True):
        what = "fin travel" if figure == "travel" else f"{figure} RMS"
        rows.append(Row(name, f"oracle: {what}, median, {unit}", float(np.median(oracle[figure])), None, n))
        for rival in rivals[1:]:
            ratio = late[rival.name][figure] / oracle[figure]
            for word, value in (("median", np.median(ratio)), ("worst", np.max(ratio))):
                rows.append(Row(name, f"{rival.name}: {what} over oracle, {word}", float(value), None, n))
    for (figure, rival), limits in condition.targets.items():
        if rival not in rivals:
            continue
        ours, theirs = late[ADAPTIVE.name][figure], late[rival.name][figure]
        ratio, what = ours / theirs, f"adaptive: {figure} RMS over {rival.name}"
        values = np.median(ratio), np.max(ratio)
        if rival not in (ORACLE, FIXED):
            most = float(np.max(ratio))
            rows.append(Row(name, f"{what}, flight by flight, worst", most, None, n))
            values = np.median(ours) / np.median(theirs), np.max(ours) / np.max(theirs)
        for word, value, limit in zip(("median", "worst"), values, limits, strict=True):
            target = limit if word == "worst" or n >= FEW else None
            rows.append(Row(name, f"{what}, {word}", float(value), target, n))
    return Results(rows)


def _case(condition: Condition) -> Case:
    return Case(
        condition.name,
        condition.about,
        functools.partial(_run, condition=condition),
        functools.partial(_evaluate, condition=condition),
        *condition.runs,
        functools.partial(_run, condition=condition.judged),
    )


_WHO = (
    "PID: the same references and feed-forward, gains by an optimiser on the nominal vehicle (`sternplane study "
    "tuning`), once with the fins' travel of the sliding-mode laws at most, once free of that; searched: poles and "
    "layers by the same optimiser. "
)
_HALVED = (
    "Track, with a file that is right; all fins lose half of their force at 60 s, figures from 90 s on. The oracle's "
    "laws are designed for halved fins from the start, so that nobody needs to tell them: its references are those of "
    "the adaptive vehicle. "
)
CASES = tuple(
    _case(condition)
    for condition in (
        Condition(
            "fins halved",
            _HALVED,
            _halved,
            _right,
            HALVED,
            ALL[:3],
            {("depth", ORACLE): (1.2, 1.2), ("depth", FIXED): (0.25, None)},
            (40, 1),
        ),
        Condition(
            "fins halved, slow turns",
            _HALVED + "Turns of 2 deg/s: those of 4 deg/s are beyond half a rudder, whoever steers.",
            _halved_slowly,
            _right,
            HALVED,
            ALL[:3],
            {("heading", ORACLE): (1.2, None)},
            (40, 0),
        ),
        Condition(
            "rivals, nominal vehicle",
            _WHO + "Track, with a vehicle file that is right.",
            track,
            _right,
            {},
            (ORACLE, *ALL[2:]),
            {},
            (40, 0),
        ),
        Condition(
            "rivals, coefficients 50 % wrong",
            _WHO + "Track, with the ten coefficients off by +-50 %, to sides that are drawn.",
            track,
            _wrong,
            {},
            ALL,
            {("depth", PID): (0.65, 0.75), ("depth", SHIPPED_PID): (0.65, 0.75)},
            (40, 0),
        ),
        Condition(
            "rivals, fins halved", _WHO + _HALVED, _halved, _right, HALVED, ALL, {("depth", PID): (0.5, None)}, (40, 0)
        ),
    )
)
