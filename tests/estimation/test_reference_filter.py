"""The motion about which a pass takes its slopes: it must know nothing of what the eddies did later."""

from __future__ import annotations

import numpy as np
import pytest
from sternplane.sitl.busless_flight import N_TRIM, fly, held_level
from sternplane.study.setups import AMPLITUDE, Setup, excitation, run_filter, shipped, true_vehicle

from firmware_py.estimation.coefficient_ekf import CoefficientEkf

from .cases import VEHICLE

STEERED = Setup(duration=40.0, turbulence=0.05)
SMALL = 0.025
"""Of the usual excitation: fins of half a degree, and what holds the depth."""


@pytest.mark.parametrize("seed", [0, 2])
def test_a_pass_is_honest_where_the_water_moves_the_vehicle_more_than_its_fins_do(seed: int) -> None:
    """About a smoothed motion NEES was 12, and eddies of 0.02 m/s were believed."""
    fins = SMALL * excitation(STEERED, seed)
    assert np.abs(fins).max() < 0.05 * AMPLITUDE
    flight = fly(
        true_vehicle(), fins, N_TRIM, STEERED.h, seed, STEERED.drift(seed), STEERED.turbulence, hold=held_level()
    )
    ekf = CoefficientEkf(VEHICLE, shipped())
    run = run_filter(STEERED, flight, ekf, seed, {})
    assert ekf.iteration.accepted >= 2
    assert run.nees[-1, 0] / 10.0 < 2.0
    assert np.abs(run.error[-1] / run.std[-1]).max() < 4.0
    assert run.weights[-1, shipped().turbulence.index(0.05)] > 0.9
