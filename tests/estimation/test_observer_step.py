"""One step of the observer model: as exact as it claims, and fit to fly."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba.core.runtime import _nrt_python, rtsys
from scipy.integrate import solve_ivp

from firmware_py.estimation.model import prediction
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import STILL

from .cases import ALL, TEN, VEHICLE, WIDE, case, differences, state


def stepped(model: ObserverModel, x: np.ndarray, inputs: np.ndarray, h: float, steps: int = 1) -> np.ndarray:
    x = x.copy()
    for _ in range(steps):
        assert model.advance(x, inputs, h)
    return x


@pytest.mark.parametrize("seed", range(3))
def test_the_step_is_of_fourth_order(seed: int) -> None:
    at, model = case(seed), ObserverModel(VEHICLE, TEN)
    x = state(model, at)

    def f(_: float, moving: np.ndarray) -> tuple[float, ...]:
        return model.rates(np.array([*moving, *x[9:]]), at.inputs)

    exact = solve_ivp(f, (0.0, 0.8), x[:9], "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    errors = [np.abs(stepped(model, x, at.inputs, 0.8 / n, n)[:9] - exact).max() for n in (16, 32)]
    assert 12.0 < errors[0] / errors[1] < 22.0
    assert np.abs(stepped(model, x, at.inputs, 0.01, 80)[:9] - exact).max() < 1e-7


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("names", [TEN, WIDE, ALL], ids=["19 + 2", "29", "every coefficient"])
def test_the_transition_matrix_is_the_slope_of_the_step(names: tuple[str, ...], seed: int) -> None:
    at, model = case(seed), ObserverModel(VEHICLE, names)
    x = state(model, at)

    def off(h: float) -> np.ndarray:
        """The error of each column: states and current as they are, a coefficient by what it is believed to be."""
        scale = np.ones(model.size)
        scale[11:] = np.abs(x[11:])
        assert model.advance(x.copy(), at.inputs, h)
        Phi = model.transition()
        wanted = differences(lambda z: stepped(model, z, at.inputs, h)[:9], x)
        return np.abs(Phi - wanted).max(axis=0) * scale

    assert off(0.01).max() < 1e-5
    assert 6.0 < off(0.1).max() / off(0.05).max() < 10.0  # what is left out is of third order in the step


def test_without_current_states_the_rest_moves_as_in_still_water() -> None:
    at, still, carried = case(4), ObserverModel(VEHICLE, TEN, STILL), ObserverModel(VEHICLE, TEN)
    a, b = still.state(at.nu, at.angles), carried.state(at.nu, at.angles)
    assert (len(a), len(b)) == (19, 21)
    assert still.advance(a, at.inputs, 0.01)
    assert carried.advance(b, at.inputs, 0.01)
    np.testing.assert_array_equal(a, np.delete(b, [9, 10]))
    np.testing.assert_array_equal(still.transition(), np.delete(carried.transition(), [9, 10], axis=1))


def test_steps_are_the_same_to_the_last_bit() -> None:
    ends = []
    for _ in range(2):
        model = ObserverModel(VEHICLE, WIDE)
        x = state(model, case(5))
        for _ in range(200):
            assert model.advance(x, case(5).inputs, 0.01)
        ends.append(x.tobytes() + model.transition().tobytes())
    assert ends[0] == ends[1]


@numba.njit
def many(steps: int, model, inputs, h, x, step) -> None:
    for _ in range(steps):
        prediction.predict(model, inputs, h, x, step)


def test_a_step_allocates_and_compiles_nothing() -> None:
    model = ObserverModel(VEHICLE, WIDE)
    x = state(model, case(5))
    _nrt_python.memsys_enable_stats()

    def allocated(steps: int) -> tuple[int, int]:
        """By a call of that many steps; the call itself boxes its arrays."""
        before = rtsys.get_allocation_stats()
        many(steps, model.arrays, case(5).inputs, 0.01, x, model.linearisation)
        after = rtsys.get_allocation_stats()
        return after.alloc - before.alloc, after.mi_alloc - before.mi_alloc

    allocated(1)
    signatures = list(prediction.predict.signatures)
    assert allocated(1) == allocated(300)
    assert prediction.predict.signatures == signatures
    x.flags.writeable = False
    with pytest.raises(TypeError, match="No matching definition"):
        model.advance(x, case(5).inputs, 0.01)


@given(
    st.floats(-3.0, 3.0) | st.just(0.0),
    st.floats(-15.0, 15.0) | st.just(0.0),
    st.floats(-np.pi, np.pi) | st.sampled_from([-np.pi / 2, np.pi / 2]),
)
def test_at_rest_astern_and_on_end_every_number_stays_finite(u: float, n: float, theta: float) -> None:
    model = ObserverModel(VEHICLE, WIDE)
    x = model.state((u, 0, 0, 0, 0, 0), (0, theta, 0))
    assert model.advance(x, np.array([0.3, 0.3, 0.0, n]), 0.01)
    assert np.isfinite(x).all()
    assert np.isfinite(model.transition()).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_number_that_is_not_finite_stops_the_step_and_leaves_the_state(bad: float) -> None:
    model = ObserverModel(VEHICLE, TEN)
    x = state(model, case(6))
    x[4] = bad
    before = x.copy()
    assert not model.advance(x, case(6).inputs, 0.01)
    np.testing.assert_array_equal(x, before)
