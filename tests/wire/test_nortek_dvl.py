"""Bottom-track sentences of Nortek DVLs: the maker's examples, what is invalid, damage."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial.checksums import xor_sum
from firmware_py.wire.serial.nortek_dvl import UNKNOWN, Beam, Velocity, decode, encode
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

# Examples of the maker's integrator's guides.
BT7 = b"$PNORBT7,1452244916.7508,1.234,-1.234,0.1234,0.1234,0.1234,12.34,23.45,23.45,23.45,23.45*39"
BT9 = (
    b"$PNORBT9,1452244916.7508,1.234,-1.234,0.1234,0.1234,0.1234,12.34,23.45,23.45,23.45,23.45,23.4,1567.8,1.2,12.3,"
    b"0x000FFFFF*1E"
)
BT = b"$PNORBT,3,112813,072228.2345,0.1234,0.1234,1.11111,122.2,36.66,2.22222,F7*7A"
BT_TAGS = (
    b"$PNORBT,BEAM=3,DATE=112813,TIME=072228.2345,DT1=0.1234,DT2=0.1234,BV=1.11111,FM=122.2,DIST=36.66,WV=2.22222,"
    b"STAT=F7*75"
)
BT0 = b"$PNORBT0,1,040721,131335.3341,23.961,-48.122,-32.76800,10.00000,0.00,0x00000000*48"
VELOCITY = Velocity(1e9, 0.001234, -0.04, 1.5, -0.02, 0.1, 0.003, (5.0, 5.2, 5.4, 5.6))
NAN = math.nan
VALID = 0x000FFFFF


def line(body: str) -> bytes:
    return b"$%s*%02X" % (body.encode(), xor_sum(body.encode()))


def near(value, tolerance):
    return pytest.approx(value, abs=tolerance, nan_ok=True)


def tagged(body: bytes, name: str) -> bytes:
    """The same values with the tags that the guide gives."""
    tags = [
        "TIME",
        "DT1",
        "DT2",
        "VX",
        "VY",
        "VZ",
        "FOM",
        "D1",
        "D2",
        "D3",
        "D4",
        "BATT",
        "SS",
        "PRESS",
        "TEMP",
        "STAT",
    ]
    values = body[1 : body.index(b"*")].decode().split(",")[1:]
    return line(",".join([name] + [f"{tag}={value}" for tag, value in zip(tags, values, strict=False)]))


@pytest.mark.parametrize("sentence", [BT7, BT9, tagged(BT7, "PNORBT6"), tagged(BT9, "PNORBT8")])
def test_velocities_of_the_maker_are_read(sentence):
    v = decode(sentence)
    assert (v.time, v.since_trigger, v.since_output) == near((1452244916.7508, 0.001234, -0.001234), 1e-7)
    assert (v.vx, v.vy, v.vz, v.distances) == (0.1234, 0.1234, 0.1234, (23.45,) * 4)
    assert math.isnan(v.fom)  # the example's 12.34 is beyond what the device calls valid
    assert not v.usable
    assert v.bottom == near(23.45, 1e-9)
    if b"BT9" in sentence or b"BT8" in sentence:
        assert (v.battery, v.sound_speed, v.pressure, v.temperature) == near((23.4, 1567.8, 12e3, 285.45), 1e-6)
        assert v.status == VALID
    else:
        assert v.status == UNKNOWN


@pytest.mark.parametrize("sentence", [BT, BT_TAGS])
def test_beams_of_the_maker_are_read(sentence):
    assert decode(sentence) == Beam("PNORBT", 3, near(26548.2345, 1e-6), 1.11111, 122.2, 36.66, 2.22222, 0xF7)


@pytest.mark.parametrize("sentence", [BT0, line("PNORBT1,BEAM=1,DATE=040721,TIME=131335.3341,DT1=23.961,DT2=-48.122,"
    "BV=-32.76800,FOM=10.00000,DIST=0.00,STAT=0x00000000")])  # fmt: skip
def test_a_beam_without_bottom_is_unknown(sentence):
    beam = decode(sentence)
    assert beam[:2] == ("PNORBT0", 1)
    assert beam[2:] == near((47615.3341, NAN, NAN, NAN, NAN, 0), 1e-6)


@given(
    velocity=st.tuples(*[st.floats(-20.0, 20.0)] * 3),
    fom=st.floats(0.0, 9.9),
    distances=st.tuples(*[st.floats(0.1, 200.0)] * 4),
    delays=st.tuples(*[st.floats(-1.0, 1.0)] * 2),
    status=st.none() | st.integers(0, 2**32 - 1),
)
def test_what_is_written_is_read_to_the_devices_precision(velocity, fom, distances, delays, status):
    told = Velocity(1e9, *delays, *velocity, fom, distances)
    if status is not None:
        told = told._replace(battery=24.0, sound_speed=1500.0, pressure=1e5, temperature=283.15, status=status)
    back = decode(encode(told).strip())
    assert (back.vx, back.vy, back.vz) == near(velocity, 0.000051)
    assert (back.fom, back.distances) == (near(fom, 0.0000051), near(distances, 0.0051))
    assert (back.since_trigger, back.since_output) == near(delays, 0.00000051)
    assert back[8:] == near(told[8:], 1e-3)


@given(st.integers(0, 4), st.floats(-20.0, 20.0), st.floats(0.0, 9.9), st.floats(0.1, 200.0), st.integers(0, 255))
def test_beams_that_are_written_are_read(beam, velocity, fom, distance, status):
    for name, water in (("PNORBT", 0.5), ("PNORBT0", NAN)):
        told = Beam(name, beam, 86399.5, velocity, fom, distance, water, status)
        back = decode(encode(told).strip())
        assert back[:2] == told[:2]
        assert back[2:] == near(told[2:], 0.0051)


def test_what_is_invalid_is_unknown():
    back = decode(encode(VELOCITY._replace(vy=NAN, fom=NAN, distances=(NAN, 5.0, NAN, 6.0))).strip())
    assert math.isnan(back.vy)
    assert math.isnan(back.fom)
    assert not back.usable
    assert back.bottom == near(5.5, 1e-9)
    assert math.isnan(decode(encode(VELOCITY._replace(distances=(NAN,) * 4)).strip()).bottom)
    assert b",-32.7680,0.1000,10.00000,0.00,5.00," in encode(
        VELOCITY._replace(vy=NAN, fom=NAN, distances=(NAN, 5.0, NAN, 6.0))
    )


@pytest.mark.parametrize("cleared", [12, 13, 14])
def test_a_status_that_calls_a_velocity_invalid_is_believed(cleared):
    assert VELOCITY.usable
    assert VELOCITY._replace(status=VALID).usable
    assert not VELOCITY._replace(status=VALID & ~(1 << cleared)).usable


@given(st.lists(st.floats(), min_size=8, max_size=8))
def test_extreme_numbers_are_written_and_read_without_harm(numbers):
    a, b, c, d, e, f, g, h = numbers
    for status in (UNKNOWN, VALID):
        back = decode(encode(Velocity(a, b, c, d, e, f, g, (h, a, b, c), d, e, f, g, status)).strip())
        assert back.usable <= all(math.isfinite(number) for number in (d, e, f, g))


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("PNORBT7,1,2,3", "3 fields: must be 11"),
        ("PNORBT9,1,2,3,4,5,6,7,8,9,10,11", "11 fields: must be 16"),
        ("PNORBT7,1,2,3,x,5,6,7,8,9,10,11", "not a number"),
        ("PNORBT6,TIME=1,DT1=2,DT2=3,VX=4,VX=5,VZ=6,FOM=7,D1=8,D2=9,D3=10,D4=11", "must be VY="),
        ("PNORBT6,TIME=1,DT1=2,DT2=3,VX=4,5,VZ=6,FOM=7,D1=8,D2=9,D3=10,D4=11", "must be VY="),
        ("PNORBT0,1,040721,131335.3341,23.961,-48.122,-32.76800,10.00000,0.00,0x", "hexadecimal"),
        ("PNORBT0,1,040721,131335.3341,23.961,-48.122,-32.76800,10.00000,0.00,-1", "hexadecimal"),
        ("PNORBT0,1,040721,131335.3341,23.961,-48.122,-32.76800,10.00000,0.00,0x123456789", "hexadecimal"),
        ("PNORBT0,x,040721,131335.3341,23.961,-48.122,-32.76800,10.00000,0.00,0x0", "not a count"),
        ("PNORBT0,1,040721,991335.3341,23.961,-48.122,-32.76800,10.00000,0.00,0x0", "hhmmss"),
    ],
)
def test_a_malformed_sentence_says_why(body, why):
    with pytest.raises(SentenceError, match=why):
        decode(line(body))


def test_other_sentences_are_known_and_skipped():
    assert decode(line("PNORI1,4,123456,3,30,1.00,5.00,BEAM")) is None
    assert decode(line("PNORBT4,1.234,-1.234,1.234,23.4,12.34567,12.3")) is None


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 39"):
        decode(BT7[:-1] + b"8")
