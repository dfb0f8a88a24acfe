"""The bank of filters, compiled: a step of all of them, and runs of steps.

The filters differ in one thing, the intensity of the eddies that they assume; their likelihoods decide between them.
A step is, for each filter: predict the state and the covariance, then update both by what was measured. Nothing is
allocated.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Indices, Vector, kernel
from firmware_py.estimation.filter.consistency import NIS_WINDOW, add_burst, add_nis, bursts, diverged
from firmware_py.estimation.filter.kernel_arguments import FilterBank, Given, Monitor, Output
from firmware_py.estimation.filter.measurement_history import MeasurementHistory, record
from firmware_py.estimation.filter.measurement_update import start_nis, update
from firmware_py.estimation.filter.start_up import schedule
from firmware_py.estimation.filter.time_update import predict_covariance
from firmware_py.estimation.filter.weighting import combine, replace_unlikely, weigh
from firmware_py.estimation.model.prediction import predict
from firmware_py.estimation.model.state import EDDIES, EDDY_NORTH, MOVING, WATER_END


@kernel()
def step(bank: FilterBank, inputs: Vector, h: float, z: Vector, R: Vector, nis: Vector, rejected: Indices) -> bool:
    """Moves every filter on by h (s), then updates it by what was measured there.

    Args:
        bank: the filters.
        inputs: delta_s, delta_r, delta_b (rad), n (rev/s): means over the step.
        h: step, s.
        z: u v w p q r phi theta psi as measured, (9,); NaN where nothing came.
        R: variance of each, (9,).
        nis: out, (9,): normalised innovations squared, averaged over the filters; NaN where nothing came.
        rejected: how many measurements the most likely filter rejected, (9,); added to.

    Returns:
        False if a filter met a number that is not finite: the bank is to be started anew.
    """
    best = weigh(bank.log_likelihood, bank.weights)
    start_nis(z, nis)
    fade = math.exp(-h / bank.settings.likelihood_memory)
    for b in range(len(bank.x)):
        x, P = bank.x[b], bank.P[b]
        if not predict(bank.model, inputs, h, x, bank.step):
            return False
        predict_covariance(bank, bank.intensity[b], x, P, h)
        likelihood = update(bank, x, P, bank.weights[b], z, R, nis, rejected, b == best)
        bank.log_likelihood[b] = fade * bank.log_likelihood[b] + likelihood
        if bank.log_likelihood[b] * 0.0 != 0.0:
            return False
    return True


@kernel()
def reset_motion(bank: FilterBank, motion: Vector, variance: Vector) -> None:
    """Starts every filter anew in motion, (9,), known to `variance`, (9,), and in the eddies about it.

    The current, biases and coefficients stay as they are known.
    """
    x, P = bank.x, bank.P
    last = WATER_END if bank.model.water == EDDIES else MOVING
    for b in range(len(x)):
        for i in range(last):
            if i < MOVING or i >= EDDY_NORTH:
                x[b, i] = motion[i] if i < MOVING else 0.0
                for j in range(P.shape[2]):
                    P[b, i, j] = 0.0
                for j in range(P.shape[1]):
                    P[b, j, i] = 0.0
                P[b, i, i] = variance[i] if i < MOVING else bank.intensity[b] * bank.intensity[b]


@kernel()
def run(
    bank: FilterBank,
    monitor: Monitor,
    history: MeasurementHistory,
    used: int,
    given: Given,
    begin: int,
    end: int,
    output: Output,
) -> int:
    """Makes a step for each row of what is given.

    Args:
        bank: the filters.
        monitor: what is kept beside them.
        history: where what is given is recorded, from row `used` on, as long as there is room.
        used: see history.
        given: rows.
        begin: the row to begin with; `end` is behind the last.
        end: see begin.
        output: out.

    Returns:
        The row it came to: less than `end` if a number was not finite, or the filter diverged or the gyros contradict
        it (the windows tell).
    """
    h, window, settings = given.h, monitor.window, bank.settings
    for k in range(begin, end):
        inputs, z, nis = given.inputs[k], given.z[k], given.nis[k]
        if used + k - begin < len(history.h):
            record(history, used + k - begin, h, inputs, z, given.R)
        schedule(bank.tuning, monitor.age, bank.model.first, h, settings)
        if not step(bank, inputs, h, z, given.R, nis, monitor.rejected):
            return k
        replace_unlikely(bank)
        if (k + 1) % output.every == 0:
            row = k // output.every
            combine(bank, output.weights[row], output.mean[row], output.std[row])
        add_nis(nis, math.exp(-h / NIS_WINDOW), window)
        add_burst(nis, h, monitor.burst)
        if diverged(window) or bursts(monitor.burst):
            return k + 1
    return end
