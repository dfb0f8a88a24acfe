"""Does the filter know how wrong it is: NEES and NIS, in still and in turbulent water, the bank deciding."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from sternplane.report.drawing import Plot
from sternplane.study.chance import chi_square_band, share_of
from sternplane.study.figures import COLOURS, SENSORS, nees_over_time
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import UNKNOWN_WATER, Setup, fly_prbs, run_filter, starts, vehicle

WRONG = 0.5
BANK = (0.0, 0.02, 0.05)
"""Intensities that the filters of the bank reckon with, m/s."""
LOST = {"no turbulence": 0.001, "turbulence 0.05 m/s": 0.05}
"""Expected share of flights in which the filter is lost and starts again."""
SEAS = {"no turbulence": Setup(), "turbulence 0.05 m/s": Setup(turbulence=0.05)}


def _run(seed: int, k: int) -> RunArrays:
    del k
    out: dict[str, np.ndarray] = {}
    for label, setup in SEAS.items():
        ekf = CoefficientEkf(vehicle(), CoefficientParams(std=WRONG, turbulence=BANK, **UNKNOWN_WATER))
        run = run_filter(setup, fly_prbs(setup, seed), ekf, seed, starts(seed, WRONG))
        out |= {f"{label} {key}": value for key, value in run.arrays().items()}
        out[f"{label} restarts"] = np.array(ekf.resets)
    return out


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    rows, curves, plots, notes = [], {}, [], [_NO_TARGET]
    for label, setup in SEAS.items():
        name = f"consistency, {label}, PRBS, start +-50 %, bank of {len(BANK)}, {setup.label}"
        t = max((run[f"{label} t"] for run in runs), key=len)
        kept = [run for run in runs if len(run[f"{label} t"]) == len(t)]
        if len(kept) < len(runs):
            notes.append(
                f"{label}: {len(runs) - len(kept)} of {len(runs)} runs broke off at a number that was not finite: "
                "NEES misses for that; NIS, curves and probabilities are those of the others."
            )
        nees = np.array([run[f"{label} nees"] for run in kept])
        freedom = kept[0][f"{label} freedom"]
        for i, what in enumerate(("the ten", "all states")):
            dof = int(freedom[i])
            mean = float(nees[:, -1, i].mean()) / dof if len(kept) == len(runs) else math.nan
            band = chi_square_band(dof * len(kept)) if i == 0 or setup.turbulence else None
            rows.append(Row(name, f"NEES of {what} per degree of freedom", mean, band, len(kept)))
            curves[f"{label}, {what}"] = (t, nees[:, :, i], dof)
        middle = float(np.median(nees[:, -1, 0])) / int(freedom[0])
        rows.append(Row(name, "NEES of the ten per degree of freedom, the median flight (expected: 0.93)", middle))
        lost = float(np.mean([run[f"{label} restarts"] > 0 for run in kept]))
        most = share_of(len(kept), LOST[label])
        rows.append(Row(name, "share of flights in which the filter was lost and started again", lost, most, len(kept)))
        nis = np.sum([run[f"{label} nis"] for run in kept], axis=0)
        for sensor, (total, count) in zip(SENSORS, nis, strict=True):
            rows.append(Row(name, f"NIS of {sensor}", float(total / count), chi_square_band(float(count)), len(kept)))
        weights = np.array([run[f"{label} weights"] for run in kept]).mean(axis=0)
        plots.append(_bank(f"The bank, {label}", t, weights))
        for intensity, weight in zip(BANK, weights[-1], strict=True):
            rows.append(Row(name, f"probability of {intensity:g} m/s at the end", float(weight)))
    note = "Average over the seeds; dotted: the band of chance."
    return Results(rows, [nees_over_time("Consistency", note, curves, len(runs)), *plots], notes)


_NO_TARGET = (
    "NEES of all states has no target in still water: there the motion follows exactly from where it began, and the "
    "random walk that keeps its covariance positive definite makes sigma too large."
)


def _bank(title: str, t: np.ndarray, weights: np.ndarray) -> Plot:
    figure = go.Figure()
    for i, intensity in enumerate(BANK):
        figure.add_scatter(
            x=t, y=weights[:, i], name=f"{intensity:g} m/s", line={"color": COLOURS[i]}, stackgroup="all"
        )
    figure.update_layout(xaxis={"title": "t, s"}, yaxis={"title": "probability", "range": [0, 1]})
    return Plot(title, "Of each intensity of the eddies, averaged over the seeds.", figure)


CASES = (
    Case(
        "consistency",
        "PRBS with noise and a correct model, in still water and in eddies of 0.05 m/s; a bank of filters decides.",
        *(_run, _evaluate, 100, 8),
    ),
)
