"""MicroStrain's packets: the maker's examples and recordings, a packet of the test's own, what is refused."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.wire.serial import microstrain
from firmware_py.wire.serial.checksums import fletcher
from firmware_py.wire.serial.microstrain import FILTER, SENSOR, Attitude, decode, encode
from firmware_py.wire.serial.stream import ChecksumError, SentenceError

# From the maker's SDK: an example, packets of its recording of a device, and what its C library writes.
SENSORS = bytes.fromhex(
    "7565804C0AD5000000055EE67CC00AD6000000014E434A000E043D9EE88D387FDB00BF7AAF030E05BB0C1E30BB572E68BBAA24AE"
    "0E07BC8AAC80BC72C50EBCC4E2C10E083EEE3D9FBD66DADDC0AFDEF59196"
)
COMPLEMENTARY = bytes.fromhex(
    "7565804C0AD500000041DA2916400AD600000000007A12000E043C896897BBD28544BF7C30F90E05BB4AA21F3A86A43ABB8F0313"
    "0E063D7AFFD63E919FE83E79FFD60E0CBCCC20783CB6C513BF95119D7AC2"
)
WRITTEN_FILTER = bytes.fromhex(
    "756582540AD500000002E90EDD0014033F000000BF0000003F0000003F000000000110053F000000BE80000040400000000110"
    "0E3E800000BF0000003E000000000108100002000100400E11411518010000000008FC0001D4E4"
)
WRITTEN_SENSORS = bytes.fromhex(
    "7565803C0ED3411518010000000008FC00030E053E800000BF0000003E000000120A3F000000BF0000003F0000003F000000"
    "0E0C3F000000BE800000404000006A3E"
)
FILTERED = bytes.fromhex("7565821A0AD500000041DDBC9D4010053BDEB6FF3C8EDC20BF93B59200014F07")
OTHERS = tuple(
    map(
        bytes.fromhex,
        (
            "7565800E0E063D7AFFD63E919FE83E79FFD6EAC9",
            "75650104 04F10600DA74",
            "7565A0140AD5000000458D71D12B0AD60000000E5BD1D774115A",
        ),
    )
)

ATTITUDE = Attitude((0.5, -0.25, 3.0), (0.5, -0.5, 0.5, 0.5), (0.25, -0.5, 0.125), 12.5, math.nan, True, 2, 0)
three = st.tuples(*[st.floats(-1e6, 1e6, width=32)] * 3)
four = st.tuples(*[st.floats(-1.0, 1.0, width=32)] * 4)


def packet(descriptor_set: int, *fields: bytes) -> bytes:
    payload = b"".join([bytes((len(field) + 1,)) + field for field in fields])
    head = b"ue" + bytes((descriptor_set, len(payload))) + payload
    first = second = 0
    for byte in head:
        first = (first + byte) % 256
        second = (second + first) % 256
    return head + bytes((first, second))


def test_the_checksum_is_that_of_the_makers_algorithm():
    assert fletcher(b"123456789") == bytes((477 % 256, 2325 % 256))
    assert fletcher(FILTERED[:-2]) == FILTERED[-2:]


def test_packets_of_the_maker_are_read():
    sensors = decode(SENSORS)
    assert sensors.time == 23.067
    assert sensors.rates == pytest.approx((-0.002138, -0.003283, -0.005192), abs=0.5e-6)  # as the SDK prints them
    assert math.isnan(sensors.angles[0] + sensors.quaternion[0])
    assert (sensors.filtered, sensors.usable) == (False, False)
    complementary = decode(COMPLEMENTARY)
    assert complementary.angles == struct.unpack(">3f", bytes.fromhex("BCCC20783CB6C513BF95119D"))
    assert complementary.usable
    filtered = decode(FILTERED)
    assert filtered.angles == struct.unpack(">3f", bytes.fromhex("3BDEB6FF3C8EDC20BF93B592"))
    assert (filtered.time, filtered.filtered, filtered.usable, filtered.state) == (282.893, True, True, -1)


def test_what_the_makers_library_writes_is_read():
    expected = ATTITUDE._replace(week_time=345600.25, flags=0x40)
    assert decode(WRITTEN_FILTER) == expected
    assert decode(WRITTEN_SENSORS) == expected._replace(time=math.nan, state=-1, flags=-1, filtered=False)


@pytest.mark.parametrize("other", OTHERS)
def test_other_packets_are_known_and_skipped(other):
    assert decode(other) is None


def test_commands_are_those_of_the_maker():
    assert microstrain.idle() == bytes.fromhex("756501020202E1C7")
    assert microstrain.resume() == bytes.fromhex("756501020206E5CB")
    assert microstrain.message_format(SENSOR, {0xD5: 10, 0x04: 10, 0x05: 10}) == bytes.fromhex(
        "75650C0E0E0F018003D5000A04000A05000A91CE"
    )
    assert microstrain.message_format(SENSOR, {0x04: 1, 0x05: 1}, old=True) == bytes.fromhex(
        "75650C0A0A0801020400010500011073"
    )
    assert microstrain.message_format(FILTER, {0x05: 1, 0x0D: 1}, old=True) == bytes.fromhex(
        "75650C0A0A0A0102050001 0D00011BA3"
    )
    # Both in one packet is what the maker's manual shows.
    fields = [microstrain.enable_stream(kind, old=True)[5:-2] for kind in (SENSOR, FILTER)]
    assert packet(0x0C, *fields) == bytes.fromhex("75650C0A051101010105110103 0124CC")
    assert microstrain.enable_stream(FILTER) == packet(0x0C, b"\x11\x01\x82\x01")
    assert microstrain.enable_stream(SENSOR, on=False) == packet(0x0C, b"\x11\x01\x80\x00")


@given(three, four, three, st.integers(0, 2**53), st.integers(0, 9), st.integers(0, 0xFFFF), st.booleans())
def test_every_field_of_the_filter_is_read(angles, quaternion, rates, time, state, flags, valid):
    content = packet(
        FILTER,
        b"\xd6" + bytes(8),
        b"\xd5" + struct.pack(">Q", time),
        b"\x03" + struct.pack(">4fH", *quaternion, 1),
        b"\x05" + struct.pack(">3fH", *angles, valid),
        b"\x0e" + struct.pack(">3fH", *rates, 1),
        b"\x10" + struct.pack(">3H", state, 3, flags),
        b"\x11" + struct.pack(">dHH", 345600.25, 2300, 1),
    )
    expected = Attitude(angles, quaternion, rates, time / 1e9, 345600.25, valid, state, flags, True)
    assert decode(content) == expected
    assert expected.usable == (valid and state > 2)


@given(three, four, three)
def test_every_field_of_the_sensors_is_read(angles, quaternion, rates):
    content = packet(
        SENSOR,
        b"\x05" + struct.pack(">3f", *rates),
        b"\x0a" + struct.pack(">4f", *quaternion),
        b"\x0c" + struct.pack(">3f", *angles),
        b"\x12" + struct.pack(">dHH", 1.5, 0, 0),
    )
    expected = Attitude(angles, quaternion, rates, week_time=1.5, filtered=False)
    assert decode(content) == expected
    assert expected.usable


@given(
    st.none() | three,
    st.none() | four,
    three,
    st.none() | st.integers(0, 2**62),
    st.booleans(),
    st.none() | st.tuples(st.integers(0, 9), st.integers(0, 0xFFFF)),
)
def test_what_is_written_is_read(angles, quaternion, rates, time, filtered, status):
    unknown = Attitude()
    sent = Attitude(
        angles or unknown.angles,
        quaternion or unknown.quaternion,
        rates,
        math.nan if time is None else time / 1e9,
        state=status[0] if status and filtered else -1,
        flags=status[1] if status and filtered else -1,
        filtered=filtered,
    )
    back = decode(encode(sent))
    assert back._replace(time=0.0) == sent._replace(time=0.0)
    assert back.time == pytest.approx(sent.time, rel=1e-14, nan_ok=True)


@pytest.mark.parametrize(("state", "usable"), [(-1, True), (0, False), (1, False), (2, False), (3, True), (4, True)])
def test_the_filter_of_a_newer_family_is_used_once_it_knows_its_heading(state, usable):
    assert decode(encode(ATTITUDE._replace(state=state))).usable == usable


@pytest.mark.parametrize(("state", "usable"), [(0, False), (1, False), (2, True), (3, False), (4, False)])
def test_the_filter_of_an_older_family_is_used_while_it_calls_its_solution_valid(state, usable):
    """It knows the GPS time stamp of its own set alone, and no reference time."""
    told = packet(
        FILTER,
        b"\x11" + struct.pack(">dHH", 345600.25, 2300, 1),
        b"\x05" + struct.pack(">3fH", 0.5, -0.25, 3.0, 1),
        b"\x10" + struct.pack(">3H", state, 1, 0),
    )
    assert decode(told).usable == usable


def test_what_the_device_does_not_vouch_for_is_not_used():
    back = decode(encode(ATTITUDE._replace(valid=False)))
    assert (back.valid, back.usable) == (False, False)
    assert back.angles == ATTITUDE.angles
    one = packet(
        FILTER, b"\x05" + struct.pack(">3fH", 0.0, 0.0, 0.0, 1), b"\x0e" + struct.pack(">3fH", 0.0, 0.0, 0.0, 0)
    )
    assert not decode(one).usable


@pytest.mark.parametrize("number", [math.inf, -math.inf, math.nan, 3e38])
def test_extreme_numbers_are_read(number):
    back = decode(packet(SENSOR, b"\x0c" + struct.pack(">3f", 0.0, number, 0.0)))
    assert back.angles[1] == pytest.approx(number, nan_ok=True)
    assert back.usable == math.isfinite(number)


def test_a_packet_of_status_alone_is_read():
    back = decode(packet(FILTER, b"\x10" + struct.pack(">3H", 1, 1, 0x1000)))
    assert (back.state, back.flags, back.usable) == (1, 0x1000, False)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "packet of 0 bytes"),
        (FILTERED[:-1], "packet of 31 bytes"),
        (FILTERED + b"\x00", "packet of 33 bytes"),
        (b"eu" + FILTERED[2:], "must be 75 65"),
        (packet(FILTER, b"\x05" + bytes(12)), "angles of 12 bytes: must be 14"),
        (packet(SENSOR, b"\x05" + bytes(14)), "rates of 14 bytes: must be 12"),
        (packet(FILTER, b"\x03"), "quaternion of 0 bytes"),
        (packet(FILTER, b""), "field of 1 bytes"),
        (microstrain.packet(FILTER, (0x20, bytes(4)))[:4], "packet of 4 bytes"),
    ],
)
def test_what_is_malformed_says_why(content, why):
    with pytest.raises(SentenceError, match=why):
        decode(content)


@pytest.mark.parametrize("length", [0, 1, 7, 255])
def test_a_field_that_does_not_fit_is_refused(length):
    head = bytes((0x75, 0x65, FILTER, 6, length, 0x20, 0, 0, 0, 0))
    with pytest.raises(SentenceError, match=f"field of {length} bytes"):
        decode(head + fletcher(head))


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 4f07"):
        decode(FILTERED[:-1] + b"\x08")


@given(st.lists(st.binary(max_size=300) | st.sampled_from([SENSORS, FILTERED, b"ue", b"ue\x82\xff"])))
def test_any_bytes_do_no_harm(pieces):
    decoder = microstrain.packets()
    for piece in pieces:
        decoder.feed(piece)
    assert decoder.feed(bytes(300) + FILTERED)[-1:] == [decode(FILTERED)]
