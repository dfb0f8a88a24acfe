"""What single instruments do beside the contract: their other messages, axes, and what they are told."""

from __future__ import annotations

import itertools
import math
import struct

import pytest
from brping.pingmessage import PingMessage
from pynmeagps import GET, NMEAMessage
from pyubx2 import SET, UBXReader

from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.mounting import Mounting
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.drivers.talk import GAP_S, Talk
from firmware_py.marine import quaternion_from_euler
from firmware_py.records.sensing import Ahrs, Fix
from firmware_py.wire.serial import microstrain as mip
from firmware_py.wire.serial import vectornav as vn
from firmware_py.wire.serial import xsens as xbus

from .device import ATTITUDES, FIXES
from .instruments import nmea_receiver, sbg, ublox, vectornav

TRUTH = ATTITUDES[1]


class Stream:
    """A byte stream that brings what a test puts there."""

    def __init__(self, content: bytes = b"") -> None:
        self.content, self.openings = content, 1
        self.told: list[tuple[float, bytes]] = []
        self.t = 0.0

    def read(self, t: float) -> bytes:
        self.t, content, self.content = t, self.content, b""
        return content

    def write(self, data: bytes) -> None:
        self.told.append((self.t, data))

    def losses(self) -> dict[str, int]:
        return {}

    def close(self) -> None:
        pass


def heard(name: str, *contents: bytes, **options):
    """What a driver hears, each content in a tick of its own."""
    stream = Stream()
    driver, found = StreamDriver("device", INSTRUMENTS[name], stream, **options), []
    for k, content in enumerate(contents):
        stream.content = content
        found += driver.poll(1.0 + k)
    return found


@pytest.mark.parametrize("form", [xbus.FLOAT32, xbus.FIXED_16_32, xbus.FLOAT64])
@pytest.mark.parametrize("frame", ["ENU", "NED", "NWU"])
def test_an_xsens_is_understood_in_all_axes_of_the_earth(frame, form):
    """By what its axes x, y, z (forward, port, up) are called there, as rotation matrices."""
    phi, theta, psi = TRUTH[:3]
    body = quaternion_matrix(*quaternion_from_euler(phi, theta, psi))  # columns: forward, starboard, down in NED
    sensor = [[row[0], -row[1], -row[2]] for row in body]
    n, e, d = sensor
    rows = {"NED": (n, e, d), "NWU": (n, [-x for x in e], [-x for x in d]), "ENU": (e, n, [-x for x in d])}[frame]
    rates = (TRUTH.p, -TRUTH.q, -TRUTH.r)
    message = xbus.Attitude(quaternion=matrix_quaternion(rows), rates=rates, frame=frame, time=1.0, status=2)
    [reading] = heard("xsens", xbus.encode(message, form))
    assert reading.heard.value == pytest.approx(TRUTH, abs=1e-5)
    assert reading.heard.ok


def quaternion_matrix(x, y, z, w):
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def matrix_quaternion(m):
    """w, x, y, z by the largest of the four (Shepperd 1978)."""
    trace = m[0][0] + m[1][1] + m[2][2]
    squares = [1 + trace, *[1 - trace + 2 * m[i][i] for i in range(3)]]
    i = squares.index(max(squares))
    s = 2 * math.sqrt(squares[i])
    off = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
    if i == 0:
        return (s / 4, *[part / s for part in off])
    j, k = i % 3, (i + 1) % 3
    parts = [0.0] * 3
    parts[i - 1], parts[j], parts[k] = s / 4, (m[i - 1][j] + m[j][i - 1]) / s, (m[i - 1][k] + m[k][i - 1]) / s
    return (off[i - 1] / s, *parts)


@pytest.mark.parametrize("name", ["VNYMR", "VNQMR"])
def test_a_vectornav_that_sends_sentences_is_heard_too(name):
    quaternion = quaternion_from_euler(*TRUTH[:3])
    attitude = vn.Attitude(TRUTH[:3], (quaternion[3], *quaternion[:3]), TRUTH[3:])
    [reading] = heard("vectornav", vn.encode_line(attitude, name))
    assert reading.heard.value == pytest.approx(TRUTH, abs=1e-4)
    assert (reading.heard.ok, reading.heard.t_valid) == (True, 1.0)


def test_an_attitude_without_rates_is_heard_and_not_ok():
    [reading] = heard("vectornav", vn.encode_line(vn.Attitude(TRUTH[:3]), "VNYPR"))
    assert (reading.heard.fresh, reading.heard.ok) == (True, False)


def test_a_vectornav_mounted_upside_down_late_and_second_of_its_role():
    upside = Ahrs(math.pi, 0.1, 0.3, 0.1, 0.2, 0.3)
    [reading] = heard(
        "vectornav", vectornav.encode(upside, 1.0), mounting=Mounting(roll=math.pi), latency=0.25, number=1
    )
    assert reading.heard.value == pytest.approx((0.0, 0.1, 0.3, 0.1, -0.2, -0.3), abs=1e-6)
    assert (reading.number, reading.heard.t_valid) == (1, pytest.approx(0.75, abs=2e-6))


def test_the_sensors_of_a_microstrain_do_not_speak_for_its_filter():
    raw = mip.Attitude(TRUTH[:3], rates=TRUTH[3:], time=1.0, filtered=False)
    filtered = mip.Attitude(TRUTH[:3], rates=TRUTH[3:], time=1.01, state=3)
    assert heard("microstrain", mip.encode(raw)) == []
    [reading] = heard("microstrain", mip.encode(raw) + mip.encode(filtered) + mip.encode(raw))
    assert reading.heard.ok


def test_attitude_and_rates_of_an_sbg_belong_together_in_any_order_and_only_those_of_one_moment():
    whole = sbg.encode(TRUTH, 1.0)
    attitude, rates = whole[:41], whole[41:]
    other = sbg.encode(ATTITUDES[0], 1.01)
    assert [r.heard.value[3:] for r in heard("sbg", rates + attitude)] == [pytest.approx(TRUTH[3:], abs=1e-6)]
    assert heard("sbg", attitude + other[41:], attitude + other[41:]) == []
    faster = heard("sbg", rates + attitude + other[41:] + sbg.encode(TRUTH, 1.02))
    assert [r.heard.value for r in faster] == [pytest.approx(TRUTH, abs=1e-6)] * 2


def test_accuracy_of_a_receiver_is_what_it_tells_last_or_by_its_dilution():
    fix = FIXES[0]
    alone = heard("nmea_receiver", nmea_receiver.position(fix, 10.0))
    assert alone[0].heard.value.std == pytest.approx(0.9 * 5.0)
    after = nmea_receiver.position(fix, 10.0) + nmea_receiver.accuracy(3.0, 10.0)
    [first, second] = heard("nmea_receiver", after, nmea_receiver.position(fix, 11.0))
    assert (first.heard.value.std, second.heard.value.std) == (pytest.approx(4.5), pytest.approx(3.0))
    [_, old] = heard("nmea_receiver", after, nmea_receiver.position(fix, 600.0))
    assert old.heard.value.std == pytest.approx(4.5)
    [best] = heard("nmea_receiver", nmea_receiver.accuracy(1e-4, 10.0) + nmea_receiver.position(fix, 10.0))
    assert best.heard.value.std == 0.1
    [best] = heard("ublox", ublox.encode(fix._replace(std=0.01), 10.0))
    assert best.heard.value.std == 0.1


def test_one_fix_in_two_sentences_is_one_and_rmc_none():
    gga = nmea_receiver.encode(FIXES[0], 10.0)
    place = {"lat": 1.0, "NS": "N", "lon": 2.0, "EW": "E", "alt": 1.0, "sep": 1.0, "numSV": 9, "HDOP": 1.0}
    gns = NMEAMessage("GN", "GNS", GET, time=nmea_receiver.moment(10.0), posMode="AANN", **place).serialize()
    rmc = b"$GPRMC,083559.00,A,4717.11437,N,00833.91522,E,0.004,77.52,091202,,,A*57\r\n"
    [reading] = heard("nmea_receiver", gga + gns + rmc)
    assert reading.heard.value == pytest.approx(Fix(*FIXES[0]), abs=1e-3)


def told(name: str, seconds: float) -> bytes:
    stream = Stream()
    driver = StreamDriver("device", INSTRUMENTS[name], stream)
    for k in range(round(100 * seconds)):
        driver.poll(k / 100)
    return b"".join(data for _, data in stream.told)


def test_a_receiver_is_told_in_packets_that_a_judge_reads():
    content = told("ublox", 1.0)
    identities = []
    while content:
        size = 8 + struct.unpack("<H", content[4:6])[0]
        identities.append(UBXReader.parse(content[:size], msgmode=SET).identity)
        content = content[size:]
    assert identities == ["CFG-VALSET"] * 2 + ["CFG-MSG"] * 6 + ["CFG-RATE", "CFG-MSG"]


def test_an_echosounder_is_told_in_packets_that_a_judge_reads():
    content, ids = told("ping", 1.0), []
    while content:
        size = 10 + struct.unpack("<H", content[2:4])[0]
        message = PingMessage(msg_data=content[:size])
        assert message.verify_checksum()
        ids.append(message.message_id)
        content = content[size:]
    assert ids == [1003, 1004, 1400]


def test_packets_are_told_one_by_one_and_a_polled_device_again_and_again():
    stream = Stream()
    polled = INSTRUMENTS["ping"]._replace(talk=Talk((b"a", b"b"), silence=0.5))
    driver = StreamDriver("device", polled, stream)
    for k in range(200):
        driver.poll(k / 100)
    assert [data for _, data in stream.told] == [b"a", b"b"] * 4
    times = [t for t, _ in stream.told]
    assert [b - a for a, b in itertools.pairwise(times)] == pytest.approx([GAP_S, 0.5] * 3 + [GAP_S], abs=0.011)
