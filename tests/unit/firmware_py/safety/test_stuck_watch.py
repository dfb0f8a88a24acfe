"""Fins that stay and do not report it: the truth is a hull under two fins, of which one stops obeying."""

from __future__ import annotations

import math

import numpy as np
import pytest

from firmware_py.marine import clip
from firmware_py.safety.actuators.hull_response import PERIOD
from firmware_py.safety.actuators.stuck_watch import StuckWatch

DAMPING, EACH, EDDIES = -1.0, -0.1, 0.0122
TURN = 0.7 * PERIOD


class Hull:
    """Rate of turn under two fins that move to 6 deg and back, in eddies, measured by gyros.

    A fin that the watch takes for stuck is told to be there, and the other one to do the work of both.
    """

    def __init__(self, seed: int, eddies: float = 0.0, mute: tuple[int, ...] = (0, 1)) -> None:
        self.watch, self.mute = StuckWatch(12.0, EDDIES, PERIOD), mute
        self.random, self.eddies, self.swing, self.gust = np.random.default_rng(seed), eddies, math.radians(6.0), 0.0
        self.stays: dict[int, float] = {}
        self.t = self.rate = self.eddy = 0.0
        self.fins, self.modelled = [0.0, 0.0], [0.0, 0.0]
        self.named: list[tuple[float, int, float]] = []

    def run(self, seconds: float) -> Hull:
        for _ in range(round(seconds / PERIOD)):
            wanted = self.swing * math.copysign(1.0, math.sin(0.8 * self.t))
            told, (fin, angle) = [wanted, wanted], self.watch.stuck
            if fin >= 0:
                told[fin], told[1 - fin] = angle, 2.0 * wanted - angle
            for i in (0, 1):
                self.fins[i] += clip(self.stays.get(i, told[i]) - self.fins[i], -TURN, TURN)
                self.modelled[i] += clip(told[i] - self.modelled[i], -TURN, TURN)
            self.eddy += -0.1 * self.eddy * PERIOD + self.eddies * math.sqrt(PERIOD) * self.random.standard_normal()
            self.rate += PERIOD * (DAMPING * self.rate + EACH * sum(self.fins) + self.eddy + self.gust)
            measured = self.rate + 4.4e-4 * self.random.standard_normal()
            angles = [self.modelled[i] if i in self.mute else self.fins[i] for i in (0, 1)]
            if self.watch.update(measured, DAMPING, 0.0, (EACH, EACH), angles, self.mute):
                self.named.append((self.t, *self.watch.stuck))
            self.t += PERIOD
        return self


@pytest.mark.parametrize(("mute", "fin"), [((0,), 0), ((1,), 1), ((0, 1), 0), ((0, 1), 1)])
@pytest.mark.parametrize("angle", [10.0, -10.0, 3.0])
def test_the_fin_and_its_angle_are_found(mute: tuple[int, ...], fin: int, angle: float) -> None:
    """Two that are alike tell by what they are told then: the wrong one is given up within a second."""
    hull = Hull(1000, mute=mute).run(60.0)
    hull.stays[fin] = math.radians(angle)
    hull.run(20.0)
    assert hull.named[0][0] - 60.0 < 8.0
    found, where = hull.watch.stuck
    assert found == fin
    assert math.degrees(where) == pytest.approx(angle, abs=1.5)
    wrong = [t for t, named, _ in hull.named if named != fin]
    assert all(t < hull.named[0][0] + 1.0 for t in wrong)


def test_a_fin_that_stays_where_it_is_is_found_in_eddies() -> None:
    hull = Hull(1001, 0.004, (0,)).run(60.0)
    hull.stays[0] = hull.fins[0]
    assert hull.run(20.0).watch.stuck[0] == 0


@pytest.mark.parametrize("eddies", [0.0, 0.004, 0.012])
def test_nothing_is_found_in_sound_fins_nor_when_a_gust_begins(eddies: float) -> None:
    hull = Hull(1000, eddies).run(300.0)
    hull.gust = 2.0 * EACH * math.radians(5.0)
    assert hull.run(100.0).named == []


def test_fins_that_do_not_move_tell_nothing() -> None:
    hull = Hull(1000)
    hull.swing = 0.0
    hull.run(30.0).stays[0] = 0.0
    assert hull.run(60.0).named == []


def test_what_was_found_is_kept_in_a_pause_and_forgotten_when_the_fin_reports() -> None:
    hull = Hull(1000).run(60.0)
    hull.stays[0] = math.radians(10.0)
    found = hull.run(20.0).watch.stuck
    hull.watch.pause()
    assert hull.watch.stuck == found
    assert hull.watch.suspects
    hull.watch.forget()
    assert hull.watch.stuck[0] == -1
    assert not hull.watch.suspects


def test_it_goes_on_from_a_frozen_memory() -> None:
    one = Hull(1000).run(30.0)
    one.stays[0] = 0.1
    one.run(1.0)
    kept, again = one.watch.freeze(), Hull(1000).run(30.0)
    again.stays[0] = 0.1
    again.run(1.0)
    again.watch.update(1.0, DAMPING, 0.0, (EACH, EACH), (0.0, 0.0), (0, 1))
    again.watch.thaw(kept)
    assert one.run(10.0).watch.freeze() == again.run(10.0).watch.freeze()


def test_that_a_fin_stays_is_likely_before_it_is_named_and_since_when_is_known() -> None:
    """Sound fins and a gust make it likely for no longer than chance does."""
    sound = Hull(1000, 0.004).run(60.0)
    sound.gust = 2.0 * EACH * math.radians(5.0)
    assert max(doubted for doubted, _ in doubts(sound, 40.0)) < 3.0
    hull = Hull(1000).run(60.0)
    hull.stays[0] = math.radians(10.0)
    course = doubts(hull, 20.0)
    named = next(i for i, (_, fin) in enumerate(course) if fin >= 0)
    before = [doubted for doubted, _ in course[:named] if doubted > 0.0]
    assert before
    assert max(before) <= named * PERIOD + 1.0
    assert all(doubted > 0.0 for doubted, _ in course[named:])


def doubts(hull: Hull, seconds: float) -> list[tuple[float, int]]:
    """Return for how long it has been likely that a fin stays, s, and which one is named, step by step."""
    return [(hull.run(PERIOD).watch.doubt, hull.watch.stuck[0]) for _ in range(round(seconds / PERIOD))]
