"""What the filter does not learn, or learns only for the sake of the ten, is wrong: no flight may fail for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from firmware_py.adapters.storage.toml_files import read_toml
from sternplane.study.adaptation.courses import track
from sternplane.study.adaptation.flight import flown_as
from sternplane.study.cases.honesty import Signs, Tables, added_mass, buoyancy, drag, rest, signs
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import CONFIG
from sternplane.study.wrong_vehicle import Factors

WAYS: Mapping[str, Callable[[Tables, Signs], Factors]] = {
    "added mass +-20 %": added_mass,
    "the rest +-20 %": rest,
    "drag +-20 %": drag,
    "buoyancy +-1 %": buoyancy,
}
_NAME = "track, wrong in what is not learned"


def _run(seed: int, k: int) -> RunArrays:
    course, name = track(), tuple(WAYS)[k % len(WAYS)]
    factors = WAYS[name](read_toml(CONFIG / "vehicle.toml"), signs(seed))
    errors = flown_as(course, seed, factors, adoption=True)
    figures = errors.figures(course.settled)
    found = [float(errors.failed), figures["depth"], figures["heading"]]
    return {"way": np.array(k % len(WAYS)), "found": np.array(found)}


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    rows = []
    for i, name in enumerate(WAYS):
        flown = [run["found"] for run in runs if int(run["way"]) == i]
        if flown:
            failed, depth, heading = np.array(flown).T
            n = len(flown)
            rows.append(Row(_NAME, f"{name}: failed flights", float(np.sum(failed)), 0.0, n))
            rows.append(Row(_NAME, f"{name}: depth RMS, worst flight, m", float(np.max(depth)), None, n))
            rows.append(Row(_NAME, f"{name}: heading RMS, worst flight, deg", float(np.max(heading)), None, n))
    return Results(rows)


CASES = (
    Case(
        _NAME,
        "The ten coefficients of the vehicle file are right, and everything of one other kind is wrong: added mass, by "
        "equation; drag along, across and of the fins; buoyancy; or every other coefficient. To sides that are drawn.",
        _run,
        _evaluate,
        40,
        2,
    ),
)
