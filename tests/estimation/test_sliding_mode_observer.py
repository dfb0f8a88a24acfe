"""The sliding-mode observer against the plant: it reaches, slides, rests on a hyperplane, and learns when excited."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
import pytest
from sternplane.paper.sliding_mode_observer import SlidingModeObserver, SmoParams
from sternplane.sitl.busless_flight import N_TRIM, BuslessFlight, Start, fly, held_level

from firmware_py import params
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.model.observer_model import ObserverModel
from firmware_py.estimation.model.state import STILL
from firmware_py.guidance.excitation import opposite, prbs
from firmware_py.marine import Nu
from firmware_py.vehicle.vehicle import Vehicle

from .cases import TRUTH, VEHICLE

H = 0.01
TRUE = np.array([getattr(VEHICLE.coefficients, name) for name in TEN])
TABLE_1 = {"M_q": 1.10, "M_ds": 1.46, "N_r": 24.67, "N_dr": 17.78, "N_v": 30.35}
TABLE_1 |= {"Z_ds": 3.07, "Z_q": 2.48, "Y_dr": 49.34, "Y_r": 102.57, "Y_v": 44.22}
EQUATIONS = {"M": 4, "N": 5, "Z": 2, "Y": 1}


def believing(*factors: float) -> Vehicle:
    """A vehicle file that is wrong about the ten, and so about every scale that the observer has."""
    wrong = dict(zip(TEN, TRUE * factors, strict=True))
    return dataclasses.replace(VEHICLE, coefficients=dataclasses.replace(VEHICLE.coefficients, **wrong))


HALF = believing(*(0.5,) * 10)


@functools.cache
def constant(delta_s: float = 20.0, delta_r: float = 20.0, seconds: float = 60.0) -> BuslessFlight:
    """The paper's scenario."""
    demands = np.tile(np.radians((delta_s, delta_r)), (round(seconds / H), 1))
    return fly(TRUTH, demands, N_TRIM, H, start=Start(nu=Nu(1.8, 0.0, 0.0, 0.0, 0.0, 0.0)))


@functools.cache
def excited(seconds: float = 90.0) -> BuslessFlight:
    """A PRBS of 15 degrees, held for 4 s, on both; depth and pitch held softly."""
    sides = [(prbs(k, 400, 1), prbs(k, 400, opposite(1))) for k in range(round(seconds / H))]
    return fly(TRUTH, math.radians(15.0) * np.array(sides), N_TRIM, H, hold=held_level())


def observed(vehicle: Vehicle, trial: BuslessFlight, smo: SmoParams, sides: tuple[float, float] = (1.0, 1.0)):
    observer = SlidingModeObserver(vehicle, smo, sides)
    observer.start(trial.x[0, :6], trial.x[0, 6:])
    history = observer.run(H, trial.inputs, np.ascontiguousarray(trial.x[1:]))
    assert history.steps == len(trial.inputs)
    return observer, history


def off(values: np.ndarray) -> np.ndarray:
    """Errors in % of the true values."""
    return 100.0 * (values / TRUE - 1.0)


def force_errors(values: np.ndarray, trial: BuslessFlight) -> dict[str, tuple[float, float]]:
    """Of each equation at the end: the error of its force, and that of its coefficients one by one, N or N m."""
    model = ObserverModel(VEHICLE, TEN, STILL)
    model.advance(model.state(trial.x[-1, :6], trial.x[-1, 6:]), trial.inputs[-1], 1e-9)
    parts = (model.unit_forces() * (values - TRUE)).tolist()
    return {name: (abs(sum(parts[row])), max(map(abs, parts[row]))) for name, row in EQUATIONS.items()}


# --- it slides -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("i", [1, 2, 4, 5], ids=["v", "w", "q", "r"])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_outside_the_layer_an_error_falls_at_every_step_no_slower_than_eq_9_promises(i: int, side: float) -> None:
    trial, smo = excited(), SmoParams(rate=1e-9)
    observer = SlidingModeObserver(HALF, smo)
    L, Phi = observer.gains.L[i], observer.gains.Phi[i]
    nu = trial.x[0, :6].copy()
    nu[i] += side * 10.0 * Phi
    observer.start(nu, trial.x[0, 6:])
    before, steps = 10.0 * Phi, 0
    while before > 3.0 * Phi:
        assert observer.step(trial.inputs[steps], H, trial.x[steps + 1].copy())
        error = side * (observer.x[i] - trial.x[steps + 1, i])
        assert before - error > (math.tanh(3.0) - 1.0 / smo.margin) * H * L
        before, steps = error, steps + 1
    assert steps > 5
    observer.run(H, trial.inputs[steps:400], np.ascontiguousarray(trial.x[steps + 1 : 401]))
    assert abs(observer.x[i] - trial.x[400, i]) < Phi  # and there it stays


def test_while_it_slides_the_switching_term_is_the_acceleration_that_the_model_gets_wrong() -> None:
    trial, believed, true = excited(), ObserverModel(HALF, TEN, STILL), ObserverModel(VEHICLE, TEN, STILL)
    observer, history = observed(HALF, trial, SmoParams(rate=1e-9))
    k = 1990  # 5.9 s after the fins moved last, as slow as the motion gets
    x = trial.x[k + 1]
    wrong = np.subtract(
        believed.rates(believed.state(x[:6], x[6:]), trial.inputs[k]),
        true.rates(true.state(x[:6], x[6:]), trial.inputs[k]),
    )[:6]
    switch = observer.gains.L[:6] * np.tanh(history.s[k, :6])
    for i in (1, 2, 4, 5):
        assert abs(wrong[i]) > 1e-3
        assert switch[i] == pytest.approx(wrong[i], rel=0.03)


def test_where_nothing_comes_it_goes_on_as_the_model_and_learns_nothing() -> None:
    trial, model = excited(), ObserverModel(HALF, TEN, STILL)
    observer = SlidingModeObserver(HALF, SmoParams(weighted=True))
    observer.start(trial.x[0, :6], trial.x[0, 6:])
    x = observer.x.copy()
    for k in range(100):
        assert observer.step(trial.inputs[k], H, np.full(9, np.nan))
        assert model.advance(x, trial.inputs[k], H)
    np.testing.assert_array_equal(observer.x, x)


# --- what it learns --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("factors", [(0.5,) * 10, (1.5,) * 10, (0.5, 1.5) * 5, (1.4, 1.4, 0.6, 1.2, 0.7) * 2])
def test_excited_and_weighted_by_the_regressor_it_is_under_table_1(factors: tuple[float, ...]) -> None:
    observer, history = observed(believing(*factors), excited(), SmoParams(weighted=True))
    errors = np.abs(off(observer.estimate().values))
    assert dict(zip(TEN, errors <= list(map(TABLE_1.get, TEN)), strict=True)) == dict.fromkeys(TEN, True)
    assert errors.max() < 3.0
    assert np.abs(history.s).max() < 1.0  # all the while inside the layer


def test_a_constant_gain_rests_where_forces_are_right_and_coefficients_are_not() -> None:
    trial = constant()
    ends = []
    for factor in (0.5, 0.8, 1.5):
        values = observed(believing(*(factor,) * 10), trial, SmoParams())[0].estimate().values
        begun = force_errors(factor * TRUE, trial)
        for name, (whole, part) in force_errors(values, trial).items():
            assert whole < 0.05 * part, name
            assert whole < 0.05 * max(begun[name]), name
        assert np.abs(off(values)).min() > 5.0
        ends.append(off(values))
    assert np.abs(ends[1] - ends[0]).min() > 5.0  # another start, another point of the same hyperplane
    assert ends[0] == pytest.approx(-ends[2], rel=0.02)  # which is flat: twice as far off to start, twice at the end


def test_nor_does_weighting_help_where_nothing_but_the_constant_hyperplane_is_seen() -> None:
    trial = constant()
    values = observed(HALF, trial, SmoParams(weighted=True))[0].estimate().values
    assert all(whole < 0.05 * part for whole, part in force_errors(values, trial).values())
    assert np.abs(off(values)).max() > 30.0


def test_a_constant_gain_is_made_for_one_side() -> None:
    port, starboard = constant(20.0, 20.0), constant(20.0, -20.0)
    here, there = (
        off(observed(HALF, trial, SmoParams(), (1.0, side))[0].estimate().values)
        for trial, side in ((port, 1.0), (starboard, -1.0))
    )
    assert there == pytest.approx(here, abs=1.0)  # all but the mirror image: the products of inertia are small
    observer = SlidingModeObserver(HALF, SmoParams(), (1.0, 1.0))
    observer.start(starboard.x[0, :6], starboard.x[0, 6:])
    observer.run(H, starboard.inputs, np.ascontiguousarray(starboard.x[1:]))
    assert not np.abs(off(observer.estimate().values)).max() < 1e3  # pushed the wrong way, away from the hyperplane


# --- as software -----------------------------------------------------------------------------------------------------


def test_two_runs_are_equal_to_the_last_bit() -> None:
    runs = [observed(HALF, constant(), SmoParams(weighted=True))[1] for _ in range(2)]
    assert runs[0].x.tobytes() == runs[1].x.tobytes()
    assert runs[0].s.tobytes() == runs[1].s.tobytes()


def test_a_number_that_is_not_finite_stops_it_and_a_new_start_forgets_it() -> None:
    trial, observer = constant(), SlidingModeObserver(HALF, SmoParams())
    observer.start(trial.x[0, :6], trial.x[0, 6:], {"M_q": math.inf})
    assert observer.run(H, trial.inputs, np.ascontiguousarray(trial.x[1:])).steps == 0
    observer.start(trial.x[0, :6], trial.x[0, 6:])
    assert observer.run(H, trial.inputs, np.ascontiguousarray(trial.x[1:])).steps == len(trial.inputs)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("M_q", "Y_vdot"), "does not learn added mass"),
        (("K_prop",), "nothing says how far K_prop"),
        (("M_qq",), "no coefficient is called 'M_qq'"),
    ],
)
def test_names_without_a_gain_are_refused(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(params.ParamError, match=message):
        SlidingModeObserver(VEHICLE, SmoParams(names=names))
