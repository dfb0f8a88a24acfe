"""A pass of the bank through the measurement history, all slopes taken about one motion, compiled.

It is the iterated filter's (Bell and Cathey 1993): motion and slopes are those of the reference, and each filter
carries its deviation from it. The reference goes through the same rows at the same time, so that no slope knows what is
measured later.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Indices, Matrix, Vector, kernel
from firmware_py.estimation.filter.bank import reset_motion
from firmware_py.estimation.filter.consistency import NIS_WINDOW, add_nis, diverged
from firmware_py.estimation.filter.kernel_arguments import FilterBank
from firmware_py.estimation.filter.measurement_history import MeasurementHistory
from firmware_py.estimation.filter.measurement_update import start_nis, update, wrapped
from firmware_py.estimation.filter.time_update import predict_covariance
from firmware_py.estimation.filter.weighting import weigh
from firmware_py.estimation.model.kernel_arguments import Linearisation, Model
from firmware_py.estimation.model.prediction import predict
from firmware_py.estimation.model.state import MOVING, PHI, PSI, WATER, WATER_AXIS


@kernel()
def move_with_reference(model: Model, step: Linearisation, reference: Vector, deviation: Vector, x: Vector) -> None:
    """Moves the motion of x on: the reference after a step, and what became of the deviation from it, F* deviation.

    Args:
        model: of the reference.
        step: of the reference, linearised.
        reference: state after the step, (padded,).
        deviation: x less the reference before it, (padded,).
        x: changed.
    """
    Phi, response, regressors = step.Phi, step.response, step.regressors
    terms, weights, first = model.terms, model.terms.weight, model.first
    parameters, places, equations = terms.parameter, terms.regressor, terms.equation
    for i in range(MOVING):
        moved = reference[i]
        for j in range(MOVING):
            moved += Phi[i, j] * deviation[j]
        for j in range(model.water):
            moved += Phi[i, WATER + WATER_AXIS[j]] * deviation[MOVING + j]
        for k in range(len(weights)):
            force = weights[k] * regressors[places[k]] * deviation[first + parameters[k]]
            moved += response[i, equations[k]] * force
        x[i] = moved


@kernel()
def relinearised_pass(
    bank: FilterBank,
    reference: FilterBank,
    history: MeasurementHistory,
    begin: int,
    end: int,
    deviation: Matrix,
    nis: Vector,
    rejected: Indices,
    window: Matrix,
    contradicted: Vector,
    explained: Vector,
) -> bool:
    """Takes a bank through rows of the history, all filters by the slopes about one reference, and it beside them.

    Args:
        bank: the filters.
        reference: see `ReferenceFilter`; both have one linearised step.
        history: what they are given.
        begin: the row to begin with; `end` is behind the last.
        end: see begin.
        deviation: scratch, (filters, padded).
        nis: scratch, (9,).
        rejected: scratch, (9,).
        window: see `consistency.add_nis`.
        contradicted: out, (1,): becomes 1 where the measurements contradict the bank.
        explained: changed, (1,): the reference's log-likelihood is added.

    Returns:
        False if a number is not finite.
    """
    filters, width = bank.x.shape
    motion = reference.x[0]
    for k in range(begin, end):
        h, z, R = history.h[k], history.z[k], history.R[k]
        if h == 0.0:
            reset_motion(bank, z, R)
            reset_motion(reference, z, R)
            continue
        for b in range(filters):
            for j in range(width):
                deviation[b, j] = bank.x[b, j] - motion[j]
            deviation[b, PHI], deviation[b, PSI] = wrapped(deviation[b, PHI]), wrapped(deviation[b, PSI])
        weigh(bank.log_likelihood, bank.weights)
        if not predict(reference.model, history.inputs[k], h, motion, bank.step):
            return False
        start_nis(z, nis)
        fade = math.exp(-h / bank.settings.likelihood_memory)
        for b in range(filters):
            x, P = bank.x[b], bank.P[b]
            move_with_reference(bank.model, bank.step, motion, deviation[b], x)
            predict_covariance(bank, bank.intensity[b], x, P, h)
            likelihood = update(bank, x, P, bank.weights[b], z, R, nis, rejected, False)
            bank.log_likelihood[b] = fade * bank.log_likelihood[b] + likelihood
            if bank.log_likelihood[b] * 0.0 != 0.0:
                return False
        add_nis(nis, math.exp(-h / NIS_WINDOW), window)
        if diverged(window):
            contradicted[0] = 1.0
        start_nis(z, nis)
        predict_covariance(reference, reference.intensity[0], motion, reference.P[0], h)
        explained[0] += update(reference, motion, reference.P[0], 0.0, z, R, nis, rejected, False)
        if explained[0] * 0.0 != 0.0:
            return False
    return True
