"""Real time, against a monotonic clock that the test moves."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters import realtime_schedule

DT = 10_000_000
OVER = 50_000
"""The test's sleep overshoots by this, ns, as every real one does."""


class Clock:
    """A monotonic clock; a sleep takes as long as it was asked to, and a little more."""

    def __init__(self, now: int = 123_456_789_000) -> None:
        self.now = self.start = now
        self.slept: list[float] = []

    def monotonic_ns(self) -> int:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.slept.append(seconds)
        self.now += round(seconds * 1e9) + OVER


@pytest.fixture
def fake(monkeypatch):
    fake = Clock()
    monkeypatch.setattr(realtime_schedule, "time", fake)
    return fake


def fly(fake: Clock, costs: list[int], advance=lambda k: True) -> list[tuple[int, int]]:
    """(moment since the start, late_ns) of every tick whose cycles take so long, ns."""
    ticks = []
    for cost, tick in zip(costs, realtime_schedule.RealTimeSchedule(DT, advance), strict=False):
        assert (tick.k, tick.dt_ns) == (len(ticks), DT)
        ticks.append((fake.now - fake.start, tick.late_ns))
        fake.now += cost
    return ticks


def test_ticks_begin_at_absolute_deadlines_whatever_a_cycle_costs(fake):
    costs = [0, 1_000_000, 9_000_000, 3_000_000, 0]
    assert fly(fake, costs) == [(0, 0), *((k * DT + OVER, OVER) for k in range(1, 5))]


def test_an_hour_does_not_drift(fake):
    *_, (moment, late) = fly(fake, [4_000_000] * 360_000)
    assert moment == 359_999 * DT + OVER
    assert late == OVER


def test_a_late_tick_begins_at_once_says_so_and_the_next_ones_catch_up(fake):
    ticks = fly(fake, [25_000_000, 1_000_000, 1_000_000, 0, 0])
    assert ticks == [
        (0, 0),
        (25_000_000, 15_000_000),
        (26_000_000, 6_000_000),
        (30_000_000 + OVER, OVER),
        (40_000_000 + OVER, OVER),
    ]
    assert len(fake.slept) == 2


def test_what_comes_before_a_tick_counts_as_its_lateness(fake):
    def advance(k):
        fake.now += 2_000_000
        return True

    assert [late for _, late in fly(fake, [0, 0], advance)] == [2_000_000, 2_000_000 + OVER]


def test_it_ends_before_the_tick_that_is_refused_and_asks_for_each_once(fake):
    asked = []

    def advance(k):
        asked.append((k, fake.now - fake.start))
        return k < 3

    assert len(fly(fake, [0] * 10, advance)) == 3
    assert asked == [(0, 0), *((k, k * DT + OVER) for k in (1, 2, 3))]


def test_slips_are_the_ticks_more_than_a_step_late_of_this_run(fake):
    schedule = realtime_schedule.RealTimeSchedule(DT, lambda k: k < 5)
    costs = iter([2 * DT, 0, 2 * DT + 1, 0, 0, 0, 0, 0, 0, 0])  # tick 1 begins exactly a step late, tick 3 a ns more
    for _ in schedule:
        fake.now += next(costs)
    assert schedule.slips == 1
    for _ in schedule:
        fake.now += next(costs)
    assert schedule.slips == 0


def test_who_watches_the_clock_before_a_deadline_begins_on_it(monkeypatch):
    class Running(Clock):
        """Every look at this clock takes 100 ns."""

        def monotonic_ns(self):
            self.now += 100
            return self.now

    fake = Running()
    monkeypatch.setattr(realtime_schedule, "time", fake)
    late = [tick.late_ns for tick in realtime_schedule.RealTimeSchedule(DT, lambda k: k < 20, spin_ns=OVER)]
    assert len(fake.slept) == 20
    assert max(late) <= 400


def test_each_run_begins_anew(fake):
    schedule = realtime_schedule.RealTimeSchedule(DT, lambda k: k < 2)
    assert [tick.k for tick in schedule] == [0, 1]
    fake.now += 10**12
    assert [(tick.k, tick.late_ns) for tick in schedule] == [(0, 0), (1, OVER)]


@given(st.lists(st.integers(0, 40_000_000), max_size=60))
def test_no_tick_is_early_or_skipped_and_lateness_is_exact(costs):
    fake = Clock()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(realtime_schedule, "time", fake)
        ticks = fly(fake, costs)
    assert len(ticks) == len(costs)
    free = 0
    for k, (moment, late) in enumerate(ticks):
        assert late == moment - k * DT >= 0
        assert moment <= max(free, k * DT + OVER)
        free = moment + costs[k]
