"""Process noise follows length, speed and fins of the vehicle."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path

import pytest

from firmware_py import params
from firmware_py.estimation.coefficient_params import CoefficientParams
from firmware_py.estimation.filter.bank_arrays import BankArrays
from firmware_py.estimation.filter.vehicle_scales import vehicle_scales
from firmware_py.estimation.model.state import MOTIONS
from firmware_py.vehicle.vehicle import Vehicle
from tests.estimation.cases import VEHICLE

REMUS_FILE = Path(__file__).resolve().parents[4] / "configs" / "remus100" / "vehicle.toml"
REMUS = params.load(Vehicle, tomllib.loads(REMUS_FILE.read_text()), "vehicle.toml")


def scaled(length: float, speed: float) -> Vehicle:
    """A vehicle of the same shape and density, by Froude: each number of its file by its powers of length."""
    hull, body, propeller = VEHICLE.hull, VEHICLE.body, VEHICLE.propeller
    by = {
        "mass": 3,
        "weight": 3,
        "buoyancy": 3,
        "I_x": 5,
        "I_y": 5,
        "I_z": 5,
        "I_xy": 5,
        "I_yz": 5,
        "I_xz": 5,
        "z_G": 1,
    }
    return dataclasses.replace(
        VEHICLE,
        hull=dataclasses.replace(
            hull, length=hull.length * length, height=hull.height * length, width=hull.width * length
        ),
        body=dataclasses.replace(body, **{name: getattr(body, name) * length**n for name, n in by.items()}),
        propeller=dataclasses.replace(propeller, u_trim=propeller.u_trim * speed),
    )


@pytest.mark.parametrize(("length", "speed"), [(0.25, 1.0), (1.0, 1.5), (0.5, 0.8), (2.0, 2.0)])
def test_a_vehicle_of_the_same_shape_has_the_scales_of_its_length_and_speed(length: float, speed: float) -> None:
    one, other = vehicle_scales(VEHICLE), vehicle_scales(scaled(length, speed))
    assert other.speed_noise == pytest.approx(one.speed_noise * speed**1.5 / length**0.5)
    assert other.rate_noise == pytest.approx(one.rate_noise * (speed / length) ** 1.5)
    assert other.eddy_speed_noise == pytest.approx(one.eddy_speed_noise * (speed / length) ** 0.5)
    assert other.eddy_rate_noise == pytest.approx(one.eddy_rate_noise * speed**0.5 / length**1.5)
    sway, heave, pitch, yaw = (new / old for new, old in zip(other.fins, one.fins, strict=True))
    assert (sway, heave) == pytest.approx((speed**2 / length,) * 2)
    assert (pitch, yaw) == pytest.approx((speed**2 / length**2,) * 2)


def test_a_small_hull_is_told_six_times_the_noise_of_its_rates() -> None:
    small, large = vehicle_scales(REMUS), vehicle_scales(VEHICLE)
    assert small.rate_noise / large.rate_noise == pytest.approx(6.1, abs=0.1)
    assert small.speed_noise / large.speed_noise == pytest.approx(1.5, abs=0.1)


def test_rounded_fins_make_noise_in_what_fins_drive_and_in_nothing_else() -> None:
    step = math.radians(0.014)
    exact, rounded = (
        BankArrays(REMUS, CoefficientParams(fin_resolution=resolution)).tuning.Q_final for resolution in (0.0, step)
    )
    more = {name: rounded[i] - exact[i] for i, name in enumerate(MOTIONS)}
    assert [name for name, noise in more.items() if noise > 0.0] == ["v", "w", "q", "r"]
    assert more["q"] == pytest.approx((vehicle_scales(REMUS).fins[2] * step) ** 2 / 12.0)
    twice = BankArrays(REMUS, CoefficientParams(fin_resolution=2.0 * step)).tuning.Q_final
    assert twice[5] - exact[5] == pytest.approx(4.0 * more["r"])
