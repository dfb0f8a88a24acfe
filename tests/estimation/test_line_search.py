"""A step of the iteration that makes the flight less likely is halved; one that is small in each value may be far."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_records import Begun, EkfMemory
from firmware_py.estimation.iteration.iterated_filter import LAST
from firmware_py.estimation.iteration.line_search import HALVINGS, mean_square, small

from .test_iterated_filter import NOW, SENSOR_STD, bits, given_to, started

ROWS, NO_NUMBER = 300, float("nan")


def test_a_move_is_measured_in_every_direction() -> None:
    sigma, together = np.array([1.0, 0.01]), np.array([[1.0, 0.9999], [0.9999, 1.0]])
    covariance = together * np.outer(sigma, sigma)
    along, across = sigma * [2.0, 2.0], sigma * [2.0, -2.0]
    assert mean_square(along, covariance) == pytest.approx(2.0, rel=1e-3)
    assert mean_square(across, covariance) == pytest.approx(4.0 / 1e-4, rel=1e-3)
    assert small(along, sigma, covariance)
    assert not small(across, sigma, covariance)
    assert not small(sigma * [4.1, 4.1], sigma, covariance)


def test_what_is_known_exactly_is_left_out() -> None:
    covariance = np.diag([1.0, 0.0])
    assert mean_square(np.array([3.0, 0.0]), covariance) == pytest.approx(9.0)
    assert mean_square(np.zeros(2), np.zeros((2, 2))) == 0.0


def last_pass(seed: int, explained: float, shift: float = 0.1) -> tuple[EkfMemory, np.ndarray, np.ndarray, np.ndarray]:
    """Return a filter in its last pass, whose step began elsewhere; what it goes on with; what the step began with."""
    x, inputs, z = given_to(seed)
    ekf, k = started(x), 0
    while not (ekf.iteration._stage == LAST and 0 <= ekf.iteration._row < ROWS):
        ekf.step(inputs[k], NOW.h, z[k], SENSOR_STD**2)
        k += 1
    memory = ekf.freeze()
    began = ekf.iteration._mean.copy()
    began[ekf.model.first] *= 1.0 + shift
    step = Begun(began, ROWS, explained, 0), 0
    return memory._replace(iteration=memory.iteration._replace(step=step)), inputs[k:], z[k:], began


def halved(ekf: CoefficientEkf, inputs: np.ndarray, z: np.ndarray) -> list[np.ndarray]:
    """Run to the end; return what each pass begins with of which a step was halved."""
    began, search = list[np.ndarray](), ekf.iteration._search
    for u, heard in zip(inputs, z, strict=True):
        before = search.halvings
        ekf.step(u, NOW.h, heard, SENSOR_STD**2)
        if search.halvings > before:
            began.append(ekf.iteration._mean.copy())
    return began


def test_a_step_to_what_explains_the_flight_worse_is_halved_until_nothing_is_left_of_it() -> None:
    memory, inputs, z, before = last_pass(1, 1e9)
    ekf = started(given_to(1)[0])
    ekf.thaw(memory)
    end = ekf.iteration._mean.copy()
    passes = halved(ekf, inputs, z)
    assert len(passes) == HALVINGS
    for k, began in enumerate(passes, 1):
        np.testing.assert_allclose(began, before + (end - before) / 2**k, atol=1e-12)
    assert ekf.iteration.accepted


def test_a_step_to_what_explains_the_flight_better_is_made_whole() -> None:
    memory, inputs, z, _ = last_pass(1, -1e9)
    ekf, alone = started(given_to(1)[0]), started(given_to(1)[0])
    ekf.thaw(memory)
    alone.thaw(memory._replace(iteration=memory.iteration._replace(step=(None, 0))))
    assert not halved(ekf, inputs, z)
    halved(alone, inputs, z)
    assert bits(ekf) == bits(alone)


def test_a_step_that_leads_to_no_number_is_halved() -> None:
    memory, inputs, z, _ = last_pass(2, -1e9)
    ekf = started(given_to(2)[0])
    ekf.thaw(memory)
    ekf.iteration._bank.x[:, ekf.model.first] = NO_NUMBER
    assert len(halved(ekf, inputs[:1], z[:1])) == 1


def test_halving_is_the_same_to_the_last_bit_however_a_run_is_cut() -> None:
    memory, inputs, z, _ = last_pass(3, 1e9)
    whole, parts, calls = (started(given_to(3)[0]) for _ in range(3))
    for ekf in (whole, parts, calls):
        ekf.thaw(memory)
    whole.run(NOW.h, inputs, z, SENSOR_STD**2)
    for k in range(0, len(inputs), 37):
        parts.run(NOW.h, inputs[k : k + 37], z[k : k + 37], SENSOR_STD**2)
        parts.thaw(parts.freeze())
    assert len(halved(calls, inputs, z)) == HALVINGS
    assert bits(whole) == bits(parts) == bits(calls)
