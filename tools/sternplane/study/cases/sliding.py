"""The sliding-mode observer: the paper's, which settles on a hyperplane, and one weighted by the regressor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_params import TEN
from sternplane.logs.tracking import Array
from sternplane.paper.sliding_mode_observer import SlidingModeObserver, SmoParams
from sternplane.sitl.busless_flight import N_TRIM, BuslessFlight, fly, measured
from sternplane.study.figures import bars, per_name
from sternplane.study.rows import Case, Findings, Numbers, Row
from sternplane.study.setups import PAPER_SMO, Setup, boat, flown, vehicle

CONSTANT = Setup(duration=60.0, dvl=100.0, noise=0.0)
PRBS = Setup(duration=300.0, dvl=100.0, noise=0.0)
STARTS = (-0.5, 0.5)
OVER = math.radians(20.0)
EQUATIONS = "MNZY"


def _observe(setup: Setup, trial: BuslessFlight, observer: SlidingModeObserver, start: float) -> Array:
    """Error of the ten at the end, as a part of their size."""
    model = observer.model
    believed = np.array(model.believed)
    values = dict(zip(model.names, believed * (1.0 + start), strict=True))
    z = np.where(measured(len(trial.inputs), setup.h, setup.rates), trial.x[1:], np.nan)
    observer.start(trial.x[0, :6].tolist(), trial.x[0, 6:].tolist(), values)
    made = observer.run(setup.h, trial.inputs, z).steps
    error: Array = (observer.estimate().values - believed) / np.abs(believed)
    return error if made == len(trial.inputs) else error * math.nan


def _constant(seed: int, k: int) -> Numbers:
    del seed
    demands = np.full((round(CONSTANT.duration / CONSTANT.h), 2), OVER)
    trial = fly(boat(), demands, N_TRIM, CONSTANT.h)
    observer = SlidingModeObserver(vehicle(), SmoParams())
    error = _observe(CONSTANT, trial, observer, STARTS[k])
    model = observer.model
    model.advance(model.state(trial.x[-1, :6].tolist(), trial.x[-1, 6:].tolist()), trial.inputs[-1], CONSTANT.h)
    rows = ["XYZKMN".index(axis) for axis in EQUATIONS]
    normal = model.unit_forces()[rows] * np.abs(model.believed)
    return {"error": error, "normal": normal / np.linalg.norm(normal, axis=1, keepdims=True)}


def _judge_constant(runs: Sequence[Numbers]) -> Findings:
    name = f"paper's scenario (constant 20/20 deg), noise-free, SMO with constant L, {CONSTANT.words}"
    rows, notes = [], []
    for start, run in zip(STARTS, runs, strict=True):
        words = f"start {100.0 * start:+.0f} %"
        rows += per_name(name, f"error, %, {words}", 100.0 * np.abs(run["error"]), None)
        for axis, normal in zip(EQUATIONS, run["normal"], strict=True):
            own = np.array([n.startswith(axis) for n in TEN])
            off = abs(float(normal @ run["error"]))
            along = math.sqrt(max(float((run["error"][own] ** 2).sum()) - off**2, 0.0))
            rows.append(Row(name, f"distance from the hyperplane of {axis}, %, {words}", 100.0 * off))
            rows.append(Row(name, f"way along the hyperplane of {axis}, %, {words}", 100.0 * along))
    rows += per_name(name, "paper's SMO, %", np.array(list(PAPER_SMO.values())), None)
    for axis, normal in zip(EQUATIONS, runs[0]["normal"], strict=True):
        parts = [f"{normal[i]:+.2f} d{n}/|{n}|" for i, n in enumerate(TEN) if n.startswith(axis)]
        notes.append(f"In steady motion a constant L sees of the {axis} equation only the sum {' '.join(parts)}.")
    series = {f"start {100.0 * s:+.0f} %": 100.0 * np.abs(run["error"]) for s, run in zip(STARTS, runs, strict=True)}
    series["paper's SMO"] = np.array(list(PAPER_SMO.values()))
    note = "It rests wherever the sum of an equation's forces is right; where, hangs on the start."
    return Findings(rows, [bars("SMO, constant L, 20/20 deg", note, "error, %", series, log=True)], notes)


def _prbs(seed: int, k: int) -> Numbers:
    seed -= k
    observer = SlidingModeObserver(vehicle(), SmoParams(weighted=True))
    return {"error": _observe(PRBS, flown(PRBS, seed), observer, STARTS[k])}


def _judge_prbs(runs: Sequence[Numbers]) -> Findings:
    name = f"PRBS, noise-free, SMO weighted by the regressor, {PRBS.words}"
    rows = []
    for start, run in zip(STARTS, runs, strict=True):
        rows += per_name(name, f"error, %, start {100.0 * start:+.0f} %", 100.0 * np.abs(run["error"]), PAPER_SMO)
    series = {f"start {100.0 * s:+.0f} %": 100.0 * np.abs(run["error"]) for s, run in zip(STARTS, runs, strict=True)}
    series["paper's SMO"] = np.array(list(PAPER_SMO.values()))
    note = "Under persistent excitation the hyperplane turns, and only the truth lies on all of them."
    return Findings(rows, [bars("SMO, weighted L, PRBS", note, "error, %", series, log=True)])


CASES = (
    Case(
        "SMO, paper",
        "The paper's sliding-mode observer in the paper's scenario, shown beside Table 1.",
        *(_constant, _judge_constant, len(STARTS), len(STARTS)),
    ),
    Case(
        "SMO, weighted",
        "The sliding-mode observer with its gain weighted by the regressor, under PRBS with exact measurements.",
        *(_prbs, _judge_prbs, len(STARTS), len(STARTS)),
    ),
)
