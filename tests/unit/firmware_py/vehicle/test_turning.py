"""What turns the vehicle: the axes against the coefficients they come from, and the filter against its covariance."""

from __future__ import annotations

import numpy as np
import pytest
from sternplane.study.setups import vehicle

from firmware_py.vehicle.linear_models import diving_coefficients, diving_model, steering_model
from firmware_py.vehicle.turning import GYRO_STD, damped_share, follow, pitch_axis, stationary_gains, yaw_axis

VEHICLE = vehicle()


def test_the_axes_turn_as_the_coefficients_say() -> None:
    pitch, yaw = pitch_axis(VEHICLE), yaw_axis(VEHICLE)
    # 0.5 rho L^3 M_ds / (I_y - 0.5 rho L^5 M_qdot)
    assert pitch.control == pytest.approx(-0.0622, rel=1e-2)
    assert pitch.crosswise == pytest.approx(0.1515, rel=1e-2)
    assert pitch.damping < 0.0 > yaw.damping
    assert yaw.control < 0.0


def test_other_coefficients_of_the_planes_leave_what_heave_does() -> None:
    file = diving_coefficients(VEHICLE)
    other = pitch_axis(VEHICLE, file._replace(M_ds=0.5 * file.M_ds))
    assert other.control == pytest.approx(0.5 * pitch_axis(VEHICLE).control)
    assert other.crosswise == pytest.approx(pitch_axis(VEHICLE).crosswise)


@pytest.mark.parametrize("u", [0.9, 2.4])
def test_an_axis_grows_with_speed_as_the_linear_models_do(u: float) -> None:
    pitch, yaw = pitch_axis(VEHICLE), yaw_axis(VEHICLE)
    diving, steering = diving_model(VEHICLE, u), steering_model(VEHICLE, u)
    assert u * pitch.damping == pytest.approx(diving.A[0][0])
    assert u * u * pitch.control == pytest.approx(diving.b[0])
    assert u * yaw.crosswise == pytest.approx(steering.A[1][0])
    assert (u * yaw.sway[0], u * yaw.sway[1], u * u * yaw.sway[2]) == pytest.approx(
        (steering.A[0][0], steering.A[0][1], steering.b[0])
    )


def test_the_filter_that_follows_a_turn_is_the_best_one() -> None:
    """No other gains leave innovations that are smaller, of a rate that a random walk drives."""
    walk, dt = 0.01, 0.04
    random = np.random.default_rng(1000)
    disturbance = np.cumsum(walk * np.sqrt(dt) * random.standard_normal(100_000))
    rates = np.cumsum(dt * disturbance) + GYRO_STD * np.sqrt(0.01 / dt) * random.standard_normal(100_000)

    def innovation(gain: float, gain_d: float) -> float:
        rate = found = total = 0.0
        for measured in rates.tolist():
            rate += dt * found
            e = measured - rate
            rate, found, total = rate + gain * e, found + gain_d * e, total + e * e
        return total

    gain, gain_d = stationary_gains(walk, dt)
    best = innovation(gain, gain_d)
    assert all(best < innovation(a * gain, b * gain_d) for a, b in ((0.8, 1.0), (1.2, 1.0), (1.0, 0.7), (1.0, 1.4)))


@pytest.mark.parametrize("damping", [-8.0, -0.5, 0.0])
def test_with_the_damped_share_a_prediction_is_exact_for_a_moment_that_is_held(damping: float) -> None:
    rate, moment, dt, parts = 0.02, 0.3, 0.04, 10000
    exact = rate
    for _ in range(parts):
        exact += dt / parts * (damping * exact + moment)
    share = damped_share(damping, dt)
    _, (predicted, _) = follow((rate, 0.0), (0.0, 0.0), 0.0, share * damping, share * moment, dt)
    assert predicted == pytest.approx(exact, rel=1e-4)
