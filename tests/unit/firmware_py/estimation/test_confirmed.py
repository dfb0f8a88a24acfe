"""A pass confirms what is learned; what is made uncertain after it is to be confirmed again."""

from __future__ import annotations

import numpy as np

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.coefficient_params import TEN, CoefficientParams
from firmware_py.estimation.iteration.acceptance import Verdict
from firmware_py.params import load
from firmware_py.vehicle.vehicle import Vehicle

PLANES = {"M_ds", "Z_ds"}


def confirmed() -> CoefficientEkf:
    """Return a filter of which a pass has confirmed everything."""
    file = configs() / "npsauv2" / "vehicle.toml"
    vehicle = load(Vehicle, config_files.read_table(Vehicle, file, {}), "vehicle.toml")
    ekf = CoefficientEkf(vehicle, CoefficientParams(iteration_times=(10.0,), boost_std=0.4))
    ekf.start((1.8, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.1,) * 9)
    ekf.confirmed.heed(Verdict.ACCEPTED, lambda count: np.ones(count, dtype=np.bool_))
    assert known(ekf) == set(TEN)
    return ekf


def known(ekf: CoefficientEkf) -> set[str]:
    """Return which coefficients are confirmed."""
    return {name for name, holds in zip(TEN, ekf.confirmed.holds.tolist(), strict=True) if holds}


def test_what_a_boost_made_uncertain_is_confirmed_by_the_next_pass_that_lets_it_learn() -> None:
    """Of fins that no boost makes uncertain nothing changes."""
    ekf = confirmed()
    ekf.boost(("ds",))
    assert known(ekf) == PLANES
    assert ekf.iterated.all()  # passes go on from what is known
    ekf.confirmed.heed(Verdict.ACCEPTED, lambda _: np.array([name[0] == "N" for name in TEN]))
    assert known(ekf) == PLANES | {"N_r", "N_dr", "N_v"}
    ekf.confirmed.heed(Verdict.REJECTED, lambda count: np.ones(count, dtype=np.bool_))
    assert known(ekf) == set()


def test_what_an_axis_was_known_by_is_confirmed_no_longer_once_that_is_forgotten() -> None:
    ekf = confirmed()
    ekf.forget("NY")
    assert known(ekf) == {name for name in TEN if name[0] in "MZ"}


def test_it_goes_on_from_a_memory() -> None:
    ekf, other = confirmed(), confirmed()
    ekf.boost(("dr",))
    other.thaw(ekf.freeze())
    assert known(other) == known(ekf) == {"N_dr", "Y_dr"}
    ekf.begin_anew()
    assert known(ekf) == set()
