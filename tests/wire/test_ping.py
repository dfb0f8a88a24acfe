"""Ping packets: the maker's layout, judged by its own library in both directions."""

from __future__ import annotations

import math
import random
import struct

import pytest
from brping import definitions
from brping.pingmessage import PingMessage, PingParser
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import ping
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

U32 = st.integers(0, 2**32 - 1)
ECHO = ping.Distance(12.345, 0.97, 450e-6, 77, 0.5, 30.0, 3)
# "BR", 2 bytes of payload, general request (6) from 0 to 0 for message 1211 (0x04BB): the sum is 0x015B.
REQUEST = bytes.fromhex("4252 0200 0600 00 00 bb04 5b01")


def parsed(content: bytes) -> PingMessage:
    """Return what the judge reads of one packet."""
    parser = PingParser()
    for byte in content[:-1]:
        assert parser.parse_byte(byte) not in (PingParser.NEW_MESSAGE, PingParser.ERROR)
    assert parser.parse_byte(content[-1]) == PingParser.NEW_MESSAGE
    return parser.rx_msg


def judged(message_id: int, source: int = 1, **fields: object) -> bytes:
    """Return the judge's packet."""
    message = PingMessage(message_id)
    message.src_device_id = source
    for name, value in fields.items():
        setattr(message, name, value)
    return bytes(message.pack_msg_data())


def test_a_request_has_the_documented_bytes() -> None:
    assert ping.request(ping.DISTANCE_SIMPLE) == REQUEST


@given(U32, st.integers(0, 100), st.integers(0, 65535), U32, U32, U32, st.integers(0, 6))
def test_a_distance_of_the_judge_is_read_and_ours_is_the_same(
    distance: int, confidence: int, duration: int, number: int, start: int, length: int, gain: int
) -> None:
    theirs = judged(
        definitions.PING1D_DISTANCE,
        distance=distance,
        confidence=confidence,
        transmit_duration=duration,
        ping_number=number,
        scan_start=start,
        scan_length=length,
        gain_setting=gain,
    )
    echo = ping.decode(theirs)
    assert isinstance(echo, ping.Distance)
    numbers = (distance * 1e-3, confidence * 0.01, duration * 1e-6, number, start * 1e-3, length * 1e-3, gain)
    assert echo == pytest.approx(numbers)
    assert echo.gain == ping.GAINS[gain]
    assert echo.usable == (confidence > 0 and distance > 0)
    assert ping.encode(echo) == theirs
    assert parsed(ping.encode(echo)).distance == distance


@given(U32, st.integers(0, 100))
def test_a_simple_distance_has_no_more_than_it_says(distance: int, confidence: int) -> None:
    # The judge has kept the old name of this message.
    theirs = judged(definitions.PING1D_DISTANCE_SIMPLE, **dict(zip(SIMPLE_FIELDS, (distance, confidence), strict=True)))
    echo = ping.decode(theirs)
    assert isinstance(echo, ping.Distance)
    assert echo[:2] == pytest.approx((distance * 1e-3, confidence * 0.01))
    assert math.isnan(echo.gain + echo.scan_start + echo.scan_length + echo.transmit_duration)
    assert ping.encode(echo) == theirs


SIMPLE_FIELDS = definitions.payload_dict_all[1211]["field_names"]


@given(
    st.floats(0.0, 4e6),
    st.floats(0.0, 1.0),
    st.floats(0.0, 0.065),
    st.floats(0.0, 4e6),
)
def test_what_is_written_is_read_to_the_devices_precision(
    distance: float, confidence: float, duration: float, length: float
) -> None:
    echo = ping.Distance(distance, confidence, duration, 5, 0.0, length, 2)
    back = ping.decode(ping.encode(echo))
    assert isinstance(back, ping.Distance)
    assert back.distance == pytest.approx(distance, abs=0.501e-3)
    assert back.confidence == pytest.approx(confidence, abs=0.00501)
    assert back.transmit_duration == pytest.approx(duration, abs=0.501e-6)
    assert back.scan_length == pytest.approx(length, abs=0.501e-3)


def test_the_judge_reads_our_commands() -> None:
    source = random.Random(3)
    for _ in range(300):
        u16, u32, device = source.randrange(65536), source.randrange(2**32), source.randrange(256)
        asked = parsed(ping.request(u16, device))
        assert (asked.message_id, asked.requested_id, asked.dst_device_id, asked.src_device_id) == (6, u16, device, 0)
        assert parsed(ping.continuous_start(u16)).id == parsed(ping.continuous_stop(u16)).id == u16
        assert parsed(ping.set_ping_interval(u16 * 1e-3)).ping_interval == u16
        assert parsed(ping.set_speed_of_sound(u32 * 1e-3)).sos_mm_per_sec == u32
        span = parsed(ping.set_range(u32 * 1e-3, u16 * 1e-3))
        assert (span.scan_start, span.scan_length) == (u32, u16)
    assert parsed(ping.continuous_start()).message_id == definitions.PING1D_CONTINUOUS_START
    assert parsed(ping.set_mode_auto(True)).mode_auto == 1
    assert parsed(ping.set_mode_auto(False)).message_id == definitions.PING1D_SET_MODE_AUTO


def test_acks_and_nacks_are_read() -> None:
    assert ping.decode(judged(definitions.COMMON_ACK, acked_id=1004)) == ping.Ack(1004)
    refused = b"\xec\x03no such interval\0"  # the judge reads nacks, but cannot write one
    assert ping.decode(ping.packet(ping.NACK, refused, source=1)) == ping.Nack(1004, "no such interval")
    assert ping.decode(ping.packet(ping.NACK, refused[:2])) == ping.Nack(1004, "")
    nack = parsed(ping.encode(ping.Nack(1004, "why")))
    assert (nack.nacked_id, nack.nack_message) == (1004, b"why")
    assert parsed(ping.encode(ping.Ack(1004))).acked_id == 1004
    for message in (ping.Ack(1004), ping.Nack(1002, "why")):
        assert ping.decode(ping.encode(message)) == message


def test_other_messages_are_known_and_skipped() -> None:
    assert ping.decode(judged(definitions.COMMON_PROTOCOL_VERSION, version_major=1)) is None


def test_a_profile_is_too_long_and_left_behind() -> None:
    content = judged(
        definitions.PING1D_PROFILE, distance=1000, profile_data_length=200, profile_data=bytearray(range(200))
    )
    decoder = ping.packets()
    assert decoder.feed(content + ping.encode(ECHO)) == [ECHO]
    assert (decoder.counts.too_long, decoder.counts.good) == (1, 1)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (ping.packet(ping.DISTANCE, bytes(23)), "23 bytes: must be 24"),
        (ping.packet(ping.DISTANCE, bytes(25)), "25 bytes: must be 24"),
        (ping.packet(ping.DISTANCE_SIMPLE, bytes(4)), "4 bytes: must be 5"),
        (ping.packet(ping.DISTANCE_SIMPLE, struct.pack("<IB", 1, 101)), "101 %: must be at most 100"),
        (ping.packet(ping.DISTANCE, struct.pack("<IHHIIII", 1, 1000, 0, 0, 0, 0, 0)), "1000 %"),
        (ping.packet(ping.ACK, b"\0"), "1 bytes: must be 2"),
        (ping.packet(ping.NACK, b""), "0 bytes: must be 2"),
        (REQUEST + b"\0", "13 bytes: must be 12"),
        (b"BR", "at least 10 bytes"),
        (b"XX" + bytes(10), "must be BR"),
    ],
)
def test_a_malformed_packet_says_why(content: bytes, why: str) -> None:
    with pytest.raises(SentenceError, match=why):
        ping.decode(content)


def test_a_bad_checksum_says_what_would_be_right() -> None:
    with pytest.raises(ChecksumError, match="must be 347"):
        ping.decode(REQUEST[:-1] + b"\0")


def test_an_echo_without_confidence_is_not_used() -> None:
    assert ECHO.usable
    assert not ECHO._replace(confidence=0.0).usable
    assert not ECHO._replace(distance=0.0).usable
    assert math.isnan(ECHO._replace(gain_setting=7).gain)


@pytest.mark.parametrize(
    "order",
    [
        lambda: ping.set_ping_interval(66.0),
        lambda: ping.set_ping_interval(-0.1),
        lambda: ping.set_speed_of_sound(math.nan),
        lambda: ping.request(1 << 16),
        lambda: ping.request(1, destination=256),
        lambda: ping.encode(ECHO._replace(distance=-0.01)),
        lambda: ping.encode(ECHO._replace(scan_length=math.nan)),
    ],
)
def test_what_does_not_fit_is_refused(order: object) -> None:
    with pytest.raises(ValueError, match=r"does not fit|too large|cannot convert"):
        order()  # type: ignore[operator]
