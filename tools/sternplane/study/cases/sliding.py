"""The sliding-mode observer: the paper's, which settles on a hyperplane, and one weighted by the regressor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_params import TEN
from sternplane.logs.tracking import Array
from sternplane.paper.sliding_mode_observer import SlidingModeObserver, SmoParams
from sternplane.sitl.busless_flight import N_TRIM, BuslessFlight, fly, measurement_mask
from sternplane.study.figures import bars, per_name
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import FIXED_SEED, MARGIN, PAPER_SMO, Setup, fly_prbs, true_vehicle, vehicle

CONSTANT = Setup(duration=60.0, dvl=100.0, noise=0.0)
PRBS = Setup(duration=300.0, dvl=100.0, noise=0.0)
STARTS = (-0.5, 0.5)
WEIGHTED_REACHED = (0.0, 0.0, 1.9e-4, 2.82e-4, 1.931e-3, 0.0, 0.0, 1.39e-4, 1.068e-4, 1.43e-4)
"""Error of each of the ten under PRBS when the targets were written, %; 0: rounding."""
ROUNDING = 1e-6
"""A smaller target would judge the rounding of numbers, %."""
PLANE_REACHED = {"M": 0.0392, "N": 0.00614, "Z": 0.0533, "Y": 0.00874}
"""Distance from the hyperplane of each equation when the targets were written, %."""
OVER = math.radians(20.0)
EQUATIONS = "MNZY"


def _observe(setup: Setup, flight: BuslessFlight, observer: SlidingModeObserver, start: float) -> Array:
    """Error of the ten at the end, as a part of their size."""
    model = observer.model
    believed = np.array(model.believed)
    values = dict(zip(model.names, believed * (1.0 + start), strict=True))
    z = np.where(measurement_mask(len(flight.inputs), setup.h, setup.rates), flight.x[1:], np.nan)
    observer.start(flight.x[0, :6].tolist(), flight.x[0, 6:].tolist(), values)
    made = observer.run(setup.h, flight.inputs, z).steps
    error: Array = (observer.estimate().values - believed) / np.abs(believed)
    return error if made == len(flight.inputs) else error * math.nan


def _constant(seed: int, k: int) -> RunArrays:
    del seed
    demands = np.full((round(CONSTANT.duration / CONSTANT.h), 2), OVER)
    flight = fly(true_vehicle(), demands, N_TRIM, CONSTANT.h)
    observer = SlidingModeObserver(vehicle(), SmoParams())
    error = _observe(CONSTANT, flight, observer, STARTS[k])
    model = observer.model
    model.advance(model.state(flight.x[-1, :6].tolist(), flight.x[-1, 6:].tolist()), flight.inputs[-1], CONSTANT.h)
    rows = ["XYZKMN".index(axis) for axis in EQUATIONS]
    normal = model.unit_forces()[rows] * np.abs(model.believed)
    return {"error": error, "normal": normal / np.linalg.norm(normal, axis=1, keepdims=True)}


def _evaluate_constant(runs: Sequence[RunArrays]) -> Results:
    name = f"paper's scenario (constant 20/20 deg), noise-free, SMO with constant L, {CONSTANT.label}"
    rows, notes = [], []
    for start, run in zip(STARTS, runs, strict=True):
        label = f"start {100.0 * start:+.0f} %"
        rows += per_name(name, f"error, %, {label}", 100.0 * np.abs(run["error"]), None)
        for axis, normal in zip(EQUATIONS, run["normal"], strict=True):
            own = np.array([n.startswith(axis) for n in TEN])
            off = abs(float(normal @ run["error"]))
            along = math.sqrt(max(float((run["error"][own] ** 2).sum()) - off**2, 0.0))
            target = MARGIN * PLANE_REACHED[axis]
            rows.append(Row(name, f"distance from the hyperplane of {axis}, %, {label}", 100.0 * off, target))
            rows.append(Row(name, f"way along the hyperplane of {axis}, %, {label}", 100.0 * along))
    rows += per_name(name, "paper's SMO, %", np.array(list(PAPER_SMO.values())), None)
    for axis, normal in zip(EQUATIONS, runs[0]["normal"], strict=True):
        parts = [f"{normal[i]:+.2f} d{n}/|{n}|" for i, n in enumerate(TEN) if n.startswith(axis)]
        notes.append(f"In steady motion a constant L sees of the {axis} equation only the sum {' '.join(parts)}.")
    series = {f"start {100.0 * s:+.0f} %": 100.0 * np.abs(run["error"]) for s, run in zip(STARTS, runs, strict=True)}
    series["paper's SMO"] = np.array(list(PAPER_SMO.values()))
    note = "It rests wherever the sum of an equation's forces is right; where depends on the start."
    return Results(rows, [bars("SMO, constant L, 20/20 deg", note, "error, %", series, log=True)], notes)


def _prbs(seed: int, k: int) -> RunArrays:
    del seed
    observer = SlidingModeObserver(vehicle(), SmoParams(weighted=True))
    return {"error": _observe(PRBS, fly_prbs(PRBS, FIXED_SEED), observer, STARTS[k])}


def _evaluate_prbs(runs: Sequence[RunArrays]) -> Results:
    name = f"PRBS, noise-free, SMO weighted by the regressor, {PRBS.label}"
    rows = []
    reached = dict(zip(TEN, WEIGHTED_REACHED, strict=True))
    target = {at: min(PAPER_SMO[at], max(MARGIN * reached[at], ROUNDING)) for at in TEN}
    for start, run in zip(STARTS, runs, strict=True):
        rows += per_name(name, f"error, %, start {100.0 * start:+.0f} %", 100.0 * np.abs(run["error"]), target)
    series = {f"start {100.0 * s:+.0f} %": 100.0 * np.abs(run["error"]) for s, run in zip(STARTS, runs, strict=True)}
    series["paper's SMO"] = np.array(list(PAPER_SMO.values()))
    note = "Under persistent excitation the hyperplane turns, and only the truth lies on all of them."
    return Results(rows, [bars("SMO, weighted L, PRBS", note, "error, %", series, log=True)])


CASES = (
    Case(
        "SMO, paper",
        "The paper's sliding-mode observer in the paper's scenario, shown beside Table 1.",
        *(_constant, _evaluate_constant, len(STARTS), len(STARTS)),
    ),
    Case(
        "SMO, weighted",
        "The sliding-mode observer with its gain weighted by the regressor, under PRBS with exact measurements.",
        *(_prbs, _evaluate_prbs, len(STARTS), len(STARTS)),
    ),
)
