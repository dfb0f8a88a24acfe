"""Without noise: does the filter come to the truth, from wherever it starts; and the paper's own scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from sternplane.sitl.busless_flight import N_TRIM, fly
from sternplane.study.figures import bars, over_time, per_name
from sternplane.study.rows import Case, Findings, Numbers, Row
from sternplane.study.setups import PAPER_EKF, Setup, boat, flown, learn, vehicle

PRBS = Setup(duration=120.0, dvl=100.0, noise=0.0)
STARTS = (-1.0, -0.5, -0.3, 0.3, 0.5)
"""How wrong the coefficients start: -1 is from 0."""
PAPER = Setup(duration=60.0, dvl=100.0, noise=0.0)
OVER = math.radians(20.0)


def _ekf() -> CoefficientEkf:
    """In water that is known to be still; a start from 0 lies within its prior."""
    return CoefficientEkf(vehicle(), CoefficientParams(current=False, std=1.0))


def _prbs(seed: int, k: int) -> Numbers:
    wrong = dict.fromkeys(TEN, 1.0 + STARTS[k])
    return learn(PRBS, flown(PRBS, seed), _ekf(), seed, wrong).numbers()


def _judge_prbs(runs: Sequence[Numbers]) -> Findings:
    name = f"noise-free, PRBS, {PRBS.words}"
    rows = []
    for start, run in zip(STARTS, runs, strict=True):
        words = "start at 0" if start == -1.0 else f"start {100.0 * start:+.0f} %"
        worst = 100.0 * float(np.abs(run["error"][-1]).max()) if run["steps"] == 12000 else math.nan
        rows.append(Row(name, f"worst of the ten, %, {words}", worst, 0.01))
    error = np.array([run["error"] for run in runs])
    note = "RMS over the starts 0, -50, -30, +30, +50 %; exact measurements, fed directly."
    return Findings(rows, [over_time("Noise-free, PRBS", note, runs[0]["t"], error)])


def _paper(seed: int, k: int) -> Numbers:
    demands = np.full((round(PAPER.duration / PAPER.h), 2), OVER)
    trial = fly(boat(), demands, N_TRIM, PAPER.h)
    return learn(PAPER, trial, _ekf(), seed, dict.fromkeys(TEN, 1.0 + (-1.0, -0.5, 0.5)[k])).numbers()


def _judge_paper(runs: Sequence[Numbers]) -> Findings:
    name = f"paper's scenario (constant 20/20 deg), noise-free, EKF, {PAPER.words}"
    rows = []
    for words, run in zip(("start at 0", "start -50 %", "start +50 %"), runs, strict=True):
        rows += per_name(name, f"error, %, {words}", 100.0 * np.abs(run["error"][-1]), PAPER_EKF)
    series = {"EKF, worst of three starts": 100.0 * np.abs([run["error"][-1] for run in runs]).max(axis=0)}
    series["paper's EKF"] = np.array(list(PAPER_EKF.values()))
    note = "Both planes at 20 deg pitch the boat down by 33 deg; elevator alone would reach the vertical after 93 s."
    plot = bars("The paper's scenario", note, "error, %", series, log=True)
    return Findings(rows, [plot])


CASES = (
    Case(
        "noise-free",
        "PRBS on rudder and stern planes, exact measurements fed directly, no bus; five starts.",
        *(_prbs, _judge_prbs, len(STARTS), len(STARTS)),
    ),
    Case(
        "paper",
        "Rudder and stern planes at 20 deg from trim, exact measurements, against Table 1 of the paper.",
        *(_paper, _judge_paper, 3, 3),
    ),
)
