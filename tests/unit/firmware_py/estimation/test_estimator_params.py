"""An estimator that goes on by other parameters: as one made of nothing would, without its filter being made anew."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from firmware_py.estimation import coefficient_estimator
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.estimator import EstimationParams, Estimator
from firmware_py.marine import Origin
from firmware_py.params import ParamError
from firmware_py.records.sensing import Heard
from tests.estimation.cases import VEHICLE
from tests.estimation.flights import Moment, flown, hears, moments

HERE, THERE = Origin(0.6, -2.1), Origin(0.7, -2.1)
TEN_METRES = 101_325.0 + 1000.0 * 9.81 * 10.0
PARAMS = EstimationParams(coefficients=CoefficientParams(iteration_times=(4.0, 10.0)))
COURSE = [
    moment._replace(frame=hears(moment.frame, pressure=Heard(TEN_METRES, moment.t, True, True)))
    for moment in moments(flown(22.0))
]
CHANGED = 1850
"""The tick of the change: something has been learned and iterated by then."""


def other(**tables: dict[str, Any]) -> EstimationParams:
    """PARAMS with other values, by table and name."""
    return dataclasses.replace(
        PARAMS, **{name: dataclasses.replace(getattr(PARAMS, name), **values) for name, values in tables.items()}
    )


CHANGES = {
    "navigation": other(depth={"tau": 0.7}, attitude={"tau": 0.9}),
    "health": other(health={"nis_time": 3.0, "valid_std": 0.01, "invalid_std": 0.02}),
    "learning": other(learning={"depth_min": 50.0}),
    "horizon": other(learning={"horizon": dataclasses.replace(PARAMS.learning.horizon, lag=0.3)}),
    "coefficients": other(coefficients={"rate_noise": 1e-3}),
}


def update(estimator: Estimator, course: list[Moment]) -> list[Any]:
    return [estimator.update(moment.tick, moment.frame, moment.applied) for moment in course]


def begun() -> Estimator:
    estimator = Estimator(PARAMS, HERE, VEHICLE)
    assert any(update(estimator, COURSE[:CHANGED])[-1].learned.valid)
    return estimator


@pytest.mark.parametrize("table", CHANGES)
def test_it_goes_on_as_one_that_was_made_of_nothing_and_thawed(table: str) -> None:
    params, before = CHANGES[table], begun()
    made = Estimator(params, THERE, VEHICLE)
    made.thaw(before.freeze())
    wanted = repr(update(made, COURSE[CHANGED:]))
    assert repr(update(begun().with_params(params, THERE), COURSE[CHANGED:])) == wanted
    assert repr(update(before, COURSE[CHANGED:])) != wanted


def test_the_filter_is_made_anew_for_other_coefficients_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[CoefficientParams] = []
    anew = coefficient_estimator.CoefficientEkf
    monkeypatch.setattr(
        coefficient_estimator, "CoefficientEkf", lambda vehicle, params: made.append(params) or anew(vehicle, params)
    )
    estimator = Estimator(PARAMS, HERE, VEHICLE)
    for table in ("navigation", "health", "learning", "horizon"):
        estimator = estimator.with_params(CHANGES[table], HERE)
    assert made == [PARAMS.coefficients]
    estimator.with_params(CHANGES["coefficients"], HERE)
    assert made == [PARAMS.coefficients, CHANGES["coefficients"].coefficients]


def test_what_cannot_be_made_leaves_the_old_one_as_it_was() -> None:
    one, same = begun(), begun()
    with pytest.raises(ParamError, match="turbulence needs current"):
        one.with_params(other(coefficients={"turbulence": (0.0, 0.1), "current": False}), HERE)
    assert repr(update(one, COURSE[CHANGED:])) == repr(update(same, COURSE[CHANGED:]))
