"""Turning circle and zigzag, against vehicles whose circles and overshoots are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sternplane.logs.reading import Piece
from sternplane.logs.standard_manoeuvres import StandardManoeuvres, TurningCircleResult, ZigzagResult

from firmware_py.records.order import Mode

T = np.arange(0.0, 150.0, 0.01)
PIECE = 4000
"""Cycles at a time, as from a log."""
Columns = dict[str, np.ndarray]


def shown(columns: Columns, truth: Columns) -> StandardManoeuvres:
    """Show a run in pieces; what the truth leaves out stays 0."""
    found, pose = StandardManoeuvres(), {"eta.x": 0.0 * T, "eta.y": 0.0 * T, **truth}
    for begin in range(0, len(T), PIECE):
        cut = slice(begin, begin + PIECE)
        found.add(Piece(begin, *({name: column[cut] for name, column in side.items()} for side in (columns, pose))))
    return found


def circle(columns: Columns, truth: Columns) -> TurningCircleResult | None:
    return shown(columns, truth).circle()


def zigzag(columns: Columns, truth: Columns) -> ZigzagResult | None:
    return shown(columns, truth).zigzag()


def cycles(rudder: np.ndarray, mode: Mode = Mode.MANUAL) -> dict[str, np.ndarray]:
    return {"t": T, "mode.mode": np.full(len(T), int(mode)), "demand.delta_r": rudder}


def turning(rate: float, diameter: float, drift: tuple[float, float] = (0.0, 0.0)) -> dict[str, np.ndarray]:
    """Straight for 20 s, then into the circle: the rate comes with a time constant of 3 s."""
    psi = rate * np.where(T > 20.0, T - 20.0 - 3.0 * (1.0 - np.exp(-(T - 20.0) / 3.0)), 0.0)
    speed = abs(rate) * diameter / 2.0
    x, y = (np.cumsum(speed * f(psi)) * 0.01 + c * T for f, c in zip((np.cos, np.sin), drift, strict=True))
    return {"eta.x": x, "eta.y": y, "eta.psi": np.angle(np.exp(1j * psi))}


@pytest.mark.parametrize("rate", [0.08, -0.08])
@pytest.mark.parametrize("drift", [(0.0, 0.0), (0.3, -0.2)])
def test_a_circle_is_measured_without_the_current(rate: float, drift: tuple[float, float]) -> None:
    found = circle(cycles(np.where(T >= 20.0, -0.35, 0.0)), turning(rate, 32.0, drift))
    assert found is not None
    assert found.diameter == pytest.approx(32.0, rel=2e-3)
    assert found.rate == pytest.approx(rate, rel=1e-3)


def test_noise_of_the_position_does_not_widen_the_circle() -> None:
    track = turning(0.08, 32.0)
    track["eta.x"] = track["eta.x"] + np.random.default_rng(1).normal(0.0, 0.2, len(T))
    found = circle(cycles(np.where(T >= 20.0, 0.35, 0.0)), track)
    assert found is not None
    assert found.diameter == pytest.approx(32.0, rel=0.02)


def test_no_circle_below_one_and_a_half_turns_or_by_other_hands() -> None:
    over = np.where(T >= 20.0, 0.35, 0.0)
    assert circle(cycles(over), turning(0.07, 32.0)) is None
    assert circle(cycles(over, Mode.HOLD), turning(0.08, 32.0)) is None
    assert circle(cycles(np.zeros(len(T))), turning(0.08, 32.0)) is None
    held = np.where(T >= 20.0, 0.3 + 0.01 * np.sin(T), 0.0)  # by a person, who is never quite still
    assert circle(cycles(held), turning(0.08, 32.0)) is None


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("base", [0.0, 179.0])
def test_a_zigzag_has_two_overshoots_and_a_period(side: float, base: float) -> None:
    rudder = side * 0.35 * np.select([T < 20.0, T < 30.0, T < 45.0, T < 62.0, T < 80.0], [0, 1, -1, 1, -1], 1)
    peaks = [20.0, 30.0, 33.0, 45.0, 47.0, 62.0, 65.0, 80.0]
    psi = base - side * np.interp(T, peaks, [0.0, 20.0, 27.5, -20.0, -25.0, 20.0, 26.0, -20.0])
    found = zigzag(cycles(rudder), {"eta.psi": np.angle(np.exp(1j * np.radians(psi)))})
    assert found is not None
    assert math.degrees(found.first_overshoot) == pytest.approx(7.5, abs=0.02)
    assert math.degrees(found.second_overshoot) == pytest.approx(5.0, abs=0.02)
    assert found.period == pytest.approx(62.0 - 30.0, abs=0.02)


@pytest.mark.parametrize(
    "rudder",
    [
        np.where(T >= 20.0, 0.35, 0.0),
        0.35 * np.select([T < 20.0, T < 30.0, T < 45.0], [0, 1, -1], 1),
        0.35 * np.select([T < 20.0, T < 30.0, T < 45.0, T < 60.0], [0, 1, -1, 0], 1),
        0.35 * np.select([T < 20.0, T < 30.0, T < 45.0, T < 60.0], [0, 1, -0.5, 1], -1),
    ],
)
def test_what_is_no_zigzag_has_no_figures(rudder: np.ndarray) -> None:
    assert zigzag(cycles(rudder), {"eta.psi": np.sin(0.2 * T)}) is None
