"""Without noise: does the filter come to the truth, from wherever it starts; and the paper's own scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from sternplane.sitl.busless_flight import N_TRIM, fly
from sternplane.study.figures import bars, final, longest, over_runs, over_time, per_name
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import FIXED_SEED, MARGIN, PAPER_EKF, Setup, fly_prbs, run_filter, true_vehicle, vehicle

PRBS = Setup(duration=120.0, dvl=100.0, noise=0.0)
STARTS = (-1.0, -0.5, -0.3, 0.3, 0.5)
"""How wrong the coefficients start: -1 is from 0."""
PRBS_REACHED = (2.6e-4, 7.6e-5, 2.5e-5, 2.4e-5, 7.0e-5)
"""Greatest error of the ten from each start when the targets were written, %."""
PAPER = Setup(duration=60.0, dvl=100.0, noise=0.0)
PAPER_STARTS = {"start at 0": -1.0, "start -50 %": -0.5, "start +50 %": 0.5}
PAPER_REACHED = {
    "start at 0": (5.03e-4, 4.09e-4, 2.005e-3, 9.73e-4, 3.796e-3, 4.04e-5, 4.2e-5, 7.45e-4, 1.801e-3, 5.02e-4),
    "start -50 %": (1.277e-4, 1.038e-4, 5.126e-4, 2.487e-4, 9.711e-4, 7.47e-6, 7.61e-6, 1.768e-4, 4.312e-4, 1.209e-4),
    "start +50 %": (1.258e-4, 1.023e-4, 4.663e-4, 2.262e-4, 8.831e-4, 1.686e-5, 1.794e-5, 1.576e-4, 3.789e-4, 1.054e-4),
}
"""Error of each of the ten when the targets were written, %: a 30th of the paper's or less."""
OVER = math.radians(20.0)


def stillwater_filter() -> CoefficientEkf:
    """Return a filter for water that is known to be still; a start from 0 lies within its prior."""
    return CoefficientEkf(vehicle(), CoefficientParams(current=False, std=1.0))


def _prbs(seed: int, k: int) -> RunArrays:
    del seed
    wrong, seed = dict.fromkeys(TEN, 1.0 + STARTS[k]), FIXED_SEED + k
    return run_filter(PRBS, fly_prbs(PRBS, seed), stillwater_filter(), seed, wrong).arrays()


def _evaluate_prbs(runs: Sequence[RunArrays]) -> Results:
    name = f"noise-free, PRBS, {PRBS.label}"
    rows = []
    for start, error, reached in zip(STARTS, final(runs, PRBS.duration), PRBS_REACHED, strict=True):
        label = "start at 0" if start == -1.0 else f"start {100.0 * start:+.0f} %"
        worst = 100.0 * float(np.abs(error).max())
        rows.append(Row(name, f"greatest error of the ten, %, {label}", worst, MARGIN * reached))
    note = "RMS over the starts 0, -50, -30, +30, +50 %; exact measurements, fed directly."
    return Results(rows, [over_time("Noise-free, PRBS", note, longest(runs), over_runs(runs))])


def _paper(seed: int, k: int) -> RunArrays:
    del seed
    demands = np.full((round(PAPER.duration / PAPER.h), 2), OVER)
    flight = fly(true_vehicle(), demands, N_TRIM, PAPER.h)
    return run_filter(
        PAPER, flight, stillwater_filter(), FIXED_SEED, dict.fromkeys(TEN, 1.0 + [*PAPER_STARTS.values()][k])
    ).arrays()


def _evaluate_paper(runs: Sequence[RunArrays]) -> Results:
    name = f"paper's scenario (constant 20/20 deg), noise-free, EKF, {PAPER.label}"
    rows = []
    ends = 100.0 * np.abs(final(runs, PAPER.duration))
    for start, error in zip(PAPER_STARTS, ends, strict=True):
        reached = dict(zip(TEN, PAPER_REACHED[start], strict=True))
        target = {at: min(PAPER_EKF[at], MARGIN * reached[at]) for at in TEN}
        rows += per_name(name, f"error, %, {start}", error, target)
    series = {"EKF, worst of three starts": ends.max(axis=0)}
    series["paper's EKF"] = np.array(list(PAPER_EKF.values()))
    note = "Both planes at 20 deg pitch the vehicle down by 33 deg; elevator alone would reach the vertical after 93 s."
    plot = bars("The paper's scenario", note, "error, %", series, log=True)
    return Results(rows, [plot])


CASES = (
    Case(
        "noise-free",
        "PRBS on rudder and stern planes, exact measurements fed directly, no bus; five starts.",
        *(_prbs, _evaluate_prbs, len(STARTS), len(STARTS)),
    ),
    Case(
        "paper",
        "Rudder and stern planes at 20 deg from trim, exact measurements, against Table 1 of the paper.",
        *(_paper, _evaluate_paper, 3, 3),
    ),
)
