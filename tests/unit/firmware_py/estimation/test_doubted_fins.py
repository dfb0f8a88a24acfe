"""A filter that is contradicted goes back to what it knew, and begins anew where that was wrong itself."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_py.adapters.installation import configs
from firmware_py.config_files import read_configuration
from firmware_py.config_files import vehicle as vehicle_of
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.doubted_fins import _FRUITLESS, DoubtedFins
from firmware_py.records.health import NO_DOUBTS, AxisDoubt
from tests.estimation.cases import VEHICLE

TAUGHT = 1.3
"""What the filter has learned, over what was believed."""


@pytest.fixture
def ekf() -> CoefficientEkf:
    """One that has learned something, and a pass has confirmed it."""
    ekf = CoefficientEkf(VEHICLE, CoefficientParams(iteration_times=(10.0,), boost_std=0.4))
    ekf.start((1.8, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.1,) * 9)
    ekf.x[:, ekf.model.first :] *= TAUGHT
    ekf.P[:, ekf.model.first :, ekf.model.first :] *= 0.01
    ekf.iterated[:], ekf.iteration.accepted = True, 1
    return ekf


def parameters(ekf: CoefficientEkf) -> np.ndarray:
    return ekf.x[:, ekf.model.first :] / np.array(ekf.model.believed)


def contradict(fins: DoubtedFins, ekf: CoefficientEkf, t: float) -> bool:
    ekf.bursts += 1
    rates = (0.0,) * len(VEHICLE.fins)
    return fins.update(t, [False] * len(rates), rates, NO_DOUBTS)


def test_it_keeps_what_it_knew_until_that_was_in_vain(ekf: CoefficientEkf) -> None:
    fins = DoubtedFins(ekf, VEHICLE)
    for k in range(_FRUITLESS):
        assert contradict(fins, ekf, 10.0 * (k + 1))
        assert parameters(ekf) == pytest.approx(TAUGHT)
        assert ekf.iterated.all()
    assert contradict(fins, ekf, 100.0)
    first = ekf.model.first
    assert parameters(ekf) == pytest.approx(1.0)
    assert not ekf.iterated.any()
    np.testing.assert_allclose(
        ekf.P[:, range(first, ekf.model.size), range(first, ekf.model.size)], [ekf.prior[first:] ** 2]
    )


def test_a_pass_that_took_over_meanwhile_counts_from_there(ekf: CoefficientEkf) -> None:
    fins = DoubtedFins(ekf, VEHICLE)
    for k in range(3 * _FRUITLESS):
        ekf.iteration.accepted += k % _FRUITLESS == 0
        contradict(fins, ekf, 10.0 * (k + 1))
    assert parameters(ekf) == pytest.approx(TAUGHT)


def test_it_goes_on_counting_where_it_was(ekf: CoefficientEkf) -> None:
    fins, again = DoubtedFins(ekf, VEHICLE), DoubtedFins(ekf, VEHICLE)
    for k in range(_FRUITLESS):
        contradict(fins, ekf, 10.0 * (k + 1))
    again.thaw(fins.freeze())
    contradict(again, ekf, 100.0)
    assert parameters(ekf) == pytest.approx(1.0)


@pytest.mark.parametrize("confirmed", [False, True])
def test_passes_begin_with_believed_coefficients_until_one_has_confirmed_others(
    ekf: CoefficientEkf, confirmed: bool
) -> None:
    ekf.iterated[:] = confirmed
    for begin in (ekf.boost, lambda: ekf.forget("MZ"), ekf.exchange_sensors, ekf.begin_history):
        begin()
        start = ekf.freeze().iteration.start[0][:, ekf.model.first :] / np.array(ekf.model.believed)
        assert start[:, : len(ekf.names)] == pytest.approx(TAUGHT if confirmed else 1.0)


@pytest.mark.parametrize("crossed", [False, True])
def test_weak_fins_that_act_on_both_axes_are_held_at_what_was_known_and_others_learned_anew(
    ekf: CoefficientEkf, crossed: bool
) -> None:
    """One of an X tail that is lost makes a moment that no coefficient says."""
    x_tail = read_configuration(configs() / "torpedo_x")
    fins = DoubtedFins(ekf, vehicle_of(x_tail) if crossed else VEHICLE)
    none, weak = (0.0,) * 4, (AxisDoubt(), AxisDoubt(0.0, True))
    for k in range(8):
        fins.update(float(k), [False] * 4, none, NO_DOUBTS)
    ekf.x[:, ekf.model.first :] *= 2.0  # since the fin was lost
    assert fins.update(8.0, [False] * 4, none, weak)
    assert fins.held == (crossed, crossed)
    assert all(fins.holds(name) == crossed for name in ekf.names)
    assert parameters(ekf) == pytest.approx(TAUGHT)
    place = ekf.model.first + ekf.names.index("N_dr")
    known = ekf.P[0, place, place] < 0.02 * ekf.prior[place] ** 2
    assert known == crossed
    assert not fins.update(9.0, [False] * 4, none, weak)
    assert fins.update(10.0, [False] * 4, none, NO_DOUBTS) == crossed  # they work again
    assert fins.held == (False, False)
