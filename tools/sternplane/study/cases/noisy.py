"""With the sensors' noise and a correct model: how near the filter comes to the bound."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from sternplane.study.figures import bars, final, over_time, per_name, rms
from sternplane.study.rows import Case, Findings, Numbers, Row
from sternplane.study.setups import (
    ITERATION_TIMES,
    PAPER_EKF,
    UNKNOWN_WATER,
    Setup,
    bounded,
    flown,
    learn,
    starts,
    vehicle,
)

WRONG = 0.5
"""How far off every coefficient starts; it is also the filter's prior sigma."""
MINUTE = Setup()
LONG = Setup(duration=900.0, h=0.02, inertial=50.0)
STREAM = Setup(current=0.2)
WORST_SEEDS = 40
SWAY = {"Y_dr": 14.53, "Y_r": 9.61, "Y_v": 23.29}


def still_water() -> CoefficientEkf:
    """A filter that knows that there is no current."""
    return CoefficientEkf(vehicle(), CoefficientParams(std=WRONG, current=False, iteration_times=ITERATION_TIMES))


def any_water() -> CoefficientEkf:
    """A filter that estimates a current."""
    return CoefficientEkf(vehicle(), CoefficientParams(std=WRONG, **UNKNOWN_WATER))


def _minute(seed: int, k: int) -> Numbers:
    del k
    trial, still, any_ = flown(MINUTE, seed), still_water(), any_water()
    wrong = starts(seed, WRONG)
    run = learn(MINUTE, trial, still, seed, wrong)
    return {
        **run.numbers(),
        "bound": bounded(MINUTE, trial, still, seed, run.t),
        "with current": learn(MINUTE, trial, any_, seed, wrong).error[-1:],
        "bound with current": bounded(MINUTE, trial, any_, seed, (MINUTE.duration,)),
    }


def _judge_minute(runs: Sequence[Numbers]) -> Findings:
    name = f"sensor noise, PRBS, start +-50 %, correct model, {MINUTE.words}"
    error, limit = final(runs), final(runs, "bound")
    most = 100.0 * np.abs(error[:WORST_SEEDS]).max(axis=0)
    rows = [
        Row(name, f"worst of {min(len(runs), WORST_SEEDS)} seeds, %, {at}", float(most[TEN.index(at)]), SWAY[at])
        for at in SWAY
    ]
    ratio = rms(error) / rms(limit)
    rows += per_name(name, f"RMS over bound, {len(runs)} seeds", ratio, (0.85, 1.15))
    flowing, flowing_limit = np.array([run["with current"][-1] for run in runs]), final(runs, "bound with current")
    other = rms(flowing) / rms(flowing_limit)
    rows += per_name(name, f"the same, a filter that also estimates a current, {len(runs)} seeds", other, None)
    note = "RMS error over the Cramér-Rao bound of the same flights; the lines are 0.85 and 1.15."
    shown = {"still water known": ratio, "current estimated too": other}
    whole = np.array([run["error"] for run in runs])
    curve = np.sqrt(np.mean([run["bound"] ** 2 for run in runs], axis=0))
    return Findings(
        rows,
        [
            bars("Sensor noise, 60 s: RMS over bound", note, "RMS / bound", shown, (0.85, 1.15)),
            over_time("Sensor noise, 60 s", "RMS over the seeds; dotted: the bound.", runs[0]["t"], whole, curve),
        ],
    )


def _long(seed: int, k: int) -> Numbers:
    del k
    trial, ekf = flown(LONG, seed), any_water()
    run = learn(LONG, trial, ekf, seed, starts(seed, WRONG))
    return {**run.numbers(), "bound": bounded(LONG, trial, ekf, seed, run.t)}


def _judge_long(runs: Sequence[Numbers]) -> Findings:
    name = f"sensor noise, PRBS, start +-50 %, {LONG.words}"
    middle = 100.0 * np.median(np.abs(final(runs)), axis=0)
    rows = per_name(name, f"median error of {len(runs)} seeds, %", middle, PAPER_EKF)
    limit = 67.4489 * rms(final(runs, "bound"))
    rows += per_name(name, "median that the bound allows, %", limit, None)
    series = {
        "median error": middle,
        "what the bound allows": limit,
        "paper's EKF, noise-free": list(PAPER_EKF.values()),
    }
    whole = np.array([run["error"] for run in runs])
    curve = np.sqrt(np.mean([run["bound"] ** 2 for run in runs], axis=0))
    note = "Medians after 900 s, beside the paper's errors without noise."
    return Findings(
        rows,
        [
            bars("900 s with noise", note, "median error, %", {k: np.array(v) for k, v in series.items()}, log=True),
            over_time("900 s with noise", "RMS over the seeds; dotted: the bound.", runs[0]["t"], whole, curve),
        ],
    )


def _stream(seed: int, k: int) -> Numbers:
    del k
    out: dict[str, np.ndarray] = {}
    for label, setup in (("still", MINUTE), ("stream", STREAM)):
        trial, ekf = flown(setup, seed), any_water()
        run = learn(setup, trial, ekf, seed, starts(seed, WRONG))
        out |= {f"{label} {key}": value for key, value in run.numbers().items()}
        out[f"{label} bound"] = bounded(setup, trial, ekf, seed, (setup.duration,))
    return {**out, "t": out["stream t"]}


def _judge_stream(runs: Sequence[Numbers]) -> Findings:
    name = f"unknown current 0.2 m/s, random direction, PRBS, start +-50 %, {STREAM.words}"
    still, stream = (final(runs, f"{label} error") for label in ("still", "stream"))
    rows = per_name(name, f"RMS over RMS without current, {len(runs)} seeds", rms(stream) / rms(still), 1.3)
    flow = final(runs, "stream current")
    rows.append(
        Row(name, "current, RMS of the vector's error, m/s", float(np.sqrt((flow**2).sum(axis=1).mean())), 0.01)
    )
    limit = rms(final(runs, "stream bound"))
    rows += per_name(name, "RMS over bound", rms(stream) / limit, None)
    series = {"0.2 m/s": 100.0 * rms(stream), "still": 100.0 * rms(still), "bound at 0.2 m/s": 100.0 * limit}
    note = "The filter estimates the current in both."
    return Findings(rows, [bars("Unknown current", note, "RMS error, %", series, log=True)])


CASES = (
    Case(
        "noisy",
        "PRBS with the sensors' noise at their own rates; every coefficient starts 50 % off, to a side that is drawn.",
        *(_minute, _judge_minute, 400, 24),
    ),
    Case(
        "long",
        "The same for a quarter of an hour with slower sensors, by a filter that also estimates a current.",
        *(_long, _judge_long, 40, 4),
    ),
    Case(
        "current",
        "A current that nobody was told of, and the same flight without it, both by a filter that estimates one.",
        *(_stream, _judge_stream, 100, 12),
    ),
)
