"""With the sensors' noise and a correct model: how near the filter comes to the bound."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from sternplane.study.chance import greatest_of, median_of, paired_ratio, rms_band
from sternplane.study.figures import (
    bars,
    broke_off,
    correlation,
    final,
    longest,
    over_bound,
    over_runs,
    over_time,
    per_name,
    rms,
)
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import (
    PAPER_EKF,
    WRONG,
    Setup,
    bound_std,
    fly_prbs,
    flying,
    run_filter,
    starts,
    vehicle,
)
from sternplane.study.shipped_filter import shipped

MINUTE = Setup()
LONG = Setup(duration=900.0, h=0.02, inertial=50.0)
STREAM = Setup(current=0.2)
WORST_SEEDS = 40
FLYING = 1.1
"""The flying configuration may take so many times the bound."""
WORSE = 1.3
"""A current may make the RMS so many times as large; more only where chance does it."""
FLOW = 8e-4
"""Expected RMS error of the current vector after a minute, m/s."""
SWAY = {"Y_dr": 14.53, "Y_r": 9.61, "Y_v": 23.29}


def still_water() -> CoefficientEkf:
    """A filter that knows that there is no current: it needs no care at its start."""
    times = shipped().iteration_times
    return CoefficientEkf(vehicle(), CoefficientParams(std=WRONG, current=False, iteration_times=times))


def any_water() -> CoefficientEkf:
    """The filter that is shipped: it estimates a current and the intensity of the eddies."""
    return CoefficientEkf(vehicle(), flying())


def _minute(seed: int, k: int) -> RunArrays:
    del k
    flight, still, any_ = fly_prbs(MINUTE, seed), still_water(), any_water()
    wrong = starts(seed, WRONG)
    run = run_filter(MINUTE, flight, still, seed, wrong)
    return {
        **run.arrays(),
        "bound": bound_std(MINUTE, flight, still, seed, run.t),
        "with current": run_filter(MINUTE, flight, any_, seed, wrong).error[-1:],
        "bound with current": bound_std(MINUTE, flight, any_, seed, (MINUTE.duration,)),
    }


def _evaluate_minute(runs: Sequence[RunArrays]) -> Results:
    name = f"sensor noise, PRBS, start +-50 %, correct model, {MINUTE.label}"
    error, limit = (final(runs, MINUTE.duration, key) for key in ("error", "bound"))
    most = 100.0 * np.abs(error[:WORST_SEEDS]).max(axis=0)
    count = min(len(runs), WORST_SEEDS)
    reach = 100.0 * limit[:count].max(axis=0) * greatest_of(count)
    rows = [
        Row(name, f"greatest error, %, {at}", float(most[i]), float(min(SWAY[at], reach[i])), count)
        for at, i in ((at, TEN.index(at)) for at in SWAY)
    ]
    ratio, band, ratio_rows = over_bound(name, "RMS over bound", error, limit)
    rows += ratio_rows
    flowing, flowing_limit = (final(runs, MINUTE.duration, f"{key}with current") for key in ("", "bound "))
    what = "the same, the flying configuration, which also estimates a current"
    other, _, flying_rows = over_bound(name, what, flowing, flowing_limit, FLYING)
    rows += flying_rows
    rows.append(broke_off(name, error, flowing))
    note = f"RMS error over the Cramér-Rao bound of the same flights; the lines are {band[0]:.2f} and {band[1]:.2f}."
    ratios = {"still water known": ratio, "current estimated too": other}
    whole, curve, t = over_runs(runs), rms(over_runs(runs, "bound")), longest(runs)
    return Results(
        rows,
        [
            bars("Sensor noise, 60 s: RMS over bound", note, "RMS / bound", ratios, band),
            over_time("Sensor noise, 60 s", "RMS over the seeds; dotted: the bound.", t, whole, curve),
        ],
    )


def _long(seed: int, k: int) -> RunArrays:
    del k
    flight, ekf = fly_prbs(LONG, seed), any_water()
    run = run_filter(LONG, flight, ekf, seed, starts(seed, WRONG))
    return {**run.arrays(), "bound": bound_std(LONG, flight, ekf, seed, run.t)}


def _evaluate_long(runs: Sequence[RunArrays]) -> Results:
    name = f"sensor noise, PRBS, start +-50 %, {LONG.label}"
    error, bound = (final(runs, LONG.duration, key) for key in ("error", "bound"))
    middle = 100.0 * np.median(np.abs(error), axis=0)
    sigma = rms(bound)
    limit = 67.4489 * sigma
    reach = 100.0 * FLYING * sigma * median_of(len(runs))
    target = {at: max(PAPER_EKF[at], float(reach[i])) for i, at in enumerate(TEN)}
    rows = per_name(name, "median error, %", middle, target, len(runs))
    rows += per_name(name, "median that the bound allows, %", limit, PAPER_EKF)
    rows += over_bound(name, "RMS over bound", error, bound, FLYING)[2]
    rows.append(broke_off(name, error))
    series = {
        "median error": middle,
        "what the bound allows": limit,
        "paper's EKF, noise-free": list(PAPER_EKF.values()),
    }
    whole, curve, t = over_runs(runs), rms(over_runs(runs, "bound")), longest(runs)
    note = "Medians after 900 s, beside the paper's errors without noise."
    return Results(
        rows,
        [
            bars("900 s with noise", note, "median error, %", {k: np.array(v) for k, v in series.items()}, log=True),
            over_time("900 s with noise", "RMS over the seeds; dotted: the bound.", t, whole, curve),
        ],
    )


def _stream(seed: int, k: int) -> RunArrays:
    del k
    out: dict[str, np.ndarray] = {}
    for label, setup in (("still", MINUTE), ("stream", STREAM)):
        flight, ekf = fly_prbs(setup, seed), any_water()
        run = run_filter(setup, flight, ekf, seed, starts(seed, WRONG))
        out |= {f"{label} {key}": value for key, value in run.arrays().items()}
        out[f"{label} bound"] = bound_std(setup, flight, ekf, seed, (setup.duration,))
    return {**out, "t": out["stream t"]}


def _evaluate_stream(runs: Sequence[RunArrays]) -> Results:
    name = f"unknown current 0.2 m/s, random direction, PRBS, start +-50 %, {STREAM.label}"
    still, stream = (final(runs, STREAM.duration, of=f"{label} ") for label in ("still", "stream"))
    bounds = {label: final(runs, STREAM.duration, "bound", f"{label} ") for label in ("still", "stream")}
    expected = rms(bounds["stream"]) / rms(bounds["still"])
    least = correlation(still / bounds["still"], stream / bounds["stream"])
    reach = [e * paired_ratio(len(runs), r) for e, r in zip(expected.tolist(), least.tolist(), strict=True)]
    target = {at: max(WORSE, one) for at, one in zip(TEN, reach, strict=True)}
    rows = per_name(name, "RMS over RMS without current", rms(stream) / rms(still), target, len(runs))
    flow = final(runs, STREAM.duration, "current", "stream ")
    size = float(np.sqrt((flow**2).sum(axis=1).mean()))
    rows.append(Row(name, "current, RMS of the vector's error, m/s", size, rms_band(len(runs), FLOW)[1], len(runs)))
    limit = rms(bounds["stream"])
    rows += over_bound(name, "RMS over bound", stream, bounds["stream"], FLYING)[2]
    rows.append(broke_off(name, still, stream))
    series = {"0.2 m/s": 100.0 * rms(stream), "still": 100.0 * rms(still), "bound at 0.2 m/s": 100.0 * limit}
    note = "The filter estimates the current in both."
    return Results(rows, [bars("Unknown current", note, "RMS error, %", series, log=True)])


CASES = (
    Case(
        "noisy",
        "PRBS with the sensors' noise at their own rates; every coefficient starts 50 % off, to a side that is drawn.",
        *(_minute, _evaluate_minute, 400, 24),
    ),
    Case(
        "long",
        "The same for a quarter of an hour with slower sensors, by a filter that also estimates a current.",
        *(_long, _evaluate_long, 40, 4),
    ),
    Case(
        "current",
        "A current that nobody was told of, and the same flight without it, both by a filter that estimates one.",
        *(_stream, _evaluate_stream, 100, 12),
    ),
)
