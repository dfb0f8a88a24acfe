"""VectorNav's sentences and packets: the maker's examples, an encoder of the test's own, what is refused."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import vectornav_commands as commands
from firmware_py.wire.serial.stream import ChecksumError, Counts, SentenceError
from firmware_py.wire.serial.vectornav import Attitude, decode, encode, encode_line, messages
from firmware_py.wire.serial.vectornav_layout import layout_of

# Examples of the maker's manual and of its library for C.
YMR = (
    b"$VNYMR,+100.949,-007.330,+000.715,-00.0049,-00.2449,+00.5397,-01.258,-00.100,-09.701,"
    b"-00.000018,+00.001122,-00.000551*69"
)
YPR = b"$VNYPR,+010.071,+000.278,-002.026*60"
WITH_COUNTER = b"$VNYPR,+010.071,+000.278,-002.026,T1162704*2F"
WITH_STATUS = b"$VNYPR,+010.071,+000.278,-002.026,S0000*1F"
COMMON = bytes.fromhex("FA01080093502E42833EF13F48B504BB9288")
WITH_TIME = bytes.fromhex("FA010900700500030A000000480E2C42084C37C110388BC2D4CB")
OTHERS = (b"$VNRRG,01,VN-200T-CR*31", b"$VNWRG,07,2*6F", b"$VNERR,12*72", b"$VNKMD,1*47")
# Recorded from devices.
QMR = (
    b"$VNQMR,+0.021375,-0.049923,+0.797361,-0.601055,-0.2354,+0.8029,+1.8875,+00.795,-00.412,-09.709,"
    b"-00.0201,-00.0055,-00.0149*76"
)
QMR_WITH_COUNTER = (
    b"$VNQMR,+0.004183,+0.001149,+0.089285,+0.995997,+00.0113,-00.2384,+00.1800,+00.020,-00.092,-09.683,"
    b"-00.000272,+00.000824,+00.000073,T0000000543*3D"
)

ATTITUDE = Attitude((0.1, -0.2, 3.0), (0.5, -0.5, 0.5, 0.5), (0.25, -0.5, 0.125), 1234.5, 0)
angles = st.tuples(st.floats(-math.pi, math.pi), st.floats(-1.57, 1.57), st.floats(-math.pi, math.pi))
quaternions = st.tuples(*[st.floats(-1.0, 1.0)] * 4)
rates = st.tuples(*[st.floats(-40.0, 40.0)] * 3)


def crc_of_the_test(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (0x1021 if crc & 0x8000 else 0)) & 0xFFFF
    return crc


def packet(groups: int, words: list[int], content: bytes) -> bytes:
    body = bytes((groups,)) + b"".join(struct.pack("<H", word) for word in words) + content
    return b"\xfa" + body + struct.pack(">H", crc_of_the_test(body))


def line(body: str, width: int = 2) -> bytes:
    value = 0
    for character in body:
        value ^= ord(character)
    return f"${body}*{value if width == 2 else crc_of_the_test(body.encode()):0{width}x}\r\n".encode()


def test_crc_has_the_catalogued_check_value():
    assert commands.crc16(b"123456789") == crc_of_the_test(b"123456789") == 0x31C3


def test_the_sentences_of_the_maker_are_read():
    attitude = decode(YMR)
    assert [math.degrees(angle) for angle in attitude.angles] == pytest.approx([0.715, -7.33, 100.949])
    assert attitude.rates == (-0.000018, 0.001122, -0.000551)
    assert (attitude.status, attitude.usable) == (-1, True)
    assert math.isnan(attitude.time + attitude.quaternion[0])
    for sentence, status in ((YPR, -1), (WITH_COUNTER, -1), (WITH_STATUS, 0)):
        attitude = decode(sentence + b"\r\n")
        assert [math.degrees(angle) for angle in attitude.angles] == pytest.approx([-2.026, 0.278, 10.071])
        assert attitude.status == status
        assert math.isnan(attitude.rates[0])


def test_a_recorded_quaternion_has_its_scalar_last():
    assert decode(QMR).quaternion == (-0.601055, 0.021375, -0.049923, 0.797361)
    assert decode(QMR).rates == (-0.0201, -0.0055, -0.0149)
    assert decode(QMR_WITH_COUNTER).quaternion == (0.995997, 0.004183, 0.001149, 0.089285)


def test_the_packets_of_the_maker_are_read():
    attitude = decode(COMMON)
    assert [math.degrees(angle) for angle in attitude.angles] == pytest.approx(
        [-2.0249654e-3, 1.8847202, 43.578686], rel=1e-6
    )
    attitude = decode(WITH_TIME)
    assert attitude.time == 0x0A03000570 / 1e9
    degrees = struct.unpack("<3f", WITH_TIME[12:24])[::-1]
    assert attitude.angles == tuple(map(math.radians, degrees))


@pytest.mark.parametrize("sentence", OTHERS)
def test_other_sentences_are_known_and_skipped(sentence):
    assert decode(sentence) is None


def test_commands_are_those_of_the_maker():
    assert commands.command("VNKMD,1") == b"$VNKMD,1*47\r\n"
    assert commands.set_output_rate(2) == b"$VNWRG,07,2*6F\r\n"
    assert commands.set_output("VNYMR") == line("VNWRG,06,14")[:-4] + b"59\r\n"
    assert commands.write_settings() == b"$VNWNV*57\r\n"
    assert commands.set_binary_output(16) == line("VNWRG,75,1,16,11,0039,0001").upper()
    assert commands.set_binary_output(4, 0x8, 0, port=2) == line("VNWRG,75,2,4,01,0008").upper()
    assert commands.command("VNWNV", crc=True) == line("VNWNV", 4).upper()


@given(angles, rates, st.integers(0, 0xFFFF), st.booleans())
def test_a_sentence_is_read_to_the_devices_precision(attitude, turn, status, crc):
    back = decode(encode_line(Attitude(attitude, rates=turn, status=status), crc=crc))
    assert back.angles == pytest.approx(attitude, abs=math.radians(0.00051))
    assert back.rates == pytest.approx(turn, abs=0.51e-6)
    assert back.status == status
    assert decode(encode_line(back, "VNYPR", crc)).angles == pytest.approx(attitude, abs=math.radians(0.00051))


@given(quaternions, rates)
def test_a_sentence_with_a_quaternion_is_read_to_the_devices_precision(quaternion, turn):
    back = decode(encode_line(Attitude(quaternion=quaternion, rates=turn), "VNQMR"))
    assert back.quaternion == pytest.approx(quaternion, abs=0.51e-6)
    assert back.rates == pytest.approx(turn, abs=0.51e-6)


@given(
    st.none() | angles,
    st.none() | quaternions,
    rates,
    st.none() | st.integers(0, 2**62),
    st.integers(-1, 0xFFFF),
)
def test_a_packet_is_read_to_the_devices_precision(attitude, quaternion, turn, time, status):
    """What is unknown is not sent, and read as unknown."""
    unknown = Attitude()
    sent = Attitude(
        attitude or unknown.angles,
        quaternion or unknown.quaternion,
        turn,
        math.nan if time is None else time / 1e9,
        status,
    )
    back = decode(encode(sent))
    assert back.angles == pytest.approx(sent.angles, rel=1e-6, abs=1e-30, nan_ok=True)
    assert back.quaternion == pytest.approx(sent.quaternion, rel=1e-6, abs=1e-30, nan_ok=True)
    assert back.rates == pytest.approx(turn, rel=1e-6, abs=1e-30)
    assert back.time == pytest.approx(sent.time, rel=1e-14, nan_ok=True)
    assert back.status == status


@given(rates, rates, quaternions, st.integers(0, 3))
def test_fields_are_found_between_those_of_all_other_groups(turn, degrees, quaternion, status):
    """Time in group 2, rates in group 3, status, angles and quaternion in group 5; fields around them are skipped."""
    content = (
        struct.pack("<Q", 5_000_000_000)
        + bytes(8)
        + bytes(2 + 12)
        + struct.pack("<3f", *turn)
        + struct.pack("<H", status)
        + struct.pack("<3f", *degrees)
        + struct.pack("<4f", *quaternion)
        + bytes(36)
    )
    back = decode(packet(0b10110, [0b11, 0b100_0000_0011, 0b1111], content))
    x, y, z, w = struct.unpack("<4f", struct.pack("<4f", *quaternion))
    assert back.quaternion == (w, x, y, z)
    assert back.rates == struct.unpack("<3f", struct.pack("<3f", *turn))
    assert back.angles == pytest.approx([math.radians(angle) for angle in degrees[::-1]], rel=1e-6, abs=1e-30)
    assert (back.time, back.status, back.quality) == (5.0, status, status)
    assert back.usable == (status < 2)


def test_a_packet_that_is_written_is_the_one_of_the_test():
    content = struct.pack("<Q3f4f3fH", 10**9, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 4.0, 5.0, 6.0, 0x1234)
    attitude = Attitude((0.0, 0.0, 0.0), (1.0, 0.25, 0.5, 0.75), (4.0, 5.0, 6.0), 1.0, 0x1234)
    assert encode(attitude) == packet(0x11, [0x39, 0x01], content)
    assert decode(encode(attitude)) == attitude


def test_lengths_of_fields_add_up():
    """Packets of a well-known autopilot, whose lengths are known: 170, 92 and 104 bytes."""
    assert layout_of(bytes.fromhex("34 2E07 0601 1206")).size == 170
    assert layout_of(bytes.fromhex("4E 0200 1000 B820 1800")).size == 92
    assert layout_of(bytes.fromhex("14 3E07 0400")).size == 104


@pytest.mark.parametrize("content", [(0x01, [0x01], bytes(8)), (0x01, [0x3000], bytes(6)), (0x08, [0x3], bytes(16))])
def test_packets_without_attitude_are_known_and_skipped(content):
    assert decode(packet(*content)) is None


@pytest.mark.parametrize(
    ("status", "usable"), [(0, True), (1, True), (2, False), (3, False), (4, False), (8, False), (0x1FF0, True)]
)
def test_what_the_device_does_not_vouch_for_is_not_used(status, usable):
    assert decode(encode(ATTITUDE._replace(status=status))).usable == usable
    assert decode(encode_line(ATTITUDE._replace(status=status))).usable == usable


@pytest.mark.parametrize("number", [math.inf, -math.inf, 3e38])
def test_extreme_numbers_are_read(number):
    back = decode(encode(ATTITUDE._replace(quaternion=(number,) * 4, angles=Attitude().angles)))
    assert back.quaternion == pytest.approx((number,) * 4)
    assert back.usable == math.isfinite(number)
    assert not Attitude(rates=(0.0, 0.0, 0.0)).usable


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (line("VNYPR,1,2"), "2 numbers"),
        (line("VNYPR,1,2,3,4"), "must be S or T"),
        (line("VNYPR,1,2,x"), "not a number"),
        (line("VNYPR,1,2,3,Sxyz"), "not a number"),
        (line("VNYMR,1,2,3"), "must be 12"),
        (b"$VNYPR,1,2,3\r\n", "not a sentence"),
        (b"$VNYPR,1,2,3*\r\n", "not a sentence"),
        (b"$VNYPR,1,2,3*123\r\n", "not a sentence"),
        (line("GPYPR,1,2,3"), "not a sentence"),
        (COMMON[:-1], "another length"),
        (COMMON + b"\x00", "another length"),
        (b"\xfa", "another length"),
        (b"\xfa\x81" + bytes(20), "another length"),
        (packet(0x02, [0x8001], bytes(8)), "another length"),
        (packet(0x02, [0x0800], bytes(8)), "another length"),
    ],
)
def test_what_is_malformed_says_why(content, why):
    with pytest.raises(SentenceError, match=why):
        decode(content)


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 60"):
        decode(YPR[:-2] + b"61")
    with pytest.raises(ChecksumError, match="must be 9288"):
        decode(COMMON[:-1] + b"\x89")


def test_answers_between_packets_are_counted_and_no_packet_is_lost():
    decoder = messages()
    stream = COMMON + OTHERS[1] + b"\r\n" + COMMON + YPR + b"\r\n" + WITH_TIME + OTHERS[2] + b"\n"
    assert len(decoder.feed(stream * 10)) == 40
    assert decoder.counts == Counts(good=40, other=20)


def test_a_line_that_does_not_end_holds_nothing_up_that_is_no_line():
    decoder = messages()
    assert decoder.feed(b"$VNYPR,+010.071" + COMMON) == [decode(COMMON)]
    assert decoder.feed(b"$VNYPR,+010.071" + YPR + b"\r\n") == [decode(YPR)]
    assert decoder.feed(b"$VNYPR," + b"1" * 300 + YPR + b"\r\n") == [decode(YPR)]
    assert decoder.counts == Counts(good=3, malformed=2, too_long=1)


@given(st.lists(st.binary(max_size=300) | st.sampled_from([COMMON, YMR, b"\xfa", b"$VN", b"\xfa\x01\x38\x00"])))
def test_any_bytes_do_no_harm(pieces):
    decoder = messages()
    for piece in pieces:
        decoder.feed(piece)
    assert decoder.feed(bytes(300) + YPR + b"\r\n")[-1:] == [decode(YPR)]
