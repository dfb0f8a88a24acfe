"""Bottom track in the format PD6: ensembles of makers, lines lost, what is bad."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial.pd6 import BottomTrack, decode_line, encode, ensembles
from firmware_py.wire.serial.stream import Counts, SentenceError

# The example of Water Linked's description.
WATERLINKED = b"""\
:SA, +0.00, +0.00,  0.00
:TS,22020812061800, 0.0, +0.0,   0.0,1475.0,  0
:WI,    +0,    +0,    +0,    +0,V
:WS,    +0,    +0,    +0,V
:WE,    +0,    +0,    +0,V
:WD,       +0.00,       +0.00,       +0.00,   0.00,  0.00
:BI,  +123,  -420, +2000,    +0,A
:BS,  -420,  +123, +2000,A
:BE,    +0,    +0,    +0,V
:BD,       +0.00,       +0.00,       +0.00,   5.32,  0.00
""".replace(b"\n", b" \r\n")
TRACK = BottomTrack(43578.0, 0.123, -0.42, 2.0, 0.0, True, 5.32, 0.0)
NAMES = ("SA", "TS", "WI", "WS", "WE", "WD", "BI", "BS", "BE", "BD")
NAN = math.nan


def near(value, tolerance):
    return pytest.approx(value, abs=tolerance, nan_ok=True)


def without(*names):
    return b"".join(line for line in WATERLINKED.splitlines(keepends=True) if line[1:3].decode() not in names)


def test_the_example_of_a_maker_is_read():
    decoder = ensembles()
    assert decoder.feed(WATERLINKED * 2) == [TRACK, TRACK]
    assert decoder.counts == Counts(good=2)


def test_the_message_comes_with_the_line_of_the_distance():
    decoder = ensembles()
    lines = WATERLINKED.splitlines(keepends=True)
    assert [len(decoder.feed(line)) for line in lines] == [0] * 9 + [1]
    assert decoder.feed(b":HM,G,G,0000,0000,24.0,1.0,1.0\r\n") == []


@given(
    velocity=st.tuples(*[st.floats(-32.7, 32.7)] * 4),
    valid=st.booleans(),
    distance=st.floats(0.006, 9999.0),
    time=st.floats(0.0, 86399.99),
    age=st.floats(0.0, 999.0),
)
def test_what_is_written_is_read_to_the_devices_precision(velocity, valid, distance, time, age):
    [back] = ensembles().feed(encode(BottomTrack(time, *velocity, valid, distance, age)))
    assert (back.vx, back.vy, back.vz, back.error) == near(velocity, 0.00051)
    assert (back.valid, back.usable) == (valid, valid)
    assert (back.distance, back.age) == (near(distance, 0.0051), near(age, 0.0051))
    assert back.time == near(time, 0.0051)


@pytest.mark.parametrize("name", ["SA", "WI", "WS", "WE", "WD", "BS", "BE"])
def test_lines_that_are_not_read_may_be_lost(name):
    assert ensembles().feed(without(name) * 2) == [TRACK, TRACK]


def test_without_the_line_of_the_time_it_is_unknown():
    found = ensembles().feed(WATERLINKED + without("TS") + without("TS", "SA"))
    assert [message.time for message in found] == near([43578.0, NAN, NAN], 1e-9)
    assert [message[1:] for message in found] == [TRACK[1:]] * 3


@pytest.mark.parametrize("name", ["BI", "BD"])
def test_a_line_of_another_ensemble_completes_none(name):
    decoder = ensembles()
    assert decoder.feed(without(name) + WATERLINKED) == [TRACK]
    assert decoder.feed(without("SA", name) + WATERLINKED) == [TRACK]
    assert decoder.counts == Counts(good=2)


def test_lines_that_come_twice_belong_to_two_ensembles():
    decoder = ensembles()
    velocity, distance = (without(*({*NAMES} - {name})) for name in ("BI", "BD"))
    assert len(decoder.feed(velocity + distance * 3)) == 1
    assert decoder.counts == Counts(good=1)


def test_an_ensemble_without_bottom_track_is_another_kind():
    decoder = ensembles()
    assert decoder.feed(without("BI", "BS", "BE", "BD") + WATERLINKED) == [TRACK]
    assert decoder.counts == Counts(good=1, other=1)


def test_a_decoder_that_starts_within_an_ensemble_waits_for_the_next():
    lines = WATERLINKED.splitlines(keepends=True)
    for k in range(7, 10):
        assert ensembles().feed(b"".join(lines[k:]) + WATERLINKED) == [TRACK]
    for k in range(7):
        assert len(ensembles().feed(b"".join(lines[k:]) + WATERLINKED)) == 2


def test_what_is_bad_is_not_used():
    bad = WATERLINKED.replace(b"  +123,  -420, +2000,    +0,A", b"-32768,-32768,-32768,-32768,V")
    [message] = ensembles().feed(bad.replace(b"5.32", b"0.00"))
    assert (message.vx, message.vy, message.vz, message.error, message.distance) == near((NAN,) * 5, 0.0)
    assert not message.usable
    [marked] = ensembles().feed(WATERLINKED.replace(b"+0,A", b"+0,V"))
    assert not marked.usable
    [unknown] = ensembles().feed(WATERLINKED.replace(b"  +123", b"-32768"))
    assert not unknown.usable


@given(st.tuples(*[st.floats()] * 5))
def test_extreme_numbers_are_written_without_harm(numbers):
    a, b, c, d, e = numbers
    for message in ensembles().feed(encode(BottomTrack(a, b, c, d, e, True, a, b))):
        assert message.usable <= all(math.isfinite(number) for number in (b, c, d))


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"", "not a line"),
        (b"BI,1,2,3,4,A", "not a line"),
        (b":B1,1,2,3,4,A", "not a line"),
        (b":BI,1,2,3,A", "4 fields: must be 5"),
        (b":BI,1,2,3,4,5,A", "6 fields: must be 5"),
        (b":BI,1,2,3,4,", "must be A or V"),
        (b":BI,1,2,x,4,A", "not a number"),
        (b":BI,1,2,-32769,4,A", "within 32768"),
        (b":BD,1,2,3,4", "4 fields: must be 5"),
        (b":BD,1,2,3,x,5", "not a number"),
        (b":TS,2202081206180,0,0,0,1475.0,0", "YYMMDDHHmmsshh"),
        (b":TS,22020825061800,0,0,0,1475.0,0", "hhmmss"),
        (b":TS,22020812061800", "1 fields: must be 6"),
    ],
)
def test_a_malformed_line_says_why(line, why):
    with pytest.raises(SentenceError, match=why):
        decode_line(line)


def test_lines_of_unknown_kinds_are_skipped():
    assert decode_line(b":XY,1,2") is None
    assert ensembles().feed(WATERLINKED.replace(b":BS", b":XY")) == [TRACK]
