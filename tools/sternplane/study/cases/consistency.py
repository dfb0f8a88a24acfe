"""Does the filter know how wrong it is: NEES and NIS, in still and in moving water, the shipped bank deciding.

NEES and NIS are judged from `start_up_over` on. Before it the filter is too careful on purpose: noise on the velocities
covers slopes that are wrong while coefficients are. There only the upper edge is judged, once, at `EARLY`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from sternplane.report.drawing import Plot
from sternplane.study.chance import K_SIGMA, chi_square_band, share_of
from sternplane.study.figures import COLOURS, SENSORS, broke_off, final, longest, nees_over_time
from sternplane.study.rows import Case, Results, Row, RunArrays, Target
from sternplane.study.setups import WRONG, Setup, fly_prbs, flying, run_filter, start_up_over, starts, vehicle
from sternplane.study.shipped_filter import shipped

Waters = Mapping[str, Setup]
WATERS: Waters = {"no eddies": Setup(), "eddies 0.05 m/s": Setup(turbulence=0.05)}
ROUGH: Waters = {
    "current 0.2 m/s, eddies 0.05 m/s": Setup(current=0.2, turbulence=0.05),
    "eddies 0.2 m/s": Setup(turbulence=0.2),
}
LOST = 0.001
"""Expected share of flights in which the filter diverges and is reset."""
STRONG = "eddies 0.2 m/s"
STRONG_NEES, STRONG_SCATTER, STRONG_LOST = 2.2, 2.2, 0.17
"""NEES expected in these, how it scatters from flight to flight, and the expected share of flights with a reset. In the
roll equation sway and heave through the water multiply: where the filter's sway has the wrong sign, so has its slope,
and its water runs away within half a second. NIS shows it and the filter is reset, its coefficients off by 1 to 3
sigma. NEES and resets alone are judged there, the rest is shown."""
EARLY, FAR, FAR_SHARE = 20.0, 3.0, 0.001
"""s: coefficients have learned for a while, and the first iteration has not taken over in most flights; and the NEES,
over its degrees of freedom, that no more than such a share of flights is expected to exceed there."""


def flights(waters: Waters, seed: int) -> RunArrays:
    """Fly a seed in each water, and run the shipped filter over it."""
    out: dict[str, np.ndarray] = {}
    for label, setup in waters.items():
        ekf = CoefficientEkf(vehicle(), flying())
        run = run_filter(setup, fly_prbs(setup, seed), ekf, seed, starts(seed, WRONG))
        out |= {f"{label} {key}": value for key, value in run.arrays().items()}
        out[f"{label} resets"] = np.array(ekf.resets)
    return out


def _run(seed: int, k: int) -> RunArrays:
    del k
    return flights(WATERS, seed)


def _run_rough(seed: int, k: int) -> RunArrays:
    del k
    return flights(ROUGH, seed)


def evaluate(waters: Waters, runs: Sequence[RunArrays]) -> Results:
    """Return the rows and plots of each water."""
    rows, curves, plots, notes = [], {}, [], [_NO_TARGET]
    bank = shipped().turbulence
    for label, setup in waters.items():
        name = f"consistency, {label}, PRBS, start +-50 %, bank of {len(bank)}, {setup.label}"
        strong = label == STRONG
        t, ends = longest(runs, f"{label} "), final(runs, setup.duration, of=f"{label} ")
        rows.append(broke_off(name, ends))
        kept = [run for run, end in zip(runs, ends, strict=True) if np.isfinite(end).all()]
        if not kept:
            continue
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
            target: Target = chi_square_band(dof * len(kept)) if i == 0 or setup.turbulence else None
            if strong:
                target = STRONG_NEES + K_SIGMA * STRONG_SCATTER / math.sqrt(len(kept)) if i == 0 else None
            rows.append(Row(name, f"NEES of {what} per degree of freedom", mean, target, len(kept)))
            curves[f"{label}, {what}"] = (t, nees[:, :, i], dof)
        rows += _early(name, t, nees[:, :, 0] / int(freedom[0]), int(freedom[0]), not strong)
        middle = float(np.median(nees[:, -1, 0])) / int(freedom[0])
        rows.append(Row(name, "NEES of the ten per degree of freedom, the median flight (expected: 0.93)", middle))
        lost = float(np.mean([run[f"{label} resets"] > 0 for run in kept]))
        most = share_of(len(kept), STRONG_LOST if strong else LOST)
        rows.append(Row(name, "share of flights in which the filter diverged and was reset", lost, most, len(kept)))
        rows += _innovations(name, t, [run[f"{label} nis"] for run in kept], not strong)
        weights = np.array([run[f"{label} weights"] for run in kept]).mean(axis=0)
        plots.append(_bank(f"The bank, {label}", t, weights))
        for intensity, weight in zip(bank, weights[-1], strict=True):
            rows.append(Row(name, f"probability of {intensity:g} m/s at the end", float(weight)))
    note = "Average over the seeds; dotted: the band of chance."
    return Results(rows, [nees_over_time("Consistency", note, curves, len(runs)), *plots], notes)


def _early(name: str, t: np.ndarray, nees: np.ndarray, dof: int, judged: bool) -> list[Row]:
    """The rows at `EARLY`; nees: (runs, points), by degree of freedom."""
    count, then = len(nees), nees[:, int(np.argmin(np.abs(t - EARLY)))]
    most, few = (chi_square_band(dof * count)[1], share_of(count, FAR_SHARE)) if judged else (None, None)
    share = float(np.mean(then > FAR))
    return [
        Row(name, f"NEES of the ten after {EARLY:g} s, at most", float(then.mean()), most, count),
        Row(name, f"share of flights with an NEES above {FAR:g} after {EARLY:g} s", share, few, count),
    ]


def _innovations(name: str, t: np.ndarray, nis: Sequence[np.ndarray], judged: bool) -> list[Row]:
    """The NIS of each sensor since the start-up noise has faded; nis: of each run, (points, 3, 2)."""
    since = start_up_over()
    rows = []
    for sensor, (total, count) in zip(SENSORS, np.sum([one[t > since] for one in nis], axis=(0, 1)), strict=True):
        band = chi_square_band(float(count)) if judged else None
        rows.append(Row(name, f"NIS of {sensor}, from {since:g} s on", float(total / count), band, len(nis)))
    return rows


_NO_TARGET = (
    "NEES of all states has no target in still water: there the motion follows exactly from where it began, and the "
    "random walk that keeps its covariance positive definite makes sigma too large."
)


def _bank(title: str, t: np.ndarray, weights: np.ndarray) -> Plot:
    figure = go.Figure()
    for i, intensity in enumerate(shipped().turbulence):
        figure.add_scatter(
            x=t, y=weights[:, i], name=f"{intensity:g} m/s", line={"color": COLOURS[i]}, stackgroup="all"
        )
    figure.update_layout(xaxis={"title": "t, s"}, yaxis={"title": "probability", "range": [0, 1]})
    return Plot(title, "Of each intensity of the eddies, averaged over the seeds.", figure)


CASES = (
    Case(
        "consistency",
        "PRBS with noise and a correct model, in still water and in eddies of 0.05 m/s; the shipped bank decides.",
        *(_run, functools.partial(evaluate, WATERS), 100, 8),
    ),
    Case(
        "consistency, rough water",
        "The same in a current with eddies of 0.05 m/s, and in eddies of 0.2 m/s, as strong as the bank reckons with.",
        *(_run_rough, functools.partial(evaluate, ROUGH), 48, 8),
    ),
)
