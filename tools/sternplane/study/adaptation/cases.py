"""The questions of the adaptation study: what a wrong vehicle file costs with adoption and without."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sternplane.logs.tracking import Array
from sternplane.study.adaptation.courses import demonstration, track
from sternplane.study.adaptation.flight import Course, Design, flown
from sternplane.study.adaptation.plots import beside_oracle, one_flight
from sternplane.study.adaptation.second_dive import SECOND_DIVE
from sternplane.study.rows import FEW, Case, Results, Row, RunArrays

_EARLY = 5.0
"""The laws are settled in their start by then, s."""
_FIGURES = ("depth", "heading", "depth_most", "heading_most", "travel")
_SHOWN = 50
"""Every so many ticks the errors are kept for the plots."""
_UNITS = {"depth": "m", "heading": "deg"}


class Targets(NamedTuple):
    """Ratios to the oracle that the median and the worst flight may have, of depth and of heading."""

    depth: tuple[float, float]
    heading: tuple[float, float]
    early_depth: float | None = None
    """Greatest depth error before everything is learned, m."""
    early_heading: float | None = None
    """Greatest heading error then, deg: half of what it is without adoption and caution."""
    adopted: float | None = None
    """When everything is adopted, s, in the median."""


def _run(seed: int, k: int, course: Callable[[], Course], wrongs: Sequence[float], fixed: bool = True) -> RunArrays:
    """Fly the oracle once, and with each wrong file the adaptive laws and, if asked for, the fixed ones."""
    del k
    flights = {"oracle": (0.0, Design.ORACLE)}
    for wrong in wrongs:
        if fixed:
            flights[f"{_prefix(wrong)}fixed"] = wrong, Design.FIXED
        flights[f"{_prefix(wrong)}adaptive"] = wrong, Design.ADAPTIVE
    found: dict[str, Array] = {}
    for name, (wrong, design) in flights.items():
        errors, settled = flown(course(), seed, wrong, design), course().settled
        found[f"{name} failed"] = np.array(float(errors.failed))
        found[f"{name} adopted"] = np.array(errors.adopted)
        found[f"{name} errors"] = np.column_stack([errors.t, errors.depth, np.degrees(errors.heading)])[::_SHOWN]
        for part, span in (("early", (_EARLY, settled)), ("late", (settled, math.inf))):
            figures = errors.figures(*span)
            found[f"{name} {part}"] = np.array([figures[figure] for figure in _FIGURES])
    return found


def _prefix(wrong: float) -> str:
    return f"{100.0 * wrong:g} % wrong, "


def _with(wrong: float, run: RunArrays) -> RunArrays:
    """Return the flights of the oracle and of one wrong file."""
    ours = ("oracle", _prefix(wrong))
    return {name.removeprefix(ours[1]): array for name, array in run.items() if name.startswith(ours)}


def _evaluate(runs: Sequence[RunArrays], course: str, targets: Mapping[float, Targets], settled: float) -> Results:
    judged = [_judge([_with(wrong, run) for run in runs], course, wrong, targets[wrong], settled) for wrong in targets]
    return Results([row for one in judged for row in one.rows], [plot for one in judged for plot in one.plots])


def _judge(runs: Sequence[RunArrays], course: str, wrong: float, targets: Targets, settled: float) -> Results:
    """Judge the flights with one wrong file; the fixed laws are shown where they flew."""
    name = f"{course}, coefficients {100.0 * wrong:g} % wrong"
    rows, n, late, ratios = [], len(runs), {}, {}
    steered = ("fixed", "adaptive") if all("fixed late" in run for run in runs) else ("adaptive",)
    for key in ("oracle", *steered):
        late[key] = np.array([run[f"{key} late"] for run in runs])
        target = 0.0 if key != "fixed" else None
        rows.append(Row(name, f"{key}: failed flights", sum(float(run[f"{key} failed"]) for run in runs), target, n))
    for i, (quantity, unit) in enumerate(_UNITS.items()):
        limits = targets.depth if quantity == "depth" else targets.heading
        oracle = late["oracle"][:, i]
        rows.append(Row(name, f"oracle: {quantity} RMS, median, {unit}", float(np.median(oracle)), None, n))
        for key in steered:
            ratio = ratios[quantity, key] = late[key][:, i] / oracle
            judged = limits if key == "adaptive" else (None, None)
            for word, value, limit in zip(("median", "worst"), (np.median(ratio), np.max(ratio)), judged, strict=True):
                target = limit if word == "worst" or n >= FEW else None
                rows.append(Row(name, f"{key}: {quantity} RMS over oracle, {word}", float(value), target, n))
    for key in steered:
        early = np.array([run[f"{key} early"] for run in runs])
        adaptive = key == "adaptive"
        for figure, unit, limit in (("depth", "m", targets.early_depth), ("heading", "deg", targets.early_heading)):
            most = float(np.max(early[:, _FIGURES.index(f"{figure}_most")]))
            what = f"{key}: greatest {figure} error before {settled:g} s, worst flight, {unit}"
            rows.append(Row(name, what, most, limit if adaptive else None, n))
    for key in late:
        travel = float(np.median(late[key][:, _FIGURES.index("travel")]))
        rows.append(Row(name, f"{key}: fin travel, median, deg/s", travel, None, n))
    adopted = float(np.median([float(run["adaptive adopted"]) for run in runs]))
    rows.append(Row(name, "adaptive: all learned and adopted, median, s", adopted, targets.adopted, n))
    first = {design: runs[0][f"{design} errors"] for design in late}
    what = f"{100.0 * wrong:g} % wrong"
    return Results(rows, [*one_flight(f"{what}, first of the flights", first), beside_oracle(what, ratios)])


def _case(course: Callable[[], Course], targets: Mapping[float, Targets], short: int) -> Case:
    label, settled = course().name, course().settled
    percents = " or ".join([f"{100.0 * wrong:g}" for wrong in targets])
    about = (
        f"The ten coefficients of the vehicle file are off by +-{percents} %, to drawn sides. Oracle: the laws "
        "are designed from the truth; fixed: from the wrong file (not in the short form); adaptive: from what is "
        f"learned. Figures from {settled:g} s on, by the truth; the heading's without its mean."
    )
    run = functools.partial(_run, course=course, wrongs=tuple(targets))
    evaluate = functools.partial(_evaluate, course=label, targets=targets, settled=settled)
    return Case(f"{label}, wrong coefficients", about, run, evaluate, 40, short, functools.partial(run, fixed=False))


_BY_WRONG = {0.5: Targets((1.05, 1.15), (1.1, 1.3)), 0.7: Targets((1.05, 1.15), (1.3, 2.0), 1.0, 23.5)}
CASES: tuple[Case, ...] = (_case(track, _BY_WRONG, 2), _case(demonstration, _BY_WRONG, 1), SECOND_DIVE)
