"""What is left of the fins' effect, by a bank of filters: the truth is a hull under fins that a pilot moves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from firmware_py.safety.actuators.hull_response import PERIOD
from firmware_py.safety.actuators.share_watch import ShareWatch

DAMPING, CONTROL, EDDIES = -1.0, -0.2, 0.0122


class Hull:
    """Rate of turn under fins that move to 6 deg and back, in eddies, measured by gyros."""

    def __init__(self, seed: int, eddies: float = 0.0, watch: ShareWatch | None = None) -> None:
        self.watch = watch or ShareWatch(12.0, EDDIES, PERIOD)
        self.random, self.eddies, self.effect, self.swing = np.random.default_rng(seed), eddies, 1.0, math.radians(6.0)
        self.t = self.rate = self.eddy = 0.0
        self.named: list[tuple[float, float]] = []

    def run(self, seconds: float) -> float:
        for _ in range(round(seconds / PERIOD)):
            fin = self.swing * math.copysign(1.0, math.sin(0.8 * self.t))
            self.eddy += -0.1 * self.eddy * PERIOD + self.eddies * math.sqrt(PERIOD) * self.random.standard_normal()
            self.rate += PERIOD * (DAMPING * self.rate + self.effect * CONTROL * fin + self.eddy)
            measured = self.rate + 4.4e-4 * self.random.standard_normal()
            if self.watch.update(measured, DAMPING, 0.0, CONTROL * fin):
                self.named.append((self.t, self.watch.left))
            self.t += PERIOD
        return self.watch.left


@pytest.mark.parametrize("seed", range(1000, 1004))
@pytest.mark.parametrize("eddies", [0.0, 0.004, 0.012])
def test_half_is_found_in_seconds_and_so_is_nothing_and_the_whole(seed: int, eddies: float) -> None:
    hull = Hull(seed, eddies)
    assert hull.run(100.0) == 1.0
    for effect in (0.5, 0.0, 1.0):
        hull.effect, begun = effect, hull.t
        healed = effect == 1.0
        assert hull.run(60.0 if healed else 20.0) == effect
        slow = 50.0 if healed else 16.0
        assert hull.named[-1][0] - begun < (4.0 if eddies < 0.01 and not healed else slow)
        assert not healed or hull.named[-1][0] - begun > 9.0  # fins seldom heal


@pytest.mark.parametrize("eddies", [0.0, 0.004, 0.012, 0.018])
def test_nothing_is_found_in_sound_fins_nor_when_eddies_begin_or_end(eddies: float) -> None:
    hull = Hull(1000, eddies)
    assert hull.run(600.0) == 1.0
    hull.eddies = 0.012 - 0.5 * eddies
    hull.run(300.0)
    assert hull.named == []


@pytest.mark.parametrize("seed", [1002, 1003])
def test_designed_for_the_eddies_that_there_are_it_finds_nothing_in_them(seed: int) -> None:
    """Designed by a file that made too little of eddies it called sound rudders weak in the demonstration."""
    before, after = Hull(seed, 0.03), Hull(seed, 0.03)
    after.watch.design(0.03)
    before.run(300.0)
    after.run(300.0)
    assert before.named != []
    assert after.named == []


def test_fins_that_do_not_move_tell_nothing() -> None:
    hull = Hull(1000)
    hull.swing = 0.0
    hull.run(60.0)
    hull.effect = 0.5
    assert hull.run(200.0) == 1.0


def test_a_pause_keeps_what_was_found_and_memory_is_all_there_is() -> None:
    hull = Hull(1000)
    hull.run(60.0)
    hull.effect = 0.5
    hull.run(10.0)
    hull.watch.pause()
    assert hull.watch.left == 0.5
    hull.run(1.0)
    other = ShareWatch(12.0, EDDIES, PERIOD)
    other.thaw(hull.watch.freeze())
    for step in range(100):
        both = [watch.update(0.01 * math.sin(step), DAMPING, 0.0, 0.02) for watch in (hull.watch, other)]
        assert both[0] == both[1]
    assert other.freeze() == hull.watch.freeze()


@pytest.mark.parametrize("seed", range(1000, 1004))
def test_half_is_found_soon_after_a_start_though_it_makes_strong_eddies_the_likeliest(seed: int) -> None:
    hull, full = Hull(seed), math.radians(13.0)
    hull.swing = 0.0
    hull.run(5.0)
    hull.effect = 0.5
    while hull.swing < full:
        hull.swing = min(full, hull.swing + 0.2 * PERIOD)
        hull.run(PERIOD)
    hull.run(1.2)
    assert hull.watch.left == 0.5  # once 2.9 s after the fins began to move
