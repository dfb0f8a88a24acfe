"""Sentences of depth sensors: the makers' examples, units, damage."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial.checksums import xor_sum
from firmware_py.wire.serial.depth_sentences import Depth, decode, encode
from firmware_py.wire.serial.stream import ChecksumError, SentenceError


def line(body: str) -> bytes:
    return b"$%s*%02X" % (body.encode(), xor_sum(body.encode()))


def near(value, tolerance):
    return pytest.approx(value, abs=tolerance, nan_ok=True)


def same(found, expected, tolerance=1e-6):
    return found.sentence == expected.sentence and found[1:] == near(expected[1:], tolerance)


def test_examples_of_the_makers_are_read():
    assert same(decode(b"$PIPS,0001.00,M*78"), Depth("PIPS", 1.0))
    valeport = b"$ISDPT,   0.996,M,  0.1004,B,00.00,C*2b"
    assert same(decode(valeport), Depth("ISDPT", 0.996, 10040.0, 273.15))
    impact = b"$ISDPT,-000.485,M,000.9689,B,30.81,C*28"
    assert same(decode(impact), Depth("ISDPT", -0.485, 96890.0, 303.96))
    assert decode(b"$ISHPR,060.8,-89.5,-081.1*60") is None


def test_examples_of_the_makers_are_written():
    assert encode(Depth("PIPS", 1.0)) == b"$PIPS,0001.00,M*78\r\n"
    assert encode(Depth("ISDPT", -0.485, 96890.0, 303.96)) == b"$ISDPT,-000.485,M,000.9689,B,30.81,C*28\r\n"


@pytest.mark.parametrize(
    ("unit", "depth", "pressure"),
    [
        ("M", 12.5, math.nan),
        ("f", 3.81, math.nan),
        ("m", math.nan, 1250.0),
        ("d", math.nan, 125000.0),
        ("B", math.nan, 1250000.0),
        ("P", math.nan, 86184.466),
    ],
)
def test_the_unit_tells_what_the_number_is(unit, depth, pressure):
    assert same(decode(line(f"PIPS,0012.50,{unit}")), Depth("PIPS", depth, pressure), 1e-3)
    found = decode(line(f"ISDPT,  12.500,{unit},  1.5000,B,00.00,C"))
    assert same(found, Depth("ISDPT", depth, 150000.0, 273.15))
    assert found.usable


@given(st.floats(-50.0, 6000.0), st.floats(0.0, 6e7), st.floats(260.0, 320.0))
def test_what_is_written_is_read_to_the_devices_precision(depth, pressure, temperature):
    back = decode(encode(Depth("ISDPT", depth, pressure, temperature)).strip())
    assert back[1:] == (near(depth, 0.00051), near(pressure, 5.1), near(temperature, 0.0051))
    assert decode(encode(Depth("PIPS", depth)).strip()).depth == near(depth, 0.0051)
    assert decode(encode(Depth("PIPS", math.nan, pressure)).strip()).pressure == near(pressure, 51.0)


@given(st.floats(), st.floats(), st.floats())
def test_extreme_numbers_are_written_and_read_without_harm(depth, pressure, temperature):
    for name in ("PIPS", "ISDPT"):
        back = decode(encode(Depth(name, depth, pressure, temperature)).strip())
        assert back.usable <= (math.isfinite(depth) or math.isfinite(pressure))


@pytest.mark.parametrize("body", ["PIPS,,M", "PIPS,nan,M", "PIPS,inf,d", "ISDPT,   ,M,   ,B,00.00,C"])
def test_what_is_unknown_is_not_used(body):
    assert not decode(line(body)).usable


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("PIPS,0001.00,", "must be M, f, m, d, B or P"),
        ("PIPS,0001.00", "1 fields: must be 2"),
        ("PIPS,0001.00,x", "must be M, f, m, d, B or P"),
        ("PIPS,one,M", "not a number"),
        ("ISDPT,1,M,1,B,1", "5 fields: must be 6"),
        ("ISDPT,1,,1,B,1,C", "must be M, f, m, d, B or P"),
        ("ISDPT,1,M,1,d,1,C", "must be B and C"),
        ("ISDPT,1,M,1,B,1,F", "must be B and C"),
        ("ISDPT,1,M,x,B,1,C", "not a number"),
    ],
)
def test_a_malformed_sentence_says_why(body, why):
    with pytest.raises(SentenceError, match=why):
        decode(line(body))


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 78"):
        decode(b"$PIPS,0001.00,M*79")
