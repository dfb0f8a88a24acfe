"""The start-up of the filter, compiled: when parameters begin to learn, and the noise that covers wrong slopes.

Begun far from the truth, an extended Kalman filter believes slopes that are not the right ones, and becomes too sure of
what follows from them: worst where two unknowns multiply, as the current and every coefficient do. So it begins in
two stages. During the learning delay coefficients are only considered, until the water is known. Then they learn, with
process noise on the velocities for what the slopes may be wrong by, which fades (Jazwinski 1970, section 8.11). A
filter that assumes eddies has such noise from the start, the more the less of the water is known: unknown water times
wrong coefficients has no slope.
"""

from __future__ import annotations

import math

from firmware_py.compiled import Vector, kernel
from firmware_py.estimation.filter.kernel_arguments import Settings, Tuning
from firmware_py.estimation.model.state import MOVING


@kernel()
def schedule(tuning: Tuning, age: Vector, first: int, h: float, settings: Settings) -> None:
    """Sets the process noise, and what learns, for a step of h (s).

    Args:
        tuning: changed.
        age: how far the start-up is, s, (1,); h more in the end; it stands while no parameter may learn.
        first: place of the first parameter.
        h: step, s.
        settings: the learning delay and the time constant of the start-up.
    """
    Q, Q_eddy, learns = tuning.Q, tuning.Q_eddy, tuning.learns
    Q_final, Q_startup, Q_eddy_startup, may_learn = (
        tuning.Q_final,
        tuning.Q_startup,
        tuning.Q_eddy_startup,
        tuning.may_learn,
    )
    delayed = age[0] < settings.learning_delay
    any_learns = False
    for j in range(len(Q)):
        may = may_learn[j]
        if j >= first:
            any_learns = any_learns or may != 0.0
            if delayed:
                may = 0.0
        learns[j] = may
        Q[j] = Q_final[j] * may
    left = math.exp(-2.0 * max(age[0] - settings.learning_delay, 0.0) / settings.startup_time)
    for j in range(MOVING):
        Q_eddy[j] = left * Q_eddy_startup[j]
        if not delayed:
            Q[j] += left * Q_startup[j]
    if delayed or any_learns:
        age[0] += h
