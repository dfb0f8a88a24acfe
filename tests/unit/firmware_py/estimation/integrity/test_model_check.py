"""Heading and DVL against the hull's model: what drifts with its gyro, and what creeps, is told."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.model_check import ModelCheck
from firmware_py.estimation.integrity.motion_model import MotionModel
from firmware_py.estimation.integrity.velocity_check import VelocityCheck
from firmware_py.records.sensing import Dvl
from firmware_py.vehicle.vehicle import Vehicle

from .voyage import AT_U, DEG, VEHICLE

N, U = 492.0 / 60.0, 1.8
STEERING = ("Y_r", "Y_v", "Y_dr", "N_r", "N_v", "N_dr")


def weaving(t: float) -> float:
    return 4.0 * DEG * (1.0 if t % 50.0 < 25.0 else -1.0) if t % 25.0 < 6.0 else 0.0


def scaled(by: float, *names: str) -> Vehicle:
    c = VEHICLE.coefficients
    return replace(VEHICLE, coefficients=replace(c, **{name: by * getattr(c, name) for name in names}))


def swim(
    seconds: float,
    *,
    vehicle: Vehicle = VEHICLE,
    drift: Callable[[float], float] = lambda _: 0.0,
    creep: Callable[[float], float] = lambda _: 0.0,
    current: tuple[float, float] = (0.0, 0.0),
    rudder: Callable[[float], float] = weaving,
    check: ModelCheck | None = None,
    knows: bool = True,
) -> tuple[ModelCheck, float, float]:
    """Swim by the file's hull, watched by the model of `vehicle`; return when heading and DVL were named, s."""
    rng = np.random.default_rng(3)
    hull, psi, water = MotionModel(VEHICLE), 0.0, np.zeros(2)
    check = check or ModelCheck(IntegrityParams(), vehicle)
    hull.memory.u = U
    if knows:
        check.hear_speed(AT_U, 0.0, 0.0)
    heading = dvl = math.inf
    for k in range(round(seconds * 10)):
        t = 0.1 * k
        fins = [0.0, 0.0, rudder(t), rudder(t)]
        hull.step(0.1, N, 0.0, *hull.deflections(fins))
        psi += 0.1 * hull.memory.r
        water += -water * 0.01 + 0.1 * math.sqrt(0.02) * rng.standard_normal(2)
        check.hear_rate(hull.memory.r + drift(t) + 0.1 * DEG * rng.standard_normal())
        if k % 2 == 0:
            s, c = math.sin(psi), math.cos(psi)
            u = hull.memory.u + current[0] * c + current[1] * s + creep(t) + water[0]
            v = hull.memory.v - current[0] * s + current[1] * c + water[1]
            check.hear_ping(Dvl(u, v, 0.0, 0.01, 20.0), t, psi, True)
        check.step(0.1, N, 0.0, fins, True, True, True)
        heading = min(heading, t) if check.heading_drifts else heading
        dvl = min(dvl, t) if check.dvl_creeps else dvl
    return check, heading, dvl


@pytest.mark.parametrize(
    "vehicle",
    [VEHICLE, *(scaled(by, *names) for by in (0.5, 1.5) for names in (STEERING, ("Y_dr", "N_dr"), ("N_r",)))],
    ids=["exact", "all 0.5", "rudder 0.5", "N_r 0.5", "all 1.5", "rudder 1.5", "N_r 1.5"],
)
def test_a_heading_that_drifts_with_its_gyro_is_told_and_a_vehicle_file_that_is_half_wrong_is_not(
    vehicle: Vehicle,
) -> None:
    _, sound, dvl = swim(300.0, vehicle=vehicle)
    assert (sound, dvl) == (math.inf, math.inf)
    _, named, _ = swim(300.0, vehicle=vehicle, drift=lambda t: 1.0 * DEG if t > 150.0 else 0.0)
    assert 150.0 < named < 250.0


def test_a_rudder_that_holds_a_drift_is_no_proof_as_long_as_it_rests() -> None:
    """Without a turn a heading that drifts, and a rudder that has no effect, look the same."""
    _, named, _ = swim(300.0, rudder=lambda _: 2.0 * DEG, drift=lambda _: 0.4 * DEG)
    assert named == math.inf


@pytest.mark.parametrize("rate", [0.03, -0.03, 0.01])
def test_a_dvl_that_creeps_is_told_when_no_current_explains_it(rate: float) -> None:
    _, _, named = swim(350.0, creep=lambda t: rate * max(0.0, t - 120.0))
    bound = (1.2 if rate > 0.0 else 1.7) / abs(rate)  # where u is less than the model's, thrust may be lost
    assert 120.0 + bound < named < 120.0 + 1.35 * bound + 40.0


@pytest.mark.parametrize("current", [(1.0, 0.0), (-0.6, 0.8)])
def test_a_current_is_no_creep_on_any_heading(current: tuple[float, float]) -> None:
    _, heading, dvl = swim(300.0, current=current, rudder=lambda t: 3.0 * DEG if t % 100.0 < 30.0 else 0.0)
    assert (heading, dvl) == (math.inf, math.inf)


@pytest.mark.parametrize("current", [(1.2, 0.0), (-1.2, 0.0)])
def test_a_speed_over_ground_in_a_strong_current_accuses_nobody_before_it_is_forgotten(
    current: tuple[float, float],
) -> None:
    check, heading, dvl = swim(300.0, current=current, knows=False, rudder=lambda t: 8.0 * DEG if t % 60 < 30 else 0.0)
    assert (heading, dvl) == (math.inf, math.inf)
    assert check.velocity is not None
    known = check.velocity.current
    assert math.hypot(known.north - current[0], known.east - current[1]) < 3.0 * known.std


def test_the_model_tells_no_speed_as_long_as_it_began_with_one_that_was_not_known() -> None:
    check, _, _ = swim(20.0, knows=False)
    assert check.velocity is None
    check.hear_speed(AT_U, 0.0, 0.0)
    assert check.velocity is not None


def test_memory_taken_over_goes_on_as_if_nothing_had_happened() -> None:
    check, _, _ = swim(50.0)
    other = ModelCheck(IntegrityParams(), VEHICLE)
    other.thaw(check.freeze())
    for one in (check, other):
        for _ in range(20):
            one.hear_rate(0.01)
            one.step(0.1, N, 0.0, [0.0, 0.0, 0.1, 0.1], True, True, True)
    assert check.freeze() == other.freeze()


@pytest.mark.parametrize("zero", [0.0, 0.3])
@pytest.mark.parametrize(("gyro", "heading"), [(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, 0.0)])
def test_of_heading_and_gyro_the_one_is_believed_that_turned_as_the_rudder(
    gyro: float, heading: float, zero: float
) -> None:
    """`gyro` and `heading`: how fast each drifts, deg/s; `zero`: how far the rudder is off its own, deg."""
    bias, check = gyro * DEG, ModelCheck(IntegrityParams(), VEHICLE)
    swim(100.0, check=check, rudder=lambda t: weaving(t) + zero * DEG)
    check.part()
    swim(40.0, check=check, drift=lambda _: bias)
    assert check.refutes_gyro(40.0 * (heading * DEG - bias)) is (gyro != 0.0)


def test_a_dvl_that_is_not_believed_makes_no_current() -> None:
    check, _, _ = swim(50.0)
    known = check.velocity
    assert known is not None
    for k in range(200):
        check.hear_ping(Dvl(0.3, 0.0, 0.0, 0.01, 20.0), 50.0 + 0.2 * k, 0.0, False)
    assert check.velocity == known._replace(current=known.current._replace(t=50.0 + 0.2 * 199))


def test_a_hull_at_the_surface_and_soon_after_may_be_off_by_what_bow_and_rudder_lack_there() -> None:
    check, _, _ = swim(60.0)
    assert check.velocity is not None
    assert check.velocity[-3:] == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
    for k in range(400):
        check.step(0.1, N, 0.0, [0.0] * 4, True, True, k >= 200)
        near = k < 200 + 148  # 15 s after it dived
        if abs(k - 348) > 3:
            assert check.velocity[-3:] == pytest.approx((0.0, 0.45, 0.45) if near else (0.0,) * 3, abs=0.01)


@pytest.mark.parametrize("angle", [23.0, -15.0])
def test_what_fins_have_braked_is_what_the_hull_would_be_faster_by_without_their_drag(angle: float) -> None:
    bare = replace(VEHICLE, coefficients=replace(VEHICLE.coefficients, X_dsds=0.0))
    hulls = MotionModel(VEHICLE), MotionModel(bare)
    for hull in hulls:
        hull.memory.u = U
    for k in range(900):
        for hull in hulls:
            hull.step(0.1, N, 0.0, angle * DEG if k < 300 else 0.0, 0.0)
        if k in (100, 299, 600, 899):
            with_fins, without = hulls[0].memory, hulls[1].memory
            assert with_fins.braked == pytest.approx(without.u - with_fins.u, rel=0.25, abs=0.001)


def test_without_pings_the_likely_speed_is_as_slow_in_turns_as_the_hull_is() -> None:
    hull, check, plain = MotionModel(VEHICLE), *[VelocityCheck(IntegrityParams(), VEHICLE, 0.003) for _ in range(2)]
    hull.memory.u = check.memory.likely = plain.memory.likely = U
    for k in range(1200):
        hull.step(0.1, N, 0.0, 0.0, math.copysign(20.0, math.sin(0.02 * k)) * DEG)
        check.step(0.1, N, 0.0, False, hull.memory.brakes)
        plain.step(0.1, N, 0.0, False, 0.0)
    assert check.memory.likely == pytest.approx(hull.memory.u, abs=0.02)
    assert plain.memory.likely > hull.memory.u + 0.2


def test_what_was_disarmed_under_way_has_way_until_drag_has_taken_it() -> None:
    """At rest at once, and driven again, it accused a sound DVL of a step."""
    check, hull = swim(60.0)[0], MotionModel(VEHICLE)
    hull.memory.u = check.speed
    for _ in range(600):
        check.rest()
        check.step(0.1, 0.0, 0.0, [0.0] * 4, steered=False, driven=False, deep=False)
        hull.step(0.1, 0.0, 0.0, 0.0, 0.0)
    assert check.speed == pytest.approx(hull.memory.u, abs=0.01)
    assert 0.5 < check.speed < 1.2
    for _ in range(36_000):
        check.rest()
        check.step(0.1, 0.0, 0.0, [0.0] * 4, steered=False, driven=False, deep=False)
    assert check.speed < 0.06
    fresh = ModelCheck(IntegrityParams(), VEHICLE)
    fresh.rest()
    assert (fresh.speed, fresh.memory.unknown) == (0.0, 0.0)
