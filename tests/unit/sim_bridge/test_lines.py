"""The simulated instruments on lines: through its driver each gives back what it measures, as soon as it is told to."""

from __future__ import annotations

import math
import struct
from types import SimpleNamespace

import numpy as np
import pytest
import serial
from brping.pingmessage import PingParser
from hypothesis import given, settings
from hypothesis import strategies as st
from pynmeagps import NMEAReader
from pyubx2 import UBXReader

from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.drivers.tcp_stream import TcpStream
from firmware_py.marine import quaternion_from_euler, wrap
from firmware_py.records.sensing import Ahrs, Dvl, Fix
from firmware_py.wire.serial import microstrain as mip
from firmware_py.wire.serial import ping, ubx_config, xsens
from firmware_py.wire.serial import vectornav_commands as vn
from sim_bridge.devices.line_device import LineDevice
from sim_bridge.devices.lines.firmware import Pace
from sim_bridge.devices.lines.table import FIRMWARE
from sim_bridge.devices.sensors import Sensor, Timing
from sim_bridge.devices.serial_line import SerialLine
from sim_bridge.devices.tcp_line import TcpLine

BASE_HZ = 100
RATES = {"ahrs": 100, "dvl": 5, "pressure": 20, "altitude": 10, "fix": 5}
TOLERANCE = {"ahrs": 1e-5, "dvl": 6e-3, "pressure": 51.0, "altitude": 1e-3, "fix": 4e-9}
"""Half a step of the coarsest protocol of each role; of the standard deviation of a fix 1 mm."""
SETTLED_S = 1.0
"""By then the slowest has been told all that it is told."""


class Wire:
    """Both ends of a line without a kernel: `ByteStream` for the driver, `Line` for the device."""

    def __init__(self) -> None:
        self.openings, self.lost, self.late = 1, 0, 0
        self._down = self._up = b""

    def send(self, line: bytes) -> None:
        self._up += line

    def receive(self) -> bytes:
        data, self._down = self._down, b""
        return data

    def read(self, _t: float) -> bytes:
        data, self._up = self._up, b""
        return data

    def write(self, data: bytes) -> None:
        self._down += data

    def losses(self) -> dict[str, int]:
        return {}

    def close(self) -> None:
        pass


class Bench:
    """A simulated instrument that measures what `value` is, its driver, and a wire between them."""

    def __init__(
        self,
        name: str,
        wire: object = None,
        latency: float = 0.0,
        far_end: object = None,
        mounting: Mounting = STRAIGHT,
    ) -> None:
        self.role = INSTRUMENTS[name].role
        self.value: object = None
        wire = wire or Wire()
        self.sensor = Sensor(name, Timing(RATES[self.role], latency), lambda *_: self.value, (), (), 1, BASE_HZ)
        self.device = LineDevice(self.sensor, wire, FIRMWARE[name](), mounting)
        self.driver = StreamDriver("device", INSTRUMENTS[name], far_end or wire, mounting=mounting)
        self.k = 0

    def fly(self, seconds: float) -> list[tuple[float, object]]:
        """What is heard in so long, each with the time of its arrival, s."""
        heard = []
        for _ in range(round(seconds * BASE_HZ)):
            t = self.k / BASE_HZ
            self.device.update(self.k, t, SimpleNamespace())
            heard += [(t, reading.heard) for reading in self.driver.poll(t)]
            self.k += 1
        return heard


angles = st.floats(-1.5, 1.5)
VALUES = {
    "ahrs": st.builds(Ahrs, st.floats(-3.1, 3.1), angles, st.floats(-3.1, 3.1), *[st.floats(-5.0, 5.0)] * 3),
    "dvl": st.builds(Dvl, *[st.floats(-9.0, 9.0)] * 3, st.floats(0.001, 5.0), st.floats(0.3, 150.0)),
    "pressure": st.floats(101_325.0, 4e6),
    "altitude": st.floats(0.31, 60.0),
    "fix": st.builds(Fix, st.floats(-1.5, 1.5), st.floats(-3.1, 3.1), st.floats(0.05, 50.0)),
}
NOTHING = {"dvl": (None,), "altitude": (0.0, math.inf), "fix": (None,)}
"""What sensors deliver where there is nothing to measure."""


def test_every_instrument_of_an_io_file_is_simulated() -> None:
    assert FIRMWARE.keys() == INSTRUMENTS.keys()


@pytest.mark.parametrize("name", FIRMWARE)
@given(data=st.data())
@settings(max_examples=10, deadline=None)
def test_what_is_measured_is_heard(name: str, data: st.DataObject) -> None:
    bench = Bench(name)
    bench.value = data.draw(VALUES[bench.role])
    bench.fly(SETTLED_S)
    heard = bench.fly(1.0)
    assert len(heard) == pytest.approx(RATES[bench.role], abs=1)
    for _, one in heard:
        assert (one.fresh, one.ok) == (True, True)
        check(name, one.value, bench.value)
    assert sum(bench.driver.losses().values()) == 0


def check(name: str, heard: object, measured: object) -> None:
    role = INSTRUMENTS[name].role
    tolerance = TOLERANCE[role]
    if role == "ahrs":
        assert [wrap(a - b) for a, b in zip(heard, measured, strict=True)] == pytest.approx([0.0] * 6, abs=tolerance)
    elif role == "fix":
        assert heard[:2] == pytest.approx(measured[:2], abs=tolerance)
        assert heard.std == pytest.approx(measured.std, abs=1e-3)
    elif role == "dvl" and name.startswith("pd6"):
        assert (*heard[:3], heard.altitude) == pytest.approx((*measured[:3], measured.altitude), abs=tolerance)
        assert math.isnan(heard.fom)  # the format has none
    else:
        assert heard == pytest.approx(measured, abs=tolerance)


@pytest.mark.parametrize(
    ("name", "nothing"), [(name, value) for name in FIRMWARE for value in NOTHING.get(INSTRUMENTS[name].role, ())]
)
def test_where_there_is_nothing_to_measure_nothing_is_ok(name: str, nothing: object) -> None:
    bench = Bench(name)
    bench.value = nothing
    heard = bench.fly(SETTLED_S + 1.0)
    assert heard
    assert not any(one.ok for _, one in heard)


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf, 1e300])
@pytest.mark.parametrize("name", FIRMWARE)
def test_a_broken_sensor_breaks_no_simulation_and_is_not_believed(name: str, odd: float) -> None:
    bench = Bench(name)
    count = {"ahrs": Ahrs, "dvl": Dvl, "fix": Fix}.get(bench.role)
    bench.value = count(*[odd] * len(count._fields)) if count else odd
    heard = bench.fly(SETTLED_S + 1.0)
    if math.isnan(odd):
        assert not any(one.ok for _, one in heard)


@pytest.mark.parametrize("name", ["waterlink", "waterlink_json", "nortek"])
def test_a_dvl_that_tells_its_delay_is_believed_to_the_moment(name: str) -> None:
    bench = Bench(name, latency=0.1)
    bench.value = Dvl(1.0, 0.0, 0.0, 0.01, 20.0)
    assert [t - one.t_valid for t, one in bench.fly(2.0)] == pytest.approx([0.1] * 10, abs=2e-6)


@pytest.mark.parametrize("name", ["vectornav", "microstrain", "ping", "ublox"])
def test_an_instrument_that_has_lost_its_power_is_told_again(name: str) -> None:
    bench = Bench(name)
    bench.value = {"ahrs": Ahrs(0.1, 0.2, 0.3, 0.0, 0.0, 0.0), "altitude": 9.0, "fix": Fix(0.6, -2.1, 2.0)}[bench.role]
    bench.fly(SETTLED_S)
    bench.device.switch_off()
    assert [one for _, one in bench.fly(2.0)] == []
    bench.device.switch_on()
    bench.fly(3.0)  # `Talk.silence`
    heard = bench.fly(2.0)
    least = 40 if name == "vectornav" else RATES[bench.role]  # one that sends its factory's sentences is not silent
    assert len(heard) >= 2 * least - 1
    assert heard[-1][1].ok


@given(value=VALUES["ahrs"], roll=st.floats(-3.1, 3.1), pitch=angles, yaw=st.floats(-3.1, 3.1), north=angles)
@settings(max_examples=20, deadline=None)
def test_an_instrument_that_is_mounted_askew_is_understood_by_its_mounting(
    value: Ahrs, roll: float, pitch: float, yaw: float, north: float
) -> None:
    mounting = Mounting(roll, pitch, yaw, north)
    attitude, velocity = Bench("sbg", mounting=mounting), Bench("nortek", mounting=mounting)
    attitude.value, velocity.value = value, Dvl(1.5, -0.5, 0.25, 0.01, 20.0)
    [*_, (_, heard)] = attitude.fly(0.1)
    turned = [quaternion_from_euler(*one[:3]) for one in (heard.value, value)]
    assert abs(np.dot(*turned)) == pytest.approx(1.0, abs=1e-6)  # the same, also where yaw and roll are ambiguous
    assert heard.value[3:] == pytest.approx(value[3:], abs=1e-5)
    [*_, (_, heard)] = velocity.fly(0.1)
    assert heard.value == pytest.approx(velocity.value, abs=2e-4)


def told(name: str, *packets: bytes) -> bytes:
    firmware = FIRMWARE[name]()
    return b"".join(firmware.answer(packet) for packet in packets)


def test_a_vectornav_answers_as_its_manual_says() -> None:
    assert told("vectornav", vn.command("VNRRG,06")) == vn.command("VNRRG,06,14")
    assert told("vectornav", vn.set_output("off")) == vn.set_output("off")
    assert told("vectornav", vn.set_output("off"), b"$VNRRG,06*XX\r\n").endswith(vn.command("VNRRG,06,0"))
    packets = vn.set_binary_output(8)
    assert told("vectornav", packets[:9], packets[9:]) == packets


@pytest.mark.parametrize(
    ("line", "error"),
    [
        (b"$VNRRG,06*00\r\n", 3),
        (vn.command("VNXYZ"), 4),
        (vn.command("VNWRG,06"), 5),
        (vn.command("VNWRG,06,99"), 7),
        (vn.command("VNWRG,75,1,8,01"), 7),
        (vn.command("VNWRG,75,1,8,02,0001"), 7),
        (vn.command("VNWRG,01,mine"), 8),
        (vn.command("VNRRG,200"), 8),
    ],
)
def test_a_vectornav_refuses_as_its_manual_says(line: bytes, error: int) -> None:
    assert told("vectornav", line) == vn.command(f"VNERR,{error:02d}")


def test_a_vectornav_sends_sentences_until_it_is_told_and_keeps_what_is_written() -> None:
    firmware, value = FIRMWARE["vectornav"](), Ahrs(0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
    sent = [firmware.report(value, k / 100, k / 100) for k in range(100)]
    assert sum(one.startswith(b"$VNYMR") for one in sent) == 40
    firmware.answer(vn.set_output("off") + vn.set_binary_output(16) + vn.write_settings() + vn.set_output("VNYPR"))
    firmware.restart()
    sent = [firmware.report(value, k / 100, k / 100) for k in range(100)]
    assert sum(one.startswith(b"\xfa") for one in sent) == 50
    assert not any(b"$" in one[:1] for one in sent)


def test_a_receiver_acknowledges_in_the_words_of_pyubx2_what_it_takes_and_refuses_the_rest() -> None:
    unknown = ubx_config.set_values({0x1052_0005: 1})
    answers = told("ublox", ubx_config.switch_on(5.0), *[ubx_config.switch_on_older(2.0)], unknown)
    read = [UBXReader.parse(answers[k : k + 10]) for k in range(0, len(answers), 10)]
    assert [one.identity for one in read] == ["ACK-ACK", "ACK-ACK", "ACK-ACK", "ACK-NAK"]
    assert [(one.clsID, one.msgID) for one in read] == [(6, 0x8A), (6, 0x08), (6, 0x01), (6, 0x8A)]


def test_foreign_readers_understand_receivers_and_sounder() -> None:
    fix = Fix(math.radians(36.6), math.radians(-121.9), 1.5)
    receiver = FIRMWARE["ublox"]()
    gga = NMEAReader.parse(receiver.report(fix, 1742.0, 1742.0))
    assert (gga.lat, gga.lon, gga.quality) == (pytest.approx(36.6), pytest.approx(-121.9), 1)
    receiver.answer(ubx_config.switch_on(5.0))
    pvt = UBXReader.parse(receiver.report(fix, 1743.2, 1743.2))
    assert (pvt.lat, pvt.lon, pvt.hAcc, pvt.iTOW) == (pytest.approx(36.6), pytest.approx(-121.9), 1500, 1_743_200)
    assert (pvt.fixType, pvt.gnssFixOk, pvt.min, pvt.second) == (3, 1, 29, 3)
    under_water = UBXReader.parse(receiver.report(None, 1744.0, 1744.0))
    assert (under_water.fixType, under_water.gnssFixOk) == (0, 0)
    depth = NMEAReader.parse(FIRMWARE["nmea_sounder"]().report(12.25, 0.0, 0.0))
    assert depth.depth == 12.25


def test_a_ping_answers_the_makers_own_program_on_a_pseudo_terminal() -> None:
    with SerialLine() as line, serial.Serial(line.path, 115200, timeout=1.0) as port:
        firmware, parser = FIRMWARE["ping"](), PingParser()
        assert firmware.report(12.345, 1742.0, 1742.0) == b""  # silent until it is asked
        for asked, field, value in ((ping.PROTOCOL_VERSION, "version_major", 1), (ping.DISTANCE, "distance", 12_345)):
            port.write(b"U" + ping.request(asked))
            line.send(firmware.answer(line.receive()))
            done = [parser.parse_byte(byte) for byte in port.read(port.in_waiting)]
            assert done[-1] == PingParser.NEW_MESSAGE
            assert (parser.rx_msg.message_id, getattr(parser.rx_msg, field)) == (asked, value)
        for refused in (ping.packet(1006, b"\1"), ping.continuous_start(1300)):
            [answer] = ping.packets().feed(firmware.answer(refused))
            assert isinstance(answer, ping.Nack)


def test_a_microstrain_of_the_newer_family_refuses_the_words_of_the_older() -> None:
    wanted = {0xD5: 10, 0x05: 10, 0x0E: 10}
    answers = told("microstrain", *[mip.message_format(mip.FILTER, wanted, old=old) for old in (False, True)])
    assert answers == mip.packet(0x0C, (0xF1, b"\x0f\0")) + mip.packet(0x0C, (0xF1, b"\x0a\1"))
    assert told("microstrain", mip.message_format(mip.FILTER, {0x42: 10})) == mip.packet(0x0C, (0xF1, b"\x0f\3"))


def test_an_xsens_takes_settings_in_its_config_state_alone() -> None:
    output = xsens.set_output_configuration([(xsens.QUATERNION | 4, 50)])
    assert told("xsens", output)[2] == 0x42
    answers = told("xsens", xsens.go_to_config(), output, xsens.go_to_measurement())
    assert answers == xsens.command(0x31) + xsens.command(0xC1, struct.pack(">HH", 0x2014, 50)) + xsens.command(0x11)


@pytest.mark.parametrize("name", FIRMWARE)
@given(noise=st.lists(st.binary(max_size=60), max_size=8))
@settings(max_examples=30, deadline=None)
def test_no_bytes_break_an_instrument(name: str, noise: list[bytes]) -> None:
    told(name, *noise)


@pytest.mark.parametrize("rate", [1, 5, 20, 40, 99, 100])
def test_a_pace_lets_through_what_was_asked_for(rate: int) -> None:
    pace = Pace(rate)
    assert sum(pace.due(1742.0 + k / 100) for k in range(1000)) == 10 * rate


@pytest.mark.parametrize("name", ["waterlink_json", "nmea_receiver"])
def test_an_instrument_listens_at_a_tcp_port(name: str) -> None:
    with TcpLine("tcp:127.0.0.1:0") as line:
        stream = TcpStream("device", line.path)
        bench = Bench(name, line, far_end=stream)
        bench.value = {"dvl": Dvl(1.0, 0.5, 0.25, 0.01, 20.0), "fix": Fix(0.6, -2.1, 2.0)}[bench.role]
        heard = bench.fly(1.0)
        assert len(heard) == 5
        check(name, heard[-1][1].value, bench.value)
        stream.close()
        bench.fly(0.5)  # nobody is there, and nobody waits
        again = TcpStream("device", line.path)
        bench.driver = StreamDriver("device", INSTRUMENTS[name], again)
        assert bench.fly(1.0)
        again.close()
        assert line.lost == 0
