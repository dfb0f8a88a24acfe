"""The questions of the adaptation study: what a wrong vehicle file costs with adoption and without."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
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


def _run(seed: int, k: int, course: Callable[[], Course], wrong: float) -> RunArrays:
    del k
    found: dict[str, Array] = {}
    for design in Design:
        errors, name = flown(course(), seed, wrong, design), design.name.lower()
        settled = course().settled
        found[f"{name} failed"] = np.array(float(errors.failed))
        found[f"{name} adopted"] = np.array(errors.adopted)
        found[f"{name} errors"] = np.column_stack([errors.t, errors.depth, np.degrees(errors.heading)])[::_SHOWN]
        for part, span in (("early", (_EARLY, settled)), ("late", (settled, math.inf))):
            figures = errors.figures(*span)
            found[f"{name} {part}"] = np.array([figures[figure] for figure in _FIGURES])
    return found


def _evaluate(runs: Sequence[RunArrays], name: str, targets: Targets, settled: float) -> Results:
    rows, n, late, ratios = [], len(runs), {}, {}
    for design in Design:
        key = design.name.lower()
        late[key] = np.array([run[f"{key} late"] for run in runs])
        target = 0.0 if design is not Design.FIXED else None
        rows.append(Row(name, f"{key}: failed flights", sum(float(run[f"{key} failed"]) for run in runs), target, n))
    for i, (quantity, unit) in enumerate(_UNITS.items()):
        limits = targets.depth if quantity == "depth" else targets.heading
        oracle = late["oracle"][:, i]
        rows.append(Row(name, f"oracle: {quantity} RMS, median, {unit}", float(np.median(oracle)), None, n))
        for key in ("fixed", "adaptive"):
            ratio = ratios[quantity, key] = late[key][:, i] / oracle
            judged = limits if key == "adaptive" else (None, None)
            for word, value, limit in zip(("median", "worst"), (np.median(ratio), np.max(ratio)), judged, strict=True):
                target = limit if word == "worst" or n >= FEW else None
                rows.append(Row(name, f"{key}: {quantity} RMS over oracle, {word}", float(value), target, n))
    for key in ("fixed", "adaptive"):
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
    return Results(rows, [*one_flight("first of the flights", first), beside_oracle(ratios)])


def _case(course: Callable[[], Course], wrong: float, targets: Targets, runs: int, short: int) -> Case:
    label, settled = course().name, course().settled
    name = f"{label}, coefficients {100.0 * wrong:g} % wrong"
    about = (
        f"The ten coefficients of the vehicle file are off by +-{100.0 * wrong:g} %, to sides that are drawn. Oracle: "
        f"the laws are designed from the truth; fixed: from the wrong file; adaptive: from what is learned. Figures "
        f"from {settled:g} s on, by the truth; the heading's without its mean."
    )
    return Case(
        name,
        about,
        functools.partial(_run, course=course, wrong=wrong),
        functools.partial(_evaluate, name=name, targets=targets, settled=settled),
        runs,
        short,
    )


CASES: tuple[Case, ...] = (
    _case(track, 0.5, Targets((1.05, 1.15), (1.1, 1.3)), 40, 1),
    _case(track, 0.7, Targets((1.05, 1.15), (1.3, 2.0), 1.0, 23.5), 40, 2),
    _case(demonstration, 0.5, Targets((1.05, 1.15), (1.1, 1.3)), 40, 1),
    _case(demonstration, 0.7, Targets((1.05, 1.15), (1.3, 2.0), 1.0, 23.5), 40, 1),
    SECOND_DIVE,
)
