"""Packets of u-blox receivers: pyubx2 reads what we write and writes what we read."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyubx2 import GET, SET, UBX_MSGIDS, UBXMessage, UBXReader

from firmware_py.wire.serial import ubx, ubx_config
from firmware_py.wire.serial.stream import ChecksumError, SentenceError
from firmware_py.wire.serial.ubx import Ack, NavPvt, decode, encode

FIX = NavPvt(
    *(200.0, (2026, 11, 23), (8, 30, 15), 7, 2e-8, -250_000_000, 3, 1, 12, -0.1, 0.8, 50.0, 2.0, 1.5, 2.5),
    *((0.5, -0.25, 0.125), 0.56, 5.8, 0.05, 0.02, 1.25),
)
DEGREE = math.pi / 180.0

signed = st.integers(-(2**31), 2**31 - 1)
unsigned = st.integers(0, 2**32 - 1)
small = st.integers(0, 255)


def near(value, tolerance):
    return pytest.approx(value, abs=tolerance)


@given(
    latitude=st.floats(-math.pi / 2, math.pi / 2),
    longitude=st.floats(-math.pi, math.pi),
    heights=st.tuples(*[st.floats(-1e5, 1e5)] * 2),
    accuracies=st.tuples(*[st.floats(0.0, 4e6)] * 3),
    velocity=st.tuples(*[st.floats(-500.0, 500.0)] * 3),
    course=st.floats(0.0, 6.283),
    pdop=st.floats(0.0, 99.99),
    flags=st.integers(0, 3),
    fix=st.integers(0, 5),
    invalid=st.booleans(),
)
def test_a_judge_reads_what_we_write(
    latitude, longitude, heights, accuracies, velocity, course, pdop, flags, fix, invalid
):
    ours = FIX._replace(latitude=latitude, longitude=longitude, height=heights[0], altitude=heights[1], fix=fix)
    ours = ours._replace(horizontal_accuracy=accuracies[0], vertical_accuracy=accuracies[1], flags=flags)
    ours = ours._replace(speed_accuracy=accuracies[2], velocity=velocity, speed=abs(velocity[0]), course=course)
    m = UBXReader.parse(encode(ours._replace(pdop=pdop, invalid_position=invalid)))
    assert m.identity == "NAV-PVT"
    assert (m.lat * DEGREE, m.lon * DEGREE) == (near(latitude, 1e-9), near(longitude, 1e-9))
    assert [m.height, m.hMSL] == near([1e3 * h for h in heights], 0.51)
    assert [m.hAcc, m.vAcc, m.sAcc] == near([1e3 * a for a in accuracies], 0.51)
    assert [m.velN, m.velE, m.velD, m.gSpeed] == near([1e3 * v for v in (*velocity, abs(velocity[0]))], 0.51)
    assert (m.headMot * DEGREE, m.pDOP) == (near(course, 1e-7), near(pdop, 0.0051))
    assert (m.gnssFixOk, m.diffSoln, m.fixType, m.invalidLlh) == (flags & 1, flags >> 1, fix, invalid)
    assert (m.year, m.month, m.day, m.hour, m.min, m.second, m.nano) == (2026, 11, 23, 8, 30, 15, -250_000_000)
    assert (m.validDate, m.validTime, m.fullyResolved, m.validMag, m.numSV, m.tAcc) == (1, 1, 1, 0, 12, 20)
    assert m.iTOW == 200_000


@given(
    *(st.integers(0, 604_799_999), signed, signed, signed, signed, st.tuples(*[unsigned] * 2)),
    *(st.tuples(*[signed] * 4), st.integers(0, 35_999_999), small, st.booleans(), st.integers(0, 65535)),
)
def test_we_read_what_a_judge_writes(
    tow, longitude, latitude, height, altitude, accuracy, speeds, course, sats, ok, dop
):
    place = {"lon": longitude * 1e-7, "lat": latitude * 1e-7, "height": height, "hMSL": altitude}
    errors = {"hAcc": accuracy[0], "vAcc": accuracy[1], "sAcc": accuracy[0], "headAcc": accuracy[1] * 1e-5}
    motion = {"velN": speeds[0], "velE": speeds[1], "velD": speeds[2], "gSpeed": speeds[3], "headMot": course * 1e-5}
    time = {"year": 2026, "month": 2, "day": 28, "hour": 23, "min": 59, "second": 60, "validDate": 1, "validTime": 1}
    state = {"fixType": 3, "gnssFixOk": int(ok), "numSV": sats, "pDOP": dop * 0.01, "invalidLlh": int(not ok)}
    message = UBXMessage("NAV", "NAV-PVT", GET, iTOW=tow, tAcc=7, nano=-5, **place, **errors, **motion, **time, **state)
    m = decode(message.serialize())
    assert m.time_of_week == near(tow * 1e-3, 1e-9)
    assert (m.date, m.time, m.valid, m.nano) == ((2026, 2, 28), (23, 59, 60), 3, -5)
    assert m.time_of_day == near(86400.0, 1e-6)
    assert [m.longitude, m.latitude] == near([longitude * 1e-7 * DEGREE, latitude * 1e-7 * DEGREE], 2e-9)
    assert [m.height, m.altitude] == near([height * 1e-3, altitude * 1e-3], 1e-6)
    assert [m.horizontal_accuracy, m.vertical_accuracy] == near([a * 1e-3 for a in accuracy], 1e-6)
    assert [m.speed_accuracy, m.course_accuracy] == near([accuracy[0] * 1e-3, accuracy[1] * 1e-5 * DEGREE], 1e-6)
    assert [*m.velocity, m.speed] == near([v * 1e-3 for v in speeds], 1e-6)
    assert m.course == near(course * 1e-5 * DEGREE, 1e-6)
    assert (m.pdop, m.time_accuracy) == (near(dop * 0.01, 0.011), near(7e-9, 1e-15))
    assert (m.satellites, m.usable, m.invalid_position) == (sats, ok, not ok)


def test_what_is_written_is_read():
    back = decode(encode(FIX))
    assert back.usable
    assert back.time_of_day == near(8 * 3600 + 30 * 60 + 14.75, 1e-9)
    for name, value in back._asdict().items():
        assert value == pytest.approx(getattr(FIX, name), rel=1e-6, abs=1e-7), name


@pytest.mark.parametrize("taken", [True, False])
def test_answers_are_judged_both_ways(taken):
    kind = "ACK-ACK" if taken else "ACK-NAK"
    theirs = UBXMessage("ACK", kind, GET, clsID=6, msgID=0x8A).serialize()
    assert decode(theirs) == Ack(taken, ubx.CFG_VALSET)
    assert encode(Ack(taken, ubx.CFG_VALSET)) == theirs


def test_older_receivers_send_fewer_bytes():
    payload = encode(FIX)[6:90]
    older = decode(ubx.packet(ubx.NAV_PVT, payload[:78] + b"\xff" * 6))
    assert older == decode(encode(FIX))


@pytest.mark.parametrize(
    "changed",
    [{"fix": 0}, {"fix": 1}, {"fix": 5}, {"flags": 0}, {"flags": 2}, {"invalid_position": True}],
)
def test_what_the_receiver_does_not_vouch_for_is_not_used(changed):
    assert not decode(encode(FIX._replace(**changed))).usable


@pytest.mark.parametrize("valid", [0, 1, 2, 4, 8, 12])
def test_a_time_that_is_not_valid_is_unknown(valid):
    assert math.isnan(decode(encode(FIX._replace(valid=valid))).time_of_day)


@pytest.mark.parametrize(
    ("whole", "why"),
    [
        (b"", "not a packet"),
        (b"\xb5\x62\x01\x07\x00\x00\x08", "not a packet"),
        (b"\xb5\x63\x01\x07\x00\x00\x08\x19", "not a packet"),
        (b"\xb5\x62\x01\x07\x01\x00\x08\x19", "not a packet"),
        (ubx.packet(ubx.NAV_PVT, b""), "NAV-PVT with 0 bytes"),
        (ubx.packet(ubx.NAV_PVT, bytes(91)), "NAV-PVT with 91 bytes"),
        (ubx.packet(ubx.ACK_ACK, bytes(3)), "ACK with 3 bytes"),
    ],
)
def test_a_malformed_packet_says_why(whole, why):
    with pytest.raises(SentenceError, match=why):
        decode(whole)


def test_a_bad_checksum_says_what_would_be_right():
    with pytest.raises(ChecksumError, match="must be 0819"):
        decode(b"\xb5\x62\x01\x07\x00\x00\x08\x18")


@given(st.binary(max_size=92))
def test_packets_of_other_kinds_are_known_and_skipped(payload):
    assert decode(ubx.packet(b"\x01\x35", payload)) is None


@given(st.lists(st.floats(), min_size=14, max_size=14))
def test_extreme_numbers_become_the_nearest_that_can_be_sent(numbers):
    names = [name for name, value in FIX._asdict().items() if isinstance(value, float)]
    extreme = FIX._replace(**dict(zip(names, numbers, strict=False)), velocity=(*numbers[:2], math.nan))
    back = decode(encode(extreme))
    assert all(math.isfinite(getattr(back, name)) for name in names)
    assert back.velocity[2] == near(2147483.647, 1e-3)


def test_packets_that_are_too_long_are_passed_over():
    decoder = ubx.packets()
    assert decoder.feed(ubx.packet(b"\x01\x35", bytes(300)) + encode(FIX)) == [decode(encode(FIX))]
    assert (decoder.counts.too_long, decoder.counts.good) == (1, 1)


@pytest.mark.parametrize("port", ubx_config.PVT_ON)
@pytest.mark.parametrize("nmea", [True, False])
def test_a_judge_reads_how_a_port_is_switched_on(port, nmea):
    message = UBXReader.parse(ubx_config.switch_on(5.0, port, nmea), msgmode=SET)
    assert (message.identity, message.version, message.ram, message.bbr, message.flash) == ("CFG-VALSET", 0, 1, 0, 0)
    assert (message.CFG_RATE_MEAS, message.CFG_RATE_NAV) == (200, 1)
    name = port.upper()
    assert getattr(message, f"CFG_MSGOUT_UBX_NAV_PVT_{name}") == 1
    assert getattr(message, f"CFG_{name}OUTPROT_UBX") == 1
    assert getattr(message, f"CFG_{name}OUTPROT_NMEA") == nmea


def test_a_judge_sets_the_same_values():
    values = {"CFG_RATE_MEAS": 100, "CFG_NAVSPG_DYNMODEL": 5, "CFG_UART1_BAUDRATE": 115200}
    theirs = UBXMessage.config_set(1, 0, [*values.items()]).serialize()
    keys = {ubx_config.RATE_MEAS: 100, ubx_config.DYNAMIC_MODEL: ubx_config.SEA, 0x4052_0001: 115200}
    assert ubx_config.set_values(keys) == theirs
    assert ubx_config.set_values({0x5018_0001: 1})[10:-2].hex() == "010018500100000000000000"


def test_older_receivers_are_switched_on_by_the_packets_of_the_description():
    rate = bytes.fromhex("b562060806 00c80001000100de6a")
    message = bytes.fromhex("b562060103000107011351")
    assert ubx_config.switch_on_older(5.0) == rate + message
    assert UBXReader.parse(rate, msgmode=SET).measRate == 200


def test_older_receivers_are_told_in_words_of_a_judge_to_send_no_sentences():
    packets = ubx_config.sentences_off_older()
    each = [packets[k : k + 11] for k in range(0, len(packets), 11)]
    assert [UBXReader.parse(one, msgmode=SET).identity for one in each] == ["CFG-MSG"] * 6
    assert [UBX_MSGIDS[one[6:8]] for one in each] == ["GGA", "GLL", "GSA", "GSV", "RMC", "VTG"]
    assert [one[8] for one in each] == [0] * 6


def test_what_cannot_be_asked_for_is_refused():
    for rate in (0.0, -1.0, 26.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="must be from"):
            ubx_config.switch_on(rate)
    with pytest.raises(ValueError, match="at most 64"):
        ubx_config.set_values({0x2091_0000 + k: 1 for k in range(65)})
    with pytest.raises(ValueError, match="first digit"):
        ubx_config.set_values({0x6091_0000: 1})
    with pytest.raises(OverflowError):
        ubx_config.set_values({ubx_config.RATE_MEAS: 65536})
