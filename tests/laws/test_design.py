"""The sliding-mode design on any controllable model, with numpy's eigenvalues as the judge."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_py.control.sliding_mode_design import DesignError, SlidingDesign, control_law, design_sliding_mode
from firmware_py.vehicle.linear_models import LinearModel

entry = st.floats(-3.0, 3.0)
row = st.tuples(entry, entry, entry)
model = st.builds(LinearModel, st.tuples(row, row, row), row)
pole = st.floats(-2.0, -0.1)


def placed(
    linear: LinearModel, poles: tuple[float, float], last: float = 1.0
) -> tuple[np.ndarray, np.ndarray, SlidingDesign]:
    A, b = np.array(linear.A), np.array(linear.b)
    assume(np.abs(b).max() > 0.01)
    assume(np.linalg.cond(np.column_stack([b, A @ b, A @ A @ b])) < 300.0)
    try:
        sliding = design_sliding_mode(linear, poles, last, 0.3, 0.2)
    except DesignError:  # sigma without the last state: then scaling by it means nothing
        assume(False)
    assume(max(map(abs, sliding.s)) < 100.0)
    return A, b, sliding


@given(model, pole, pole, st.sampled_from([-1.0, 1.0]))
def test_s_is_the_left_eigenvector_at_the_origin_and_the_poles_are_where_they_were_asked(
    linear: LinearModel, p1: float, p2: float, last: float
) -> None:
    A, b, sliding = placed(linear, (p1, p2), last)
    s, k = np.array(sliding.s), np.array(sliding.k)
    closed = A - np.outer(b, k)
    scale = np.abs(s).max() * (np.abs(A).max() + np.abs(np.outer(b, k)).max())
    assert np.abs(s @ closed).max() < 1e-9 * scale
    assert s[2] == pytest.approx(last)
    asked = np.poly([0.0, p1, p2])
    assert np.allclose(np.poly(closed), asked, atol=1e-6 * (1.0 + np.abs(closed).max() ** 3))
    assert sliding.s_b == pytest.approx(float(s @ b), rel=1e-6)
    assert sliding.eta == pytest.approx(abs(sliding.s_b) * 0.3)


@given(model, pole, pole, row, row, entry)
def test_the_law_is_equation_25_on_any_trajectory_of_the_model(
    linear: LinearModel, p1: float, p2: float, x: tuple, x_d: tuple, delta_d: float
) -> None:
    A, b, sliding = placed(linear, (p1, p2))
    s, k, state, wanted = np.array(sliding.s), np.array(sliding.k), np.array(x), np.array(x_d)
    u, sigma = control_law(sliding, tuple(state - wanted), delta_d)
    wanted_dot = A @ wanted + b * delta_d
    assert sigma == pytest.approx(float(s @ (state - wanted)), abs=1e-9)
    switch = sliding.eta / sliding.s_b * math.tanh(sigma / sliding.phi_b)
    by_equation_25 = -k @ state + s @ wanted_dot / sliding.s_b - switch
    assert u == pytest.approx(by_equation_25, abs=1e-6 * (1.0 + np.abs(k).max() + np.abs(s).max() / abs(sliding.s_b)))


@given(model, pole, pole, row)
def test_sigma_falls_at_the_switching_rate_wherever_the_state_is(
    linear: LinearModel, p1: float, p2: float, x: tuple
) -> None:
    A, b, sliding = placed(linear, (p1, p2))
    u, sigma = control_law(sliding, x, 0.0)
    sigma_dot = np.array(sliding.s) @ (A @ np.array(x) + b * u)
    expected = -sliding.eta * math.tanh(sigma / sliding.phi_b)
    assert sigma_dot == pytest.approx(expected, abs=1e-6 * (1.0 + np.abs(sliding.s).max() * np.abs(b).max() * abs(u)))


@pytest.mark.parametrize(
    "linear",
    [
        LinearModel(((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 3.0)), (1.0, 1.0, 0.0)),
        LinearModel(((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), (-0.2, 0.0, 0.0)),
        LinearModel(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), (0.0, 0.0, 0.0)),
        LinearModel(((math.nan, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), (1.0, 0.0, 0.0)),
    ],
)
def test_a_model_that_no_gain_can_place_is_refused(linear: LinearModel) -> None:
    with pytest.raises(DesignError, match="not controllable"):
        design_sliding_mode(linear, (-0.3, -0.4), 1.0, 1.0, 1.0)
