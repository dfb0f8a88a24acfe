from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_py import marine

angles = st.floats(-math.pi, math.pi, exclude_max=True)
pitches = st.floats(-1.5, 1.5)


@given(st.floats(-1e6, 1e6))
def test_wrap_points_the_same_way(angle: float) -> None:
    wrapped = marine.wrap(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(angles, pitches, angles)
def test_quaternion_and_euler_are_inverse(phi: float, theta: float, psi: float) -> None:
    back = marine.euler_from_quaternion(*marine.quaternion_from_euler(phi, theta, psi))
    assert marine.wrap(back[0] - phi) == pytest.approx(0.0, abs=1e-9)
    assert back[1] == pytest.approx(theta, abs=1e-7)
    assert marine.wrap(back[2] - psi) == pytest.approx(0.0, abs=1e-9)


@given(angles, pitches, angles)
def test_quaternion_rotates_as_the_euler_matrix_does(phi: float, theta: float, psi: float) -> None:
    x, y, z, w = marine.quaternion_from_euler(phi, theta, psi)
    # q v q* for v = (1, 0, 0): the first column of the rotation matrix
    column = (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y))
    assert marine.body_to_ned(phi, theta, psi, 1.0, 0.0, 0.0) == pytest.approx(column, abs=1e-12)


def test_bow_up_and_ahead_climbs_and_a_heading_of_90_degrees_is_east() -> None:
    assert marine.body_to_ned(0.0, 0.1, 0.0, 1.0, 0.0, 0.0)[2] < 0.0
    assert marine.body_to_ned(0.0, 0.0, math.pi / 2, 1.0, 0.0, 0.0) == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)


@given(angles, pitches, angles, st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1))
def test_euler_rates_are_the_derivative_of_the_attitude(
    phi: float, theta: float, psi: float, p: float, q: float, r: float
) -> None:
    # Rotate a little by the body rates, as a quaternion product, and compare with the Euler rates.
    dt = 1e-6
    x, y, z, w = marine.quaternion_from_euler(phi, theta, psi)
    dx, dy, dz = 0.5 * dt * p, 0.5 * dt * q, 0.5 * dt * r
    turned = (x + w * dx + y * dz - z * dy, y + w * dy + z * dx - x * dz, z + w * dz + x * dy - y * dx,
              w - x * dx - y * dy - z * dz)  # fmt: skip
    after = marine.euler_from_quaternion(*turned)
    rates = marine.euler_rates(phi, theta, p, q, r)
    for angle, before, rate in zip(after, (phi, theta, psi), rates, strict=True):
        assert marine.wrap(angle - before) / dt == pytest.approx(rate, abs=2e-3 / math.cos(theta) ** 2)


def test_euler_rates_stay_finite_at_the_vertical() -> None:
    assert all(abs(rate) < 1e3 for rate in marine.euler_rates(0.3, math.pi / 2, 1.0, 1.0, 1.0))


def test_a_quaternion_without_length_or_not_finite_gives_nan() -> None:
    assert all(math.isnan(a) for a in marine.euler_from_quaternion(0.0, 0.0, 0.0, 0.0))
    assert all(math.isnan(a) for a in marine.euler_from_quaternion(math.nan, 0.0, 0.0, 1.0))


@given(st.floats(-1.0, 1.0), st.floats(-3.1, 3.1), st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))
def test_local_and_geodetic_are_inverse(latitude: float, longitude: float, x: float, y: float) -> None:
    origin = marine.Origin(latitude, longitude)
    back = marine.geodetic_to_local(origin, *marine.local_to_geodetic(origin, x, y))
    assert back == pytest.approx((x, y), abs=1e-5)


def test_one_minute_of_latitude_is_a_nautical_mile_and_longitude_shrinks_with_the_cosine() -> None:
    minute = math.radians(1.0 / 60.0)
    x, _ = marine.geodetic_to_local(marine.Origin(math.radians(45.0), 0.0), math.radians(45.0) + minute, 0.0)
    assert x == pytest.approx(1852.0, rel=1e-3)
    _, y = marine.geodetic_to_local(
        marine.Origin(math.radians(60.0), math.pi - 0.5 * minute), math.radians(60.0), -math.pi + 0.5 * minute
    )
    assert y == pytest.approx(0.5 * 1855.3, rel=4e-3)


def test_ten_metres_of_fresh_water_are_98_kilopascals_and_the_air_adds_nothing() -> None:
    assert marine.pressure_of_depth(10.0, 101325.0, 1000.0) - 101325.0 == pytest.approx(98066.5)
    assert marine.pressure_of_depth(-3.0, 101325.0, 1000.0) == 101325.0
    assert marine.depth_of_pressure(101325.0 + 98066.5, 101325.0, 1000.0) == pytest.approx(10.0)


def test_clip_returns_nan_for_nan() -> None:
    assert math.isnan(marine.clip(math.nan, -1.0, 1.0))
    assert marine.clip(2.0, -1.0, 1.0) == 1.0
    assert marine.clip(-2.0, -1.0, 1.0) == -1.0


MASSES = st.lists(
    st.tuples(st.floats(0.1, 10.0), *(st.floats(-3.0, 3.0),) * 3),
    min_size=4,
    max_size=8,
)


@given(MASSES)
def test_the_inertia_of_any_point_masses_is_accepted(masses: list[tuple[float, float, float, float]]) -> None:
    m, x, y, z = (np.array(column) for column in zip(*masses, strict=True))
    second = np.array([[np.sum(m * a * b) for a in (x, y, z)] for b in (x, y, z)])
    assume(np.linalg.eigvalsh(second)[0] > 1e-6 * np.trace(second))  # not all of them in one plane
    xx, yy, zz = np.diag(second)
    assert marine.is_inertia_tensor(yy + zz, xx + zz, xx + yy, second[0, 1], second[1, 2], second[0, 2])


@pytest.mark.parametrize(
    "inertia",
    [
        (2038.0, 13587.0, 1.0, 0.0, 0.0, 0.0),  # positive definite, but against the triangle inequality
        (2038.0, 13587.0, 15626.0, 0.0, 0.0, 0.0),
        (2038.0, 13587.0, 13587.0, 9000.0, 0.0, 9000.0),
        (-1.0, 1.0, 1.0, 0.0, 0.0, 0.0),
        (math.nan, 1.0, 1.0, 0.0, 0.0, 0.0),
    ],
)
def test_an_inertia_that_no_body_can_have_is_rejected(inertia: tuple[float, ...]) -> None:
    assert not marine.is_inertia_tensor(*inertia)
