"""References keep to what the vehicle can do."""

from __future__ import annotations

import math

import pytest

from firmware_py.guidance.guidance_params import GuidanceParams
from firmware_py.guidance.reference_shaper import ReferenceShaper
from firmware_py.records.manoeuvrability import RESERVE, UNLIMITED, Manoeuvrability
from firmware_py.records.order import Setpoint

U, DT = 1.8, 0.05
SOUND = UNLIMITED._replace(turn=0.09, up=0.046, pitch_way=1.8, speed=0.48)
CRIPPLED = SOUND._replace(turn=0.025, turn_left=0.28, up=0.008, up_left=0.17, dive_left=0.17, speed=0.9)


def greatest(left: Manoeuvrability, wanted: Setpoint) -> tuple[float, float, float]:
    """Fastest turn, rad/s, and dive, m/s, on the way to a setpoint, and the speed there."""
    shaper, u_d = ReferenceShaper(GuidanceParams()), 0.0
    shaper.limit(left, 0.0)
    turn = dive = 0.0
    for _ in range(round(120.0 / DT)):
        shaped = shaper.update(wanted, u_d, U, DT)
        turn, dive, u_d = max(turn, abs(shaped.psi_d_dot)), max(dive, shaped.z_d_dot), shaped.u_d
    return turn, dive, u_d


def test_a_sound_vehicle_turns_and_dives_as_configured() -> None:
    params = GuidanceParams()
    turn, dive, u_d = greatest(SOUND, Setpoint(30.0, 3.0, 1.2))
    assert turn == pytest.approx(params.turn_rate_max, rel=1e-3)
    assert dive == pytest.approx(params.climb_max, rel=1e-3)
    assert u_d == pytest.approx(1.2)


def test_a_damaged_one_turns_wider_dives_flatter_and_keeps_its_speed_up() -> None:
    turn, dive, u_d = greatest(CRIPPLED, Setpoint(30.0, 3.0, 0.6))
    assert turn == pytest.approx(RESERVE * CRIPPLED.turn * U, rel=1e-3)
    assert dive == pytest.approx(U * math.sin(CRIPPLED.slope), rel=1e-3)
    assert CRIPPLED.pull_up(CRIPPLED.slope) == pytest.approx(3.0)
    assert u_d == pytest.approx(CRIPPLED.speed)


def test_who_is_to_stop_stops() -> None:
    assert greatest(CRIPPLED, Setpoint(5.0, 0.0, 0.0))[2] == 0.0


def test_circles_are_as_wide_as_the_vehicle_turns() -> None:
    shaper = ReferenceShaper(GuidanceParams())
    for left, radius in (
        (SOUND, 20.0),
        (CRIPPLED, 1.0 / (RESERVE * CRIPPLED.turn)),
        (CRIPPLED._replace(turn=0.0), 1e3),
    ):
        shaper.limit(left, 0.0)
        assert shaper.turning.turn_radius == pytest.approx(radius)
        assert shaper.turning.tightest(U) >= radius
