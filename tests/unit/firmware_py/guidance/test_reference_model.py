from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.guidance.reference_model import ReferenceModel, Shape, Shaped

DT = 0.01


def walk(model: ReferenceModel, target: float, rate: float, omega: float, steps: int) -> list[Shaped]:
    return [model.update(target, rate, omega, DT) for _ in range(steps)]


def test_three_equal_lags_answer_a_step_as_the_textbook_says() -> None:
    model, omega = ReferenceModel(Shape.SMOOTH), 0.7
    way = [shaped.d for shaped in walk(model, 1.0, math.inf, omega, 1500)]
    t = omega * DT * np.arange(1, 1501)
    assert way == pytest.approx(1.0 - np.exp(-t) * (1.0 + t + t * t / 2.0), abs=1e-12)


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(0.05, 2.0), st.floats(0.1, 2.0))
def test_it_never_overshoots_and_keeps_its_rate_and_acceleration(
    start: float, target: float, rate: float, omega: float
) -> None:
    model = ReferenceModel(Shape.SMOOTH)
    model.reset(start)
    way = walk(model, target, rate, omega, 600)
    low, high = min(start, target) - 1e-9, max(start, target) + 1e-9
    sign = math.copysign(1.0, target - start)
    for shaped in way:
        assert low <= shaped.d <= high
        assert -1e-9 <= sign * shaped.d_dot <= rate + 1e-9
        assert abs(shaped.d_ddot) <= 4.0 * math.exp(-2.0) * omega * rate + 1e-9


@given(st.lists(st.floats(-5, 5), min_size=2, max_size=6), st.floats(0.05, 1.0), st.floats(0.2, 2.0))
def test_acceleration_is_bounded_for_any_command(targets: list[float], rate: float, omega: float) -> None:
    model = ReferenceModel(Shape.SMOOTH)
    for target in targets:
        for shaped in walk(model, target, rate, omega, 150):
            assert abs(shaped.d_dot) <= rate + 1e-9
            assert abs(shaped.d_ddot) <= 4.0 * math.exp(-2.0) * omega * rate + 1e-9


def test_derivatives_are_those_of_the_reference() -> None:
    way = np.array(walk(ReferenceModel(Shape.SMOOTH), 3.0, 0.4, 0.8, 1500))
    for order in range(3):
        slope = (way[2:, order] - way[:-2, order]) / (2.0 * DT)
        jumps = np.abs(np.gradient(way[:, 3], DT)[1:-1]) > 1.0  # the third derivative jumps with the command's rate
        assert np.abs(slope - way[1:-1, order + 1])[~jumps].max() < 2e-3


@given(st.floats(-math.pi, math.pi), st.floats(-10, 10))
def test_an_angle_goes_the_short_way_round(start: float, target: float) -> None:
    model = ReferenceModel(Shape.SMOOTH, angle=True)
    start = model.reset(start).d
    way = walk(model, target, 0.5, 1.0, 2000)
    assert all(-math.pi <= shaped.d < math.pi for shaped in way)
    turned = sum(shaped.d_dot for shaped in way) * DT
    short = (target - start + math.pi) % math.tau - math.pi
    assert turned == pytest.approx(short, abs=0.02)
    assert math.cos(way[-1].d - target) == pytest.approx(1.0, abs=1e-6)


def test_it_stands_still_where_nothing_may_move() -> None:
    model = ReferenceModel(Shape.SMOOTH)
    model.reset(2.0)
    assert walk(model, 9.0, 0.0, 0.0, 3)[-1] == Shaped(2.0, 0.0, 0.0, 0.0)
    walk(model, 9.0, 1.0, 1.0, 300)
    frozen = model.freeze()
    assert walk(model, 9.0, 0.0, 0.0, 3)[-1].d_dot == 0.0
    assert model.freeze() == pytest.approx(frozen)


def test_step_shape_passes_commands_on() -> None:
    model = ReferenceModel(Shape.STEP)
    assert model.update(5.0, 0.1, 0.1, DT) == Shaped(5.0, 0.0, 0.0, 0.0)
    assert ReferenceModel(Shape.STEP, angle=True).update(4.0, 0.1, 0.1, DT).d == pytest.approx(4.0 - math.tau)


def test_thawed_model_goes_on() -> None:
    model, other = ReferenceModel(Shape.SMOOTH), ReferenceModel(Shape.SMOOTH)
    walk(model, 3.0, 0.3, 1.0, 77)
    other.thaw(model.freeze())
    assert walk(model, 1.0, 0.3, 1.0, 50) == walk(other, 1.0, 0.3, 1.0, 50)
