"""Xsens' messages: recorded ones, a message of the test's own in every form of numbers, what is refused."""

from __future__ import annotations

import math
import struct
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import xsens
from firmware_py.wire.serial.stream import ChecksumError, Counts, SentenceError
from firmware_py.wire.serial.xsens import Attitude, decode, encode

# Recorded from devices.
COUNTER_AND_ANGLES = bytes.fromhex("FAFF36141020020009 20300CBFBC67E03EDFAE8140A3A9DFA7")
TIME_AND_ANGLES = bytes.fromhex("FAFF3616106004093A7CB720300CBF491A52BEC36A10C32EE2EF3E")
RATES_AND_STATUS = bytes.fromhex(
    "FAFF363110 2002DFC5 10600400459DA0 40200CBEDC9AFA3F549F37411CBB70 80200CBBAA5C803B8C5501BB813300 E0200400000081 45"
)
QUATERNION = bytes.fromhex(
    "FAFF364E 106004025335CB 2010103F7FFA66BB4034B83C49962D3B5A1F82 80200C39FF9101BAECDD81BA865380"
    "40200CBE64DB99BCE7FF83411DC2CF C0200CBE9048803F673204BF548904 E02004 00000003 C9"
)
OTHERS = (bytes.fromhex("FAFF360F80400C3B8BBC00BBE24F003B4E4A00AF"), bytes.fromhex("FAFF3100D0"))

ATTITUDE = Attitude((0.5, -0.25, 3.0), (0.5, -0.5, 0.5, 0.5), (0.25, -0.5, 0.125), "NED", 12.5, 7, 3)
FORMS = {xsens.FLOAT32: 1e-7, xsens.FIXED_12_20: 2**-21, xsens.FIXED_16_32: 2**-33, xsens.FLOAT64: 0.0}
three = st.tuples(*[st.floats(-180.0, 180.0)] * 3)
four = st.tuples(*[st.floats(-1.0, 1.0)] * 4)


def message(*items: tuple[int, bytes], kind: int = 0x36) -> bytes:
    data = b"".join([struct.pack(">HB", identifier, len(content)) + content for identifier, content in items])
    total = (0xFF + kind + len(data) + sum(data)) % 256
    return b"\xfa\xff" + bytes((kind, len(data))) + data + bytes(((256 - total) % 256,))


def numbers(values: tuple[float, ...], form: int) -> bytes:
    if form == xsens.FLOAT32:
        return struct.pack(f">{len(values)}f", *values)
    if form == xsens.FLOAT64:
        return struct.pack(f">{len(values)}d", *values)
    if form == xsens.FIXED_12_20:
        return b"".join([round(Fraction(value) * 2**20).to_bytes(4, "big", signed=True) for value in values])
    content = b""
    for value in values:
        six = round(Fraction(value) * 2**32).to_bytes(6, "big", signed=True)
        content += six[2:] + six[:2]
    return content


def test_recorded_messages_are_read():
    attitude = decode(COUNTER_AND_ANGLES)
    assert [math.degrees(angle) for angle in attitude.angles] == pytest.approx([-1.47192, 0.43688, 5.11449], abs=1e-5)
    assert (attitude.counter, attitude.frame, attitude.usable) == (9, "ENU", True)
    attitude = decode(TIME_AND_ANGLES)
    assert attitude.time == 0x093A7CB7 / 1e4
    assert [math.degrees(angle) for angle in attitude.angles] == pytest.approx(
        [-0.78556, -0.38167, -174.88646], abs=1e-5
    )
    attitude = decode(RATES_AND_STATUS)
    assert (attitude.counter, attitude.time, attitude.status) == (0xDFC5, 0x00459DA0 / 1e4, 0x81)
    assert attitude.rates == struct.unpack(">3f", bytes.fromhex("BBAA5C803B8C5501BB813300"))
    assert not attitude.usable
    attitude = decode(QUATERNION)
    assert attitude.quaternion == struct.unpack(">4f", bytes.fromhex("3F7FFA66BB4034B83C49962D3B5A1F82"))
    assert sum(part * part for part in attitude.quaternion) == pytest.approx(1.0, abs=1e-6)
    assert (attitude.status, attitude.usable) == (3, True)


@pytest.mark.parametrize("other", OTHERS)
def test_other_messages_are_known_and_skipped(other):
    assert decode(other) is None


def test_commands_are_those_of_the_maker():
    assert xsens.go_to_config() == bytes.fromhex("FAFF3000D1")
    assert xsens.go_to_measurement() == bytes.fromhex("FAFF1000F1")
    wanted = ((0x1020, 0xFFFF), (0x1060, 0xFFFF), (0x2030, 100), (0xE020, 0xFFFF))
    assert xsens.set_output_configuration(wanted) == bytes.fromhex("FAFFC010 1020FFFF 1060FFFF 20300064 E020FFFF E3")


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("bits", "frame"), xsens.FRAMES.items())
@given(degrees=three, quaternion=four, rates=three, status=st.integers(0, 2**32 - 1))
def test_every_form_of_numbers_is_read_in_every_frame(form, bits, frame, degrees, quaternion, rates, status):
    content = message(
        (0x1020, b"\x12\x34"),
        (0x4020 | form, numbers((1.0, 2.0, 3.0), form)),
        (0x1060, struct.pack(">I", 54321)),
        (0x2010 | bits | form, numbers(quaternion, form)),
        (0x2030 | bits | form, numbers(degrees, form)),
        (0x8020 | form, numbers(rates, form)),
        (0xE020, struct.pack(">I", status)),
    )
    back = decode(content)
    step = FORMS[form]
    assert back.quaternion == pytest.approx(quaternion, abs=step)
    assert [math.degrees(angle) for angle in back.angles] == pytest.approx(degrees, rel=1e-7, abs=step + 1e-13)
    assert back.rates == pytest.approx(rates, rel=1e-7, abs=step)
    assert (back.counter, back.time, back.status, back.frame) == (0x1234, 5.4321, status, frame)
    assert back.usable == bool(status & 2)


@given(
    st.none() | three, four, st.none() | three, st.sampled_from([*FORMS]), st.integers(-1, 0xFFFF), st.integers(-1, 9)
)
def test_what_is_written_is_read(degrees, quaternion, rates, form, counter, status):
    unknown, step = Attitude(), FORMS[form]
    roll, pitch, yaw = map(math.radians, degrees) if degrees else unknown.angles
    sent = Attitude((roll, pitch, yaw), quaternion, rates or unknown.rates, "NWU", 1.5, counter, status)
    back = decode(encode(sent, form))
    assert back.quaternion == pytest.approx(quaternion, abs=step)
    assert back.angles == pytest.approx(sent.angles, rel=1e-7, abs=step + 1e-15, nan_ok=True)
    assert back.rates == pytest.approx(sent.rates, rel=1e-7, abs=step, nan_ok=True)
    assert back[3:] == sent[3:]


@pytest.mark.parametrize("number", [math.inf, -math.inf, math.nan, 3e38, 1e308])
def test_extreme_numbers_are_read(number):
    back = decode(message((0x2033, struct.pack(">3d", 0.0, number, 0.0))))
    assert math.degrees(back.angles[1]) == pytest.approx(number, nan_ok=True)
    assert back.usable == math.isfinite(number)


def test_the_least_fixed_numbers_are_read():
    assert decode(message((0x8021, b"\x80\0\0\0" * 3))).rates == (-2048.0,) * 3
    assert decode(message((0x8022, b"\0\0\0\0\x80\0" * 3))).rates == (-32768.0,) * 3
    assert decode(message((0x8022, b"\xff\xff\xff\xff\xff\xff" * 3))).rates == (-(2.0**-32),) * 3


def test_what_the_device_does_not_vouch_for_is_not_used():
    assert not decode(encode(ATTITUDE._replace(status=1))).usable
    assert decode(encode(ATTITUDE._replace(status=-1))).usable
    only = decode(message((0xE010, b"\x01")))
    assert (only.status, only.usable, only.frame) == (1, False, "")
    assert decode(message((0x2030, bytes(12)), (0xE010, b"\x02"))).usable


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "message of 0 bytes"),
        (b"\xfa\xff\x36\xff", "message of 4 bytes"),
        (COUNTER_AND_ANGLES[:-1], "message of 24 bytes"),
        (COUNTER_AND_ANGLES + b"\x00", "message of 26 bytes"),
        (message((0x2030, bytes(11))), "must be 3 numbers of 4"),
        (message((0x2010, bytes(12))), "must be 4 numbers of 4"),
        (message((0x2012, bytes(16))), "must be 4 numbers of 6"),
        (message((0x8023, bytes(12))), "must be 3 numbers of 8"),
        (message((0x1060, bytes(2))), "item 1060 of 2 bytes: must be 4"),
        (message((0x203C, bytes(12))), "item 203c with axes None"),
        (message((0x2010, bytes(16)), (0x2034, bytes(12))), "the same in all"),
        (xsens.command(0x36, b"\x20"), "longer than the data"),
        (xsens.command(0x36, b"\x40\x20"), "longer than the data"),
        (xsens.command(0x36, b"\x40\x20\x0c" + bytes(11)), "longer than the data"),
    ],
)
def test_what_is_malformed_says_why(content, why):
    with pytest.raises(SentenceError, match=why):
        decode(content)


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be a7"):
        decode(COUNTER_AND_ANGLES[:-1] + b"\xa8")


def test_a_message_of_the_extended_length_is_left_behind():
    decoder = xsens.messages()
    extended = b"\xfa\xff\x36\xff\x01\x00" + bytes(256)
    assert decoder.feed(extended + bytes((-sum(extended[1:]) & 0xFF,)) + QUATERNION) == [decode(QUATERNION)]
    assert decoder.counts == Counts(good=1, malformed=1)


@given(st.lists(st.binary(max_size=300) | st.sampled_from([QUATERNION, b"\xfa\xff", b"\xfa\xff\x36\xfe"])))
def test_any_bytes_do_no_harm(pieces):
    decoder = xsens.messages()
    for piece in pieces:
        decoder.feed(piece)
    assert decoder.feed(bytes(300) + QUATERNION)[-1:] == [decode(QUATERNION)]
