"""The DVL's sentences: the maker's examples, split anywhere, damaged in every way."""

from __future__ import annotations

import math
import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial.stream import ChecksumError, Counts, Lines, SentenceError
from firmware_py.wire.serial.waterlink_dvl import Velocity, crc8, decode, encode

# Examples of the maker's protocol description.
WRZ = b"wrz,0.120,-0.400,2.000,y,1.30,1.855,1e-07;0;1.4;0;1.2;0;0.2;0;1e+09,7,14,123.00,1*50"
OTHERS = (b"wru,0,0.070,1.10,-40,-95*9c", b"wrp,49056.809,0.41,0.15,1.23,0.4,53.9,13.0,19.3,0*de")
REPORT = Velocity(0.12, -0.4, 2.0, True, 1.3, 1.855, (1e-07, 0.0, 1.4, 0.0, 1.2, 0.0, 0.2, 0.0, 1e9), 7, 14, 123.0, 1)


def line(body: bytes) -> bytes:
    return b"%s*%02x" % (body, crc8(body))


def test_crc_has_the_catalogued_check_value():
    assert crc8(b"123456789") == 0xF4


def test_the_example_of_the_maker_is_read_and_written():
    assert decode(WRZ) == REPORT
    assert decode(WRZ[:-2] + b"50".upper()) == REPORT
    assert encode(REPORT) == WRZ + b"\r\n"


@pytest.mark.parametrize("sentence", OTHERS)
def test_other_sentences_are_known_and_skipped(sentence):
    assert decode(sentence) is None


@given(
    velocity=st.tuples(*[st.floats(-20.0, 20.0)] * 3),
    valid=st.booleans(),
    altitude=st.floats(-1.0, 60.0),
    fom=st.floats(0.0, 10.0),
    times=st.tuples(st.integers(0, 2**53), st.integers(0, 2**53)),
)
def test_what_is_written_is_read_to_the_devices_precision(velocity, valid, altitude, fom, times):
    report = Velocity(*velocity, valid, altitude, fom, (1e-6,) * 9, *times, 100.0, 0)
    back = decode(encode(report).strip())
    assert back[:3] == pytest.approx(velocity, abs=0.00051)
    assert (back.altitude, back.fom) == (pytest.approx(altitude, abs=0.0051), pytest.approx(fom, abs=0.00051))
    assert (back.valid, back[7:9], back.status) == (valid, times, 0)


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_bytes_split_at_every_position(end):
    stream = WRZ + end + OTHERS[0] + end + WRZ + end
    for at in range(len(stream) + 1):
        buffer = Lines(decode)
        assert buffer.feed(stream[:at]) + buffer.feed(stream[at:]) == [REPORT, REPORT]
        assert buffer.counts == Counts(good=2, other=1)
    one_by_one = Lines(decode)
    assert [r for i in range(len(stream)) for r in one_by_one.feed(stream[i : i + 1])] == [REPORT, REPORT]


def test_a_damaged_byte_is_noticed_and_the_next_line_is_read():
    for at in range(len(WRZ)):
        damaged = WRZ[:at] + bytes((WRZ[at] ^ 0x04,)) + WRZ[at + 1 :]
        buffer = Lines(decode)
        assert buffer.feed(damaged + b"\r\n" + WRZ + b"\r\n") == [REPORT]
        assert buffer.counts.bad_checksum + buffer.counts.malformed == 1


def test_bytes_lost_within_a_line_lose_that_line_only():
    for lost in (1, 5, 40, len(WRZ)):
        for at in range(0, len(WRZ) - lost + 1, 7):
            buffer = Lines(decode)
            reports = buffer.feed(WRZ[:at] + WRZ[at + lost :] + b"\n" + WRZ + b"\n")
            assert reports == [REPORT]


def test_a_lost_line_end_spoils_two_lines_and_no_third():
    buffer = Lines(decode)
    assert buffer.feed(WRZ + WRZ + b"\n" + WRZ + b"\n") == [REPORT]
    assert buffer.counts.bad_checksum == 1


@pytest.mark.parametrize(
    ("body", "why"),
    [
        (b"wrz,1,2,3,y,1,1,0;0;0;0;0;0;0;0;0,1,2,3", "11 fields"),
        (b"wrz,1,2,3,y,1,1,0;0;0;0;0;0;0;0;0,1,2,3,0,0", "13 fields"),
        (b"wrz,1,2,3,m,1,1,0;0;0;0;0;0;0;0;0,1,2,3,0", "y or n"),
        (b"wrz,1,2,x,y,1,1,0;0;0;0;0;0;0;0;0,1,2,3,0", "not a number"),
        (b"wrz,1,2,3,y,1,1,0;0;0;0;0;0;0;0,1,2,3,0", "8 entries"),
        (b"wrz,1,2,3,y,1,1,0;0;0;0;0;0;0;0;0,1.5,2,3,0", "not a number"),
        (b"wrz," + b"\xff" * 11, "1 fields|2 fields"),
        (b"$GPGGA", "not a sentence"),
    ],
)
def test_a_malformed_sentence_says_why(body, why):
    with pytest.raises(SentenceError, match=why):
        decode(line(body))


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 50"):
        decode(WRZ[:-2] + b"51")


@pytest.mark.parametrize("altitude", [-1.0, 0.0, 1e9, math.nan, math.inf])
def test_an_altitude_that_is_none_is_unknown(altitude):
    report = decode(encode(REPORT._replace(altitude=altitude)).strip())
    assert math.isnan(report.bottom)
    assert report.usable


def test_what_the_device_does_not_vouch_for_is_not_used():
    report = decode(encode(REPORT._replace(valid=False)).strip())
    assert not report.usable
    assert math.isnan(report.bottom)
    lost = decode(encode(REPORT._replace(vy=math.nan)).strip())
    assert math.isnan(lost.vy)
    assert not lost.usable
    assert REPORT.bottom == 1.3


def test_garbage_without_end_is_bounded_and_left_behind():
    buffer = Lines(decode, longest=200)
    tracemalloc.start()
    for _ in range(1000):
        assert buffer.feed(b"\xaaw*" * 50) == []
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 2000  # bytes, of the 150,000 that came
    assert buffer.feed(b"tail of it\n" + WRZ + b"\n") == [REPORT]
    assert buffer.counts == Counts(good=1, too_long=1)
    assert buffer.feed(b"x" * 300 + b"\n" + WRZ + b"\n") == [REPORT]
    assert buffer.counts.too_long == 2


@given(st.lists(st.binary(max_size=300)))
def test_any_bytes_do_no_harm(pieces):
    buffer = Lines(decode)
    for piece in pieces:
        buffer.feed(piece)
    assert buffer.feed(b"\n" + WRZ + b"\n")[-1:] == [REPORT]
