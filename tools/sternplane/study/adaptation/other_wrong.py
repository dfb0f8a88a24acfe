"""What the filter does not learn, or learns only for the sake of the ten, is wrong, or the hull is another one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_py.adapters.installation import configs
from firmware_py.adapters.storage.toml_files import read_toml
from sternplane.study.adaptation.courses import track
from sternplane.study.adaptation.flight import flown_as
from sternplane.study.cases.honesty import (
    NPS,
    REMUS,
    Wrong,
    added_mass,
    buoyancy,
    drag,
    nothing,
    rest,
    signs,
    ten,
)
from sternplane.study.rows import Case, Results, Row, RunArrays

WAYS = (
    Wrong(NPS, "added mass +-20 %", added_mass),
    Wrong(REMUS, "REMUS 100, the ten +-30 %", ten(0.3)),
    Wrong(NPS, "the rest +-20 %", rest),
    Wrong(NPS, "drag +-20 %", drag),
    Wrong(NPS, "buoyancy +-1 %", buoyancy),
    Wrong(REMUS, "REMUS 100, nothing", nothing),
)
_NAME = "track, wrong otherwise"


def _run(seed: int, k: int) -> RunArrays:
    way = WAYS[k % len(WAYS)]
    folder, course = configs() / way.hull.folder, track(cruise=(way.hull.u, way.hull.n))
    wrong = way.factors(read_toml(folder / "vehicle.toml"), signs(seed))
    errors = flown_as(course, seed, wrong, adoption=True, config=folder)
    figures = errors.figures(course.settled)
    found = [float(errors.failed), figures["depth"], figures["heading"]]
    return {"way": np.array(k % len(WAYS)), "found": np.array(found)}


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    rows = []
    for i, (_, name, *_) in enumerate(WAYS):
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
        "equation; drag along, across and of the fins; buoyancy; or every other coefficient. To sides that are drawn. "
        "And another hull, the REMUS 100, whose file is right, or its ten coefficients are wrong.",
        _run,
        _evaluate,
        48,
        2,
    ),
)
