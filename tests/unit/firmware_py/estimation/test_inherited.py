"""What the filter begins with of an earlier flight: less certain, and only if a filter can have learned it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from firmware_py import app, config_files
from firmware_py.adapters.installation import configs
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN
from firmware_py.estimation.inherited import learned_model, prior
from firmware_py.params import ParamError
from firmware_py.records.passport import LearnedModel, Restored
from firmware_py.vehicle.vehicle import Vehicle

CONFIGURATION = {**config_files.read_configuration(configs() / "npsauv2"), "mission": {"waypoints": []}, "kept": {}}
PARAMS = config_files.autopilot_params(CONFIGURATION).estimation.coefficients


def ekf() -> CoefficientEkf:
    return CoefficientEkf(VEHICLE, PARAMS)


VEHICLE: Vehicle = config_files.vehicle(CONFIGURATION)


def known(std: float = 0.05, factor: float = 1.2) -> LearnedModel:
    """Return what a filter has learned: `factor` times the file, to a share `std` of what was known before."""
    bank = ekf().bank
    first, count = bank.model.first, bank.learning
    mean, P = np.zeros(bank.model.size), np.diag(np.maximum(bank.prior, 1e-9) ** 2)
    bounds = bank.tuning.lower[first : bank.model.size], bank.tuning.upper[first : bank.model.size]
    mean[first:] = np.clip(np.array(bank.model.believed) * factor, *bounds)
    P[first:, first:] *= std**2
    P[first, first + 1] = P[first + 1, first] = 0.9 * np.sqrt(P[first, first] * P[first + 1, first + 1])
    assert count > len(TEN)  # nuisances are inherited too
    return learned_model(bank, mean, P, (True,) * 10)


def test_a_filter_begins_with_the_values_and_a_share_of_its_first_doubt() -> None:
    model, bank = known(), ekf().bank
    names, value, P = prior(Restored(model, 0.15), bank)
    assert names == model.names
    assert value.tolist() == list(model.value)
    before = np.array([bank.prior[bank.model.place(name)] for name in names])
    assert np.sqrt(P.diagonal()) == pytest.approx(np.hypot(0.05, 0.15) * before)
    assert P[0, 1] == pytest.approx(0.9 * 0.05**2 * before[0] * before[1])


def test_a_centre_of_gravity_may_lie_on_either_side_of_where_the_file_has_it() -> None:
    nuisances = tuple([name for name in PARAMS.nuisances if name != "x_G"])
    bank = CoefficientEkf(VEHICLE, replace(PARAMS, names=(*TEN, "x_G"), nuisances=nuisances)).bank
    place = bank.model.place("x_G")
    for trim in (-0.01, 0.01):
        mean, P = np.zeros(bank.model.size), np.diag(np.maximum(0.05 * bank.prior, 1e-9) ** 2)
        mean[bank.model.first :] = bank.model.believed
        mean[place] = trim
        names, value, _ = prior(Restored(learned_model(bank, mean, P, (True,) * 11), 0.15), bank)
        assert value[names.index("x_G")] == trim


def test_none_becomes_less_certain_than_before_any_flight_and_the_covariance_stays_one() -> None:
    bank = ekf().bank
    names, _, P = prior(Restored(known(0.9), 3.0), bank)
    before = np.array([bank.prior[bank.model.place(name)] for name in names])
    assert np.sqrt(P.diagonal()) == pytest.approx(before)
    assert np.linalg.eigvalsh(P / np.outer(before, before))[0] > 0.0


def spoiled(model: LearnedModel, what: str) -> LearnedModel:
    rows = [list(row) for row in model.covariance]
    if what == "variance":
        rows[3][3] = (1e-7 * abs(model.file[3])) ** 2
    if what == "correlation":
        rows[1][0] = 1.01 * np.sqrt(rows[0][0] * rows[1][1])
    if what == "indefinite":  # each pair of the three can be, all three together cannot
        for i, j, sign in ((1, 0, 1), (2, 0, 1), (2, 1, -1)):
            rows[i][j] = sign * 0.8 * np.sqrt(rows[i][i] * rows[j][j])
    value = tuple([100.0 * v if what == "value" and i == 2 else v for i, v in enumerate(model.value)])
    names = tuple([f"{n}_" if what == "names" else n for n in model.names])
    return model._replace(names=names, value=value, covariance=tuple(tuple(map(float, row)) for row in rows))


@pytest.mark.parametrize(
    ("what", "why"),
    [
        ("value", "N_r = .*: must be in"),
        ("variance", "N_dr: a 1 sigma .* less than any flight can leave"),
        ("correlation", "not positive definite"),
        ("indefinite", "not positive definite"),
        ("names", "'M_q_' is no coefficient"),
    ],
)
def test_what_no_filter_can_have_learned_is_refused(what: str, why: str) -> None:
    with pytest.raises(ParamError, match=why):
        prior(Restored(spoiled(known(), what), 0.15), ekf().bank)


def test_coefficients_that_only_one_of_the_two_filters_learns_are_left_as_they_are() -> None:
    model, filters = known(), ekf()
    fewer = LearnedModel(*[row[:4] for row in model])  # type: ignore[arg-type]
    filters.restore(*prior(Restored(fewer, 0.15), filters.bank))
    place = filters.model.place
    for name, share in (("M_q", 1.2), ("N_dr", 1.2), ("Y_v", 1.0), ("M_qdot", 1.0)):
        believed = filters.model.believed[place(name) - filters.model.first]
        assert filters.x[:, place(name)] == pytest.approx(share * believed)
    assert filters.age[0] == 0.0  # six of the ten are as unknown as ever: the start-up is needed


def test_every_filter_of_the_bank_begins_so_without_a_start_up() -> None:
    filters = ekf()
    names, value, P = prior(Restored(known(), 0.15), filters.bank)
    filters.restore(names, value, P)
    places = [filters.model.place(name) for name in names]
    for x, covariance in zip(filters.x, filters.P, strict=True):
        assert x[places] == pytest.approx(value)
        assert covariance[np.ix_(places, places)] == pytest.approx(P)
        others = np.setdiff1d(np.arange(len(x)), places)
        assert not covariance[np.ix_(places, others)].any()
    assert filters.age[0] == filters.iteration.startup_over
    assert not filters.iterated.any()  # to be confirmed anew
    assert filters.estimate().covariance[np.ix_(places, places)] == pytest.approx(P)


def test_an_autopilot_is_built_with_it_and_remembers_it() -> None:
    model = known()
    plain = {"passport": as_plain(model), "widening": 0.15}
    autopilot = app.build({**CONFIGURATION, "kept": {"passport": plain}})
    [m_q, *_] = autopilot.parts.estimator.learned_model().value
    assert m_q == pytest.approx(1.2 * VEHICLE.coefficients.M_q)
    fresh = app.build(CONFIGURATION)
    fresh.thaw(autopilot.freeze())
    assert fresh.parts.estimator.learned_model() == autopilot.parts.estimator.learned_model()
    assert fresh.parts.adoption.freeze() == autopilot.parts.adoption.freeze()
    assert fresh.parts.adoption.freeze().passport.model == model


def as_plain(model: LearnedModel) -> dict[str, Any]:
    from firmware_py.records.passport import to_plain

    return to_plain(model, {}, "", {"date": "", "utc_s": 0.0, "boot": "", "uptime_s": 0.0})
