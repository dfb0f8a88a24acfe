"""Fin angles and gyro a few milliseconds apart: the bias it gives, and what knowing the times is worth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.state import MOVING
from sternplane.logs.tracking import Array
from sternplane.sitl.busless_flight import N_TRIM, BuslessFlight, fly, held_level, measurement_mask
from sternplane.study.cases.noisy import still_water
from sternplane.study.figures import bars
from sternplane.study.rows import Case, Results, Row, RunArrays
from sternplane.study.setups import FIXED_SEED, MARGIN, Setup, excitation, true_vehicle

SETUP = Setup()
FINE = 0.001
"""Step of the plant, s; its servos lag, so that fins move through a step."""
REACHED = 0.6964
"""Greatest bias over sigma with the delay known, when the target was written."""
LATE = (0.0, 0.002, 0.005, 0.010)
"""By how much the AHRS is late, s."""


def _run(seed: int, k: int) -> RunArrays:
    """Bias over sigma, exact measurements: without knowing how late they are, and with."""
    late, every = round(LATE[k] / FINE), round(SETUP.h / FINE)
    del seed
    seed = FIXED_SEED  # the same flight for every delay
    demands = np.repeat(excitation(SETUP, seed), every, axis=0)
    flight = fly(true_vehicle(), demands, N_TRIM, FINE, seed, ideal_fins=False, hold=held_level())
    return {
        "t": np.array([SETUP.duration]),
        "without": _bias(flight, every, late, 0),
        "with": _bias(flight, every, late, late),
    }


def _bias(flight: BuslessFlight, every: int, late: int, known: int) -> Array:
    """Error over sigma of the ten at the end.

    Sensors say at k h what was the case `late` fine steps before. Fins tell their angle each h, at its very time. The
    filter takes a measurement to be `known` fine steps old, and the fins' means over the spans between those times.
    """
    steps = (len(flight.inputs) // every) - 2
    at = every * np.arange(1, steps + 1) - late
    states, t_known = flight.x[at], (every * np.arange(1, steps + 1) - known).astype(float)
    told = np.arange(0, len(flight.inputs), every)
    heard = np.array([np.interp(t_known, told, flight.inputs[told, i]) for i in range(4)]).T
    inputs = 0.5 * (heard[1:] + heard[:-1])
    came = measurement_mask(steps, SETUP.h, SETUP.rates)[1:]
    z = np.where(came, states[1:], np.nan)
    ekf = still_water()
    model = ekf.model
    ekf.start(states[0, :6].tolist(), states[0, 6:MOVING].tolist(), SETUP.std.tolist())
    ekf.run(SETUP.h, np.ascontiguousarray(inputs), z, SETUP.std**2, every=len(inputs))
    seen = ekf.estimate()
    bias: Array = (seen.values - np.array(model.believed)) / seen.std
    return bias


def _evaluate(runs: Sequence[RunArrays]) -> Results:
    name = f"AHRS late against the fins, noise-free through servos with lag, {SETUP.label}"
    rows, plots = [], {}
    for late, run in zip(LATE, runs, strict=True):
        label = f"{1000 * late:g} ms"
        for how in ("without", "with"):
            bias = np.abs(run[how])
            worst = TEN[int(np.argmax(bias))]
            target = MARGIN * REACHED if how == "with" else None
            rows.append(
                Row(name, f"bias in sigmas, {label}, {how} correction, worst ({worst})", float(bias.max()), target)
            )
        plots[f"{label}, without"] = np.abs(run["without"])
    plots = {key: value for key, value in plots.items() if not key.startswith(("0 ms", "2 ms"))}
    plots["10 ms, with"] = np.abs(runs[-1]["with"])
    note = "Bias of each coefficient over the sigma that the filter claims after 60 s; the line is 1."
    return Results(rows, [bars("Misalignment", note, "bias / sigma", plots, (1.0,), log=True)])


CASES = (
    Case(
        "misaligned",
        "Exact measurements that come 0 to 10 ms late against the fin angles, the delay unknown and known.",
        *(_run, _evaluate, len(LATE), len(LATE)),
    ),
)
