"""The vehicle's time of a device's stamps: what is random in a delay is taken off, and no clock is trusted for good."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.drivers.device_clock import JUMP_S, WINDOW_S, DeviceClock

DELAY = 0.004
times = st.floats(0.0, 1e6)


def flown(rate: float, offset: float, seconds: float, clock: DeviceClock, jitter: float = 0.02) -> list[float]:
    """The errors of the times of validity of a 100 Hz device, once it is known, beyond its least delay."""
    source, errors = random.Random(5), []
    for k in range(int(100 * seconds)):
        t = k / 100
        arrival = t + DELAY + source.uniform(0.0, jitter)
        found = clock.at(offset + t * rate, arrival)
        assert found <= arrival
        if t > WINDOW_S:
            errors.append(found - t - DELAY)
    return errors


@pytest.mark.parametrize("offset", [0.0, -1e4, 1.7e9])
@pytest.mark.parametrize("rate", [1.0, 1.0 + 1e-4, 1.0 - 1e-4])
def test_uneven_delays_are_taken_off(rate, offset):
    errors = flown(rate, offset, 30.0, DeviceClock())
    assert max(map(abs, errors)) < 1.5e-3


@pytest.mark.parametrize("wrap", [math.inf, 604_800.0])
def test_a_stamp_that_no_clock_has_is_none(wrap):
    """Seconds of the week as a double may be any number, with a good checksum."""
    clock = DeviceClock(wrap)
    for stamp in (1e300, -1e300, 1.7e308, -1.7e308):
        assert clock.at(stamp, 5.0) == 5.0
    assert clock.at(100.0, 6.0) == pytest.approx(6.0, abs=1e-5)
    assert clock.at(-1.7e308, 6.1) == 6.1
    assert clock.at(100.1, 6.2) == pytest.approx(6.1, abs=1e-5)


def test_without_its_stamps_the_same_is_uncertain_by_the_whole_of_it():
    assert DeviceClock().at(math.nan, 5.0) == 5.0
    assert DeviceClock().at(math.inf, 5.0) == 5.0


@given(times, times, st.floats(0.0, JUMP_S - 1e-3))
def test_a_late_message_is_as_old_as_its_stamp_says(stamp, t, late):
    clock = DeviceClock()
    clock.at(stamp, t)
    assert clock.at(stamp + 0.1, t + 0.1 + late) == pytest.approx(t + 0.1, abs=2e-6)


@given(times, times, st.floats(-1e6, 1e6))
def test_a_clock_that_is_set_is_followed_at_once_unless_it_is_a_little_back(stamp, t, jump):
    clock = DeviceClock()
    clock.at(stamp, t)
    found = clock.at(stamp + 0.1 + jump, t + 0.1)
    assert found <= t + 0.1
    if jump > 0.0 or jump < -JUMP_S:
        assert found == pytest.approx(t + 0.1, abs=2e-6)


def test_a_clock_that_is_set_back_a_little_is_followed_after_two_windows():
    clock = DeviceClock()
    for k in range(1000):
        t = k / 100
        found = clock.at(t - (0.3 if t > 3.0 else 0.0), t)
    assert found == pytest.approx(t, abs=1e-5)


@given(times, st.integers(0, 200))
def test_a_clock_that_begins_again_from_0_is_the_same_clock(t0, at):
    wrap, clock = 4294.967296, DeviceClock(4294.967296)
    for k in range(200):
        stamp = (wrap + (k - at) / 100) % wrap
        late = 0.0 if k < 10 else 0.015
        assert clock.at(stamp, t0 + k / 100 + late) == pytest.approx(t0 + k / 100, abs=2e-5)


def test_what_is_told_twice_is_not_newer():
    clock = DeviceClock(86400.0)
    clock.at(1000.0, 5.0)
    assert len({clock.at(1000.1, 5.1 + k / 100) for k in range(20)}) == 1


@given(st.lists(st.tuples(st.floats(), st.floats(0.0, 10.0)), max_size=30), st.sampled_from([math.inf, 604800.0]))
def test_whatever_it_says_nothing_is_from_the_future(stamps, wrap):
    clock, t = DeviceClock(wrap), 0.0
    for stamp, step in stamps:
        t += step
        assert clock.at(stamp, t) <= t
