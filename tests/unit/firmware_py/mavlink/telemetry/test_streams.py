"""Intervals: in time whatever the base rate, once when late, and never more at once than may be."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.mavlink.telemetry.streams import DEFAULT_STREAMS, Streams, StreamTiming

MS = 1_000_000
SECOND = 1000 * MS


@pytest.mark.parametrize("base_hz", [50, 100, 200, 250, 400, 500, 1000])
def test_every_rate_holds_at_every_base_rate(base_hz: int) -> None:
    streams = Streams(DEFAULT_STREAMS)
    ticks = range(0, SECOND, SECOND // base_hz)
    said = [streams.due(t, 4) for t in ticks]
    assert sum(map(len, said)) == 2 * 10 + 6 * 5 + 7 * 2 + 11 * 1
    assert max(map(len, said)) <= (2 if base_hz == 50 else 1)


def test_what_is_late_goes_out_once_and_then_at_its_own_times() -> None:
    streams = Streams({7: StreamTiming(100 * MS, 10 * MS)})
    assert [t for t in range(555, 900, 5) if streams.due(t * MS, 4)] == [555, 610, 710, 810]


def test_what_does_not_fit_goes_first_in_the_next_tick() -> None:
    streams = Streams({name: StreamTiming(100 * MS, 0) for name in range(5)})
    assert [streams.due(t * MS, 2) for t in (0, 10, 20, 30, 100)] == [[0, 1], [2, 3], [4], [], [0, 1]]
    assert streams.due(110 * MS, 0) == []


def test_the_default_comes_back_at_its_old_times() -> None:
    streams = Streams({7: StreamTiming(100 * MS, 10 * MS)})
    assert streams.set_interval(7, 30_000, 0)
    assert [t for t in range(0, 200, 10) if streams.due(t * MS, 1)] == [30, 60, 90, 120, 150, 180]
    assert streams.set_interval(7, 0, 205 * MS)
    assert [t for t in range(210, 500, 10) if streams.due(t * MS, 1)] == [210, 310, 410]


def test_a_message_without_a_default_is_sent_only_while_it_is_asked_for() -> None:
    streams = Streams({})
    assert streams.due(0, 4) == []
    assert streams.set_interval(9, 100_000, 0)
    assert streams.due(100 * MS, 4) == [9]
    assert streams.set_interval(9, 0, 150 * MS)
    assert not any(streams.due(t * MS, 4) for t in range(150, 1000, 10))


@given(st.lists(st.tuples(st.integers(1, 200), st.integers(0, 3)), max_size=60))
def test_no_message_is_sent_more_often_than_its_interval_allows(steps: list[tuple[int, int]]) -> None:
    streams, t, sent = Streams(DEFAULT_STREAMS), 0, dict.fromkeys(DEFAULT_STREAMS, 0)
    for wait, most in steps:
        t += wait * MS
        names = streams.due(t, most)
        assert len(names) <= most
        for name in names:
            sent[name] += 1
    for name, (period, phase) in DEFAULT_STREAMS.items():
        assert sent[name] <= max(0, (t - phase) // period + 1)
