"""How fast the bottom rises, by its depth at 10 Hz."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest

from firmware_py.safety.bottom_track import BottomTrack


def after(depths: Iterable[float]) -> BottomTrack:
    track = BottomTrack()
    for depth in depths:
        track = track.after_a_step(float(depth))
    return track


@pytest.mark.parametrize("rise", [0.1, 0.4, 0.8])
def test_a_slope_is_known_within_8_s_and_a_bottom_that_falls_has_a_negative_rise(rise: float) -> None:
    t = 0.1 * np.arange(80)
    assert after(40.0 - rise * t).rise == pytest.approx(rise, rel=0.1)
    assert after(40.0 + rise * t).rise == pytest.approx(-rise, rel=0.1)


def test_noise_makes_no_slope() -> None:
    noise = np.random.default_rng(1000).normal(0.0, 0.1, 6000)
    track, most = BottomTrack(), 0.0
    for depth in 40.0 + noise:
        track = track.after_a_step(float(depth))
        most = max(most, abs(track.rise))
    assert most < 0.12


def test_an_edge_is_no_slope_nor_is_a_bottom_that_comes_into_sight_again() -> None:
    assert after([40.0] * 50 + [37.0] * 50).rise == pytest.approx(0.0, abs=1e-9)
    assert after([40.0 - 0.05 * i for i in range(50)] + [math.nan] + [37.0]).rise == 0.0
