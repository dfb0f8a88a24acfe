"""SBG's frames: those that the maker's library writes, frames of the test's own by its description, what is refused."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import sbg
from firmware_py.wire.serial.sbg import Attitude, Rates, crc16, decode, encode
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

# Written by the maker's C library, sbgECom 5.2.
WRITTEN_ANGLES = bytes.fromhex(
    "FF5A06002800 20BCBE00 CDCCCC3DCDCC4CBE00004040 6F12833A6F12033B8FC2F53C 32020000 CDCC4C3DCDCC8C3F 05EC33"
)
WRITTEN_QUATERNION = bytes.fromhex(
    "FF5A07002C00 FFFFFFFF 0000003F000000BF0000003F0000003F 6F12833A6F12033B8FC2F53C 14000000 CDCC4C3DCDCC8C3F 784D33"
)
WRITTEN_FLOATS = bytes.fromhex(
    "FF5A03003A00 E8030000FF03 0000803F00000040CDCC1C41 CDCCCC3DCDCC4CBE9A99993E 0000AC41"
    "0000803F00000040CDCC1C41 CDCCCC3DCDCC4CBE9A99993E C7DA33"
)
WRITTEN_STEPS = bytes.fromhex("FF5A2C002000 D0070000FF03 000000000000000000000000 66666600333333FF34333301 0000 B3C433")
WRITTEN_COARSE = bytes.fromhex(
    "FF5A2C002000 D0070000FF07 000000000000000000000000 40DF551D5E73DAFFF4523800 0000 783D33"
)

GOOD = 0x32  # roll and pitch valid, heading valid, mode 2
WORKS = 0x3FF
ATTITUDE = Attitude(12.5, (0.5, -0.25, 3.0), deviations=(0.125, 0.25, 0.5), status=GOOD)
TURN = Rates(12.5, (0.25, -0.5, 0.125), WORKS)

times = st.integers(0, 2**32 - 1)
words = st.integers(0, 2**32 - 1)
three = st.tuples(*[st.floats(-1e6, 1e6, width=32)] * 3)
four = st.tuples(*[st.floats(-1.0, 1.0, width=32)] * 4)


def crc_of_the_test(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def frame(kind: int, data: bytes, group: int = 0) -> bytes:
    body = bytes((kind, group)) + struct.pack("<H", len(data)) + data
    return b"\xff\x5a" + body + struct.pack("<H", crc_of_the_test(body)) + b"\x33"


def test_crc_has_the_catalogued_check_value():
    assert crc16(b"123456789") == 0x2189


@given(st.binary(max_size=100))
def test_crc_is_that_of_the_makers_description(data):
    assert crc16(data) == crc_of_the_test(data)


def test_frames_of_the_maker_are_read():
    attitude = decode(WRITTEN_ANGLES)
    assert attitude[:2] == (12.5, pytest.approx((0.1, -0.2, 3.0)))
    assert attitude.deviations == pytest.approx((0.001, 0.002, 0.03))
    assert (attitude.status, attitude.usable) == (0x232, True)
    attitude = decode(WRITTEN_QUATERNION)
    assert (attitude.time, attitude.quaternion) == (4294.967295, (0.5, -0.5, 0.5, 0.5))
    assert (attitude.tilt_usable, attitude.usable) == (True, False)
    for content, time, rates, status in (
        (WRITTEN_FLOATS, 0.001, (0.1, -0.2, 0.3), 0x3FF),
        (WRITTEN_STEPS, 0.002, (0.1, -0.2, 0.3), 0x3FF),
        (WRITTEN_COARSE, 0.002, (40.0, -0.2, 0.3), 0x7FF),
    ):
        assert decode(content) == (time, pytest.approx(rates, abs=1e-7, rel=1e-6), status)
    assert encode(decode(WRITTEN_STEPS)) == WRITTEN_STEPS
    assert encode(decode(WRITTEN_COARSE)) == WRITTEN_COARSE


@given(times, three, three, words, st.binary(max_size=20))
def test_angles_are_read(time, angles, deviations, status, rest):
    """Older firmware sends no declination and inclination (8 bytes) behind the status; newer may send more."""
    back = decode(frame(6, struct.pack("<I6fI", time, *angles, *deviations, status) + rest))
    assert back == Attitude(time / 1e6, angles, deviations=deviations, status=status)


@given(times, four, three, words, st.binary(max_size=20))
def test_quaternions_are_read(time, quaternion, deviations, status, rest):
    back = decode(frame(7, struct.pack("<I7fI", time, *quaternion, *deviations, status) + rest))
    assert back == Attitude(time / 1e6, quaternion=quaternion, deviations=deviations, status=status)


@given(times, three, st.integers(0, 0xFFFF))
def test_rates_as_floats_are_read(time, rates, status):
    content = struct.pack("<IH3f3ff3f3f", time, status, 1.0, 2.0, 3.0, *rates, 20.0, 1.0, 2.0, 3.0, *rates)
    assert decode(frame(3, content)) == Rates(time / 1e6, rates, status)


@given(times, st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 3), st.integers(0, 0xFFFF))
def test_rates_as_scaled_integers_are_read(time, steps, status):
    back = decode(frame(44, struct.pack("<IH3i3ih", time, status, 1, 2, 3, *steps, 5120)))
    scale = 12304174.0 if status & 0x400 else 67108864.0
    assert back == Rates(time / 1e6, tuple([step / scale for step in steps]), status)


def test_the_scales_agree_with_the_ranges_that_the_maker_names():
    """The fine one ends at about 1833 deg/s."""
    back = decode(frame(44, struct.pack("<IH3i3ih", 0, WORKS, 0, 0, 0, 2**31 - 1, 0, 0, 0)))
    assert math.degrees(back.rates[0]) == pytest.approx(1833.0, abs=1.0)


@given(times, four, three, words)
def test_attitude_that_is_written_is_read(time, quaternion, deviations, status):
    sent = Attitude(time / 1e6, quaternion=quaternion, deviations=deviations, status=status)
    assert decode(encode(sent)) == sent
    sent = Attitude(time / 1e6, deviations, deviations=deviations, status=status)
    assert decode(encode(sent)) == sent


@given(times, st.tuples(*[st.floats(-170.0, 170.0)] * 3), st.integers(0, 0x3FF))
def test_rates_that_are_written_are_read_to_the_devices_precision(time, rates, status):
    back = decode(encode(Rates(time / 1e6, rates, status)))
    coarse = back.status & 0x400
    assert back.rates == pytest.approx(rates, abs=0.51 / (12304174.0 if coarse else 67108864.0))
    assert (back.time, back.status & 0x3FF) == (time / 1e6, status)
    assert bool(coarse) == (max(map(abs, rates)) >= 32.0 - 2**-26)


def test_frames_that_are_written_are_those_of_the_test():
    content = struct.pack("<I6fI2f", 12_500_000, 0.5, -0.25, 3.0, 0.125, 0.25, 0.5, GOOD, 0.0, 0.0)
    assert encode(ATTITUDE) == frame(6, content)
    assert encode(TURN) == frame(44, struct.pack("<IH3i3ih", 12_500_000, WORKS, 0, 0, 0, 2**24, -(2**25), 2**23, 0))
    assert encode(ATTITUDE._replace(time=2**32 / 1e6 + 12.5)) == encode(ATTITUDE)


@pytest.mark.parametrize(("kind", "group"), [(1, 0), (8, 0), (6, 1), (7, 16), (6, 0x80)])
def test_other_frames_are_known_and_skipped(kind, group):
    assert decode(frame(kind, bytes(44), group)) is None


@pytest.mark.parametrize(
    ("status", "tilt", "usable"),
    [
        (0x00, False, False),
        (0x30, False, False),
        (0x31, True, False),
        (0x32, True, True),
        (0x34, True, True),
        (0x12, True, False),
        (0x22, False, False),
        (0x0FFFFFC4, False, False),
    ],
)
def test_what_the_device_does_not_vouch_for_is_not_used(status, tilt, usable):
    back = decode(encode(ATTITUDE._replace(status=status)))
    assert (back.tilt_usable, back.usable, back.mode) == (tilt, usable, status & 15)


@pytest.mark.parametrize("bit", range(10))
def test_rates_are_used_where_the_gyros_work(bit):
    assert decode(encode(TURN)).usable
    assert decode(encode(TURN._replace(status=WORKS & ~(1 << bit)))).usable == (bit in (2, 3, 4, 8))


@pytest.mark.parametrize("number", [math.inf, -math.inf, math.nan, 3e38])
def test_extreme_numbers_are_read(number):
    back = decode(encode(ATTITUDE._replace(angles=(number, 0.0, 0.0))))
    assert back.angles[0] == pytest.approx(number, nan_ok=True)
    assert back.usable == math.isfinite(number)
    content = struct.pack("<IH12x3f28x", 0, WORKS, number, 0.0, 0.0)
    assert decode(frame(3, content)).usable == math.isfinite(number)


def test_rates_out_of_range_are_written_as_the_largest():
    assert decode(encode(TURN._replace(rates=(1e9, -1e9, 0.0)))).rates == pytest.approx(
        (174.53, -174.53, 0.0), abs=0.01
    )
    with pytest.raises(ValueError, match="NaN"):
        encode(TURN._replace(rates=(math.nan, 0.0, 0.0)))


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "frame of 0 bytes"),
        (encode(ATTITUDE)[:-1], "frame of 48 bytes"),
        (encode(ATTITUDE) + b"\x33", "frame of 50 bytes"),
        (encode(ATTITUDE)[:-1] + b"\x34", "must be FF 5A"),
        (frame(6, bytes(31)), "message 6 with 31 bytes: must be 32"),
        (frame(7, bytes(35)), "message 7 with 35 bytes: must be 36"),
        (frame(3, bytes(57)), "message 3 with 57 bytes: must be 58"),
        (frame(44, bytes(31)), "message 44 with 31 bytes: must be 32"),
    ],
)
def test_what_is_malformed_says_why(content, why):
    with pytest.raises(SentenceError, match=why):
        decode(content)


def test_a_bad_checksum_says_what_would_be_right():
    content = encode(ATTITUDE)
    with pytest.raises(ChecksumError, match=f"must be {crc_of_the_test(content[2:-3]):04x}"):
        decode(content[:-3] + bytes((content[-3] ^ 1, content[-2])) + b"\x33")


@given(
    st.lists(st.binary(max_size=150) | st.sampled_from([encode(ATTITUDE), b"\xff\x5a", b"\xff\x5a\x06\x00\x70\x00"]))
)
def test_any_bytes_do_no_harm(pieces):
    decoder = sbg.frames()
    for piece in pieces:
        decoder.feed(piece)
    assert decoder.feed(bytes(300) + encode(ATTITUDE))[-1:] == [ATTITUDE]
