"""A sudden change of the fins makes coefficients uncertain at once, before the filter is lost; chance does not."""

from __future__ import annotations

import numpy as np
import pytest
from sternplane.sitl.busless_flight import SENSOR_STD, measure
from sternplane.study.setups import Setup, fly_prbs, flying, run_filter, starts

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.filter.boost import DRAG, HULL, LIFT, boost_covariance, by_fins
from firmware_py.estimation.filter.consistency import BURST_PAUSE, COUNT, SUM, WAIT, add_burst, bursts
from firmware_py.estimation.model.observer_model import ObserverModel

from .cases import VEHICLE

STILL = Setup(duration=60.0)
FIN_DRAG = {"nuisances": ("X_dsds", "X_drdr", "M_dsn", "Z_dsn"), "considered_std": 0.3}


def gyros(mean: float, seconds: float, seed: int = 0) -> np.ndarray:
    """The short window after so many seconds at 100 Hz; other sensors are wild and do not count."""
    burst, rng, nis = np.zeros(3), np.random.default_rng(seed), np.full(9, 50.0)
    for _ in range(round(100.0 * seconds)):
        nis[3:6] = mean * rng.chisquare(1, 3)
        add_burst(nis, 0.01, burst)
    return burst


def test_only_gyros_that_leave_what_chance_explains_are_a_burst() -> None:
    assert not any(bursts(gyros(1.0, 10.0, seed)) for seed in range(30))
    assert all(bursts(gyros(2.0, 3.0, seed)) for seed in range(30))
    assert not bursts(gyros(5.0, 0.1))
    assert not bursts(np.array([np.nan, 0.0, 0.0]))


def test_after_a_burst_the_window_is_left_alone_for_a_while() -> None:
    burst = gyros(3.0, 3.0)
    burst[WAIT] = BURST_PAUSE
    silent = np.full(9, np.nan)
    for _ in range(round(BURST_PAUSE / 0.01) - 1):
        burst[SUM], burst[COUNT] = 900.0, 300.0
        add_burst(silent, 0.01, burst)
        assert not bursts(burst)
    burst[SUM], burst[COUNT] = 900.0, 300.0
    add_burst(silent, 0.02, burst)
    assert bursts(burst)


def test_fins_are_told_by_name() -> None:
    assert [
        name for name in ("M_ds", "X_rdr", "X_dsdsn", "Z_db", "N_rdot", "M_q", "Y_vdot", "C_d0") if by_fins(name)
    ] == [
        "M_ds",
        "X_rdr",
        "X_dsdsn",
        "Z_db",
    ]


def test_what_the_fins_of_an_axis_make_shares_a_factor() -> None:
    """Planes and rudders have one each; what is considered only, or is no fin's and not asked for, is left alone."""
    names = ("M_ds", "Z_ds", "N_dr", "X_dsds", "M_q", "C_d0", "Z_w")
    model = ObserverModel(VEHICLE, names)
    learns = np.array([True] * 6 + [False])
    believed = np.array(model.believed)
    values = np.stack([believed, believed * [1.0, 1.2, 1.0, 1.0, 1.0, 1.0, 1.0]])
    sound, known = boost_covariance(model, ("M_ds", "N_dr", "M_q"), learns, 0.4, values) / np.outer(believed, believed)
    lift, drag = 1.0 + LIFT**2, 1.0 + DRAG**2
    np.testing.assert_allclose(
        np.sqrt(np.diag(sound)), [*(0.4 * np.sqrt([lift, lift, lift, drag])), 0.4 * HULL, 0.0, 0.0], rtol=1e-12
    )
    np.testing.assert_allclose(sound[0] / 0.16, [lift, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0], rtol=1e-12)
    assert known[0, 1] == pytest.approx(1.2 * known[0, 3]), "what is learned to be greater changes in proportion"


def test_halved_fins_are_known_within_ten_seconds_and_nothing_is_reset() -> None:
    flight = fly_prbs(STILL, 3)
    z = measure(flight, SENSOR_STD, STILL.rates, 3)
    told = flight.inputs.copy()
    half = len(told) // 2
    told[half:, :2] *= 2.0  # the filter hears of twice the angles: as if fins did half
    seen = {}
    for boost in (0.0, 0.3):
        ekf = CoefficientEkf(VEHICLE, flying(**FIN_DRAG, boost_std=boost))
        ekf.start(flight.x[0, :6], flight.x[0, 6:], SENSOR_STD)
        ekf.run(STILL.h, told[:half], z[:half], SENSOR_STD**2)
        before = ekf.estimate()
        ekf.run(STILL.h, told[half : half + 1000], z[half : half + 1000], SENSOR_STD**2)
        seen[boost] = (ekf.resets, ekf.estimate().values[[1, 3]] / before.values[[1, 3]])
    resets, effect = seen[0.3]
    assert resets == 0
    np.testing.assert_allclose(effect, 0.5, rtol=0.2)
    assert (np.abs(seen[0.0][1] - 0.5) > 0.2).any()


def test_a_healthy_flight_is_as_without_a_boost() -> None:
    for seed in range(3):
        flight = fly_prbs(STILL, seed)
        with_boost, without = (CoefficientEkf(VEHICLE, flying(turbulence=(0.0,), boost_std=b)) for b in (0.3, 0.0))
        for ekf in (with_boost, without):
            run_filter(STILL, flight, ekf, seed, starts(seed, 0.5))
        np.testing.assert_array_equal(with_boost.x, without.x)
