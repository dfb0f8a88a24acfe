"""The stages of a pass: how much process noise covers slopes that may be wrong (continuation)."""

from __future__ import annotations

from firmware_py.estimation.filter.kernel_arguments import Tuning
from firmware_py.estimation.filter.vehicle_scales import VehicleScales
from firmware_py.estimation.model.state import ANGULAR, LINEAR

STAGES = (1.0, 0.3, 0.1, 0.03, 0.0)
"""Parts of the next two that a pass assumes, one after the other, each until it converges: far from the truth."""
STAGE_SPEED_NOISE, STAGE_RATE_NOISE = 0.0465, 0.0861
"""Random walk of velocities, by `VehicleScales`: about what slopes of coefficients that are half wrong leave. That is
0.05 m/s and 1 deg/s by sqrt(s) for NPS AUV II."""
LAST = len(STAGES) - 1
FIRST_INTENSITY = 0.05
"""Eddies that the reference of such a pass assumes, m/s: those of the filter that is nearest. While coefficients are
half wrong the most intense filter is the most likely, in still water too, and its motion follows all their errors: with
0.2 m/s one flight of fifty was not converged after a minute."""
EDDY_NOISE_LEFT = 0.15
"""Of the start-up noise by eddies, so much is left about a motion whose eddies are a quarter of them off. With 0.1 the
NEES in a current with eddies of 0.1 m/s is 1.2, with 0.3 it is 0.65."""


def set_noise(tuning: Tuning, scales: VehicleScales, stage: int) -> None:
    """Sets the process noise of a pass: that of what may learn, of unknown water, and of its stage."""
    tuning.Q[:] = tuning.Q_final * tuning.may_learn
    tuning.Q_eddy[:] = EDDY_NOISE_LEFT**2 * tuning.Q_eddy_startup
    tuning.Q[LINEAR] += (STAGES[stage] * STAGE_SPEED_NOISE * scales.speed_noise) ** 2
    tuning.Q[ANGULAR] += (STAGES[stage] * STAGE_RATE_NOISE * scales.rate_noise) ** 2
