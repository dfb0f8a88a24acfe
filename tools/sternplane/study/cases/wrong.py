"""Everything wrong at once: a current, and a vehicle file that is off in all that is not learned."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.observer_model import GROUPS
from sim_bridge.plant.truth import Truth
from sternplane.logs.tracking import Array
from sternplane.sitl.busless_flight import scaled_truth
from sternplane.study.chance import paired_ratio
from sternplane.study.figures import bars, broke_off, correlation, final, over_bound, over_time, per_name, rms
from sternplane.study.rows import Case, Results, RunArrays
from sternplane.study.setups import WRONG, Setup, bound_std, fly_prbs, flying, run_filter, starts, true_vehicle, vehicle

SCALES = (*GROUPS, "C_dy", "C_dz")
"""What is 20 % off: the added mass of each equation, and the cross-flow drag."""
SCALE_STD, REST_STD = 0.2, 0.05
_KNOWN: dict[str, Any] = {
    "names": (*TEN, *SCALES),
    "turbulence": (0.0,),
    "considered_std": REST_STD,
    "stds": dict.fromkeys(SCALES, SCALE_STD),
}
SETUP = Setup(duration=300.0, current=0.2)
TIMES = (120.0, 300.0)


def filter_of_all() -> CoefficientEkf:
    """Learns the ten, the scales, and every other coefficient too, each from what it may be off by.

    It is one filter: the water has no eddies, and a bank of 96 states would cost five times as much.
    """
    return CoefficientEkf(vehicle(), flying(**_KNOWN, nuisances=("rest",)))


def filter_that_considers() -> CoefficientEkf:
    """Learns the ten and the scales, and considers every other coefficient (Schmidt)."""
    return CoefficientEkf(vehicle(), flying(**_KNOWN, considered=("rest",)))


def truth_of(seed: int, ekf: CoefficientEkf) -> tuple[Truth, Array]:
    """A vehicle that is not as the file has it, and its parameters as the filter's model has them.

    Everything but the ten is off by its prior sigma, to a side that is drawn.
    """
    signs = np.random.default_rng([seed, *b"boat"]).choice((-1.0, 1.0), len(ekf.model.names))
    factors = {}
    for name, sign in zip(ekf.model.names, signs.tolist(), strict=True):
        off = 0.0 if name in TEN else SCALE_STD if name in SCALES else REST_STD
        factors[name] = 1.0 + off * sign
    each = {member: f for name, f in factors.items() for member in GROUPS.get(name, (name,))}
    true = np.array(ekf.model.believed) * np.array(list(factors.values()))
    return scaled_truth(true_vehicle(), each), true


def _run(seed: int, k: int) -> RunArrays:
    del k
    ekf = filter_of_all()
    truth, true = truth_of(seed, ekf)
    flight = fly_prbs(SETUP, seed, truth)
    run = run_filter(SETUP, flight, ekf, seed, starts(seed, WRONG), true)
    schmidt = run_filter(SETUP, flight, filter_that_considers(), seed, starts(seed, WRONG), true)
    limit = bound_std(SETUP, flight, ekf, seed, run.t, true)
    ten = run._replace(error=run.error[:, :10], std=run.std[:, :10]).arrays()
    return {**ten, "bound": limit[:, :10], "considered": schmidt.error[:, :10], "its sigma": schmidt.std[:, :10]}


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    label = dataclasses.replace(SETUP, duration=0.0).label.removeprefix("0 s, ")
    name = f"everything wrong, PRBS, {label}"
    ends = [final(runs, SETUP.duration, key) for key in ("error", "considered")]
    rows = [broke_off(name, *ends)]
    whole = [run for run, *each in zip(runs, *ends, strict=True) if np.isfinite(each).all()]
    if not whole:
        return Results(rows)
    ratios, errors, limits, scaled = {}, {}, {}, {}
    for t in TIMES:
        at = int(np.argmin(np.abs(whole[0]["t"] - t)))
        error, limit = (np.array([run[key][at] for run in whole]) for key in ("error", "bound"))
        ratios[f"after {t:g} s"], band, ratio_rows = over_bound(name, f"RMS over bound after {t:g} s", error, limit)
        errors[t], limits[t], scaled[t] = rms(error), rms(limit), error / limit
        rows += ratio_rows
        rows += per_name(name, f"RMS error after {t:g} s, %", 100.0 * errors[t], None)
        beside, claimed = (rms(np.array([run[key][at] for run in whole])) for key in ("considered", "its sigma"))
        rows += per_name(name, f"the rest considered, RMS over bound after {t:g} s", beside / rms(limit), None)
        rows += per_name(name, f"the rest considered, its sigma over bound after {t:g} s", claimed / rms(limit), None)
    expected, least = limits[300.0] / limits[120.0], correlation(scaled[120.0], scaled[300.0])
    reach = [e * paired_ratio(len(whole), r) for e, r in zip(expected.tolist(), least.tolist(), strict=True)]
    target = {at: max(1.0, one) for at, one in zip(TEN, reach, strict=True)}
    rows += per_name(name, "RMS after 300 s over RMS after 120 s", errors[300.0] / errors[120.0], target, len(whole))
    note = f"Over the bound that takes the same uncertain file into account; the line is {band[1]:.2f}."
    curve = np.sqrt(np.mean([run["bound"] ** 2 for run in whole], axis=0))
    error = np.array([run["error"] for run in whole])
    return Results(
        rows,
        [
            bars("Everything wrong: RMS over bound", note, "RMS / bound", ratios, (band[1],)),
            over_time("Everything wrong", "RMS over the seeds; dotted: the bound.", whole[0]["t"], error, curve),
        ],
        [f"The other rows are those of {len(whole)} of {len(runs)} runs."] if len(whole) < len(runs) else (),
    )


CASES = (
    Case(
        "everything wrong",
        "Current 0.2 m/s, added mass +-20 % by equation, cross-flow drag +-20 %, every other coefficient +-5 %, and "
        "the ten start +-50 %; sides drawn. The filter learns all of it; beside it stands one that considers the rest "
        "(Schmidt), whose own sigma tells how well that can do.",
        *(_run, _evaluate, 40, 4),
    ),
)
