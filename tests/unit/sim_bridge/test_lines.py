"""The simulated instruments on lines: through its driver each gives back what it measures, as soon as it is told to."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.adapters.drivers.fix_accuracy import LEAST_STD
from firmware_py.adapters.drivers.instrument_table import INSTRUMENTS
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.adapters.drivers.stream_driver import StreamDriver
from firmware_py.adapters.drivers.tcp_stream import TcpStream
from firmware_py.marine import quaternion_from_euler, wrap
from firmware_py.records.sensing import Ahrs, Dvl, Fix
from firmware_py.wire.serial import microstrain, ping, ubx_config, xsens
from firmware_py.wire.serial.vectornav_commands import set_binary_output, set_output
from sim_bridge.devices.line_device import LineDevice
from sim_bridge.devices.lines.table import FIRMWARE
from sim_bridge.devices.sensors import Sensor, Timing
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
        self.firmware = FIRMWARE[name]()
        self.device = LineDevice(self.sensor, wire, self.firmware, mounting)
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
        assert heard.std == pytest.approx(max(measured.std, LEAST_STD), abs=1e-3)
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


ONE = {
    "ahrs": Ahrs(0.1, 0.2, 0.3, 0.0, 0.0, 0.0),
    "dvl": Dvl(1.0, 0.0, 0.0, 0.01, 20.0),
    "pressure": 2e5,
    "altitude": 9.0,
    "fix": Fix(0.6, -2.1, 2.0),
}
SAVED = {
    "": {},
    "another's settings": {
        "vectornav": set_output("off") + set_binary_output(80),
        "microstrain": microstrain.message_format(microstrain.FILTER, {0x05: 50, 0x0E: 50, 0x10: 50})
        + microstrain.enable_stream(microstrain.FILTER),
        "xsens": xsens.go_to_config()
        + xsens.set_output_configuration(((xsens.EULER_ANGLES, 20), (xsens.RATE_OF_TURN, 20)))
        + xsens.go_to_measurement(),
        "ublox": ubx_config.switch_on(1.0),
        "ping": ping.set_ping_interval(0.5) + ping.continuous_start(),
    },
}
"""What they were told by the maker's tools and kept: they begin with it, and what the driver told is gone."""


@pytest.mark.parametrize("saved", SAVED)
@pytest.mark.parametrize("off", [0.05, 2.0])
@pytest.mark.parametrize("name", FIRMWARE)
def test_an_instrument_that_has_lost_its_power_is_told_again(name: str, off: float, saved: str) -> None:
    boots = 0.0 if not saved else 2.0
    bench = Bench(name)
    bench.value = ONE[bench.role]
    bench.fly(SETTLED_S)
    before = bench.fly(2.0)
    bench.device.switch_off()
    assert [one for _, one in bench.fly(off + boots)] == []
    bench.device.switch_on()
    bench.firmware.answer(SAVED[saved].get(name, b""))
    bench.fly(3.0 + 2.0 * SETTLED_S)  # `Talk.silence`; told twice, since it may have started meanwhile
    after = bench.fly(2.0)
    assert len(after) == pytest.approx(len(before), abs=1)
    assert [one.ok for _, one in after] == [True] * len(after)
    [packet] = {t - one.t_valid for t, one in after[-1:]}
    assert packet == pytest.approx(before[-1][0] - before[-1][1].t_valid, abs=2e-3)


def test_a_vectornav_that_cannot_be_told_is_heard_and_told_every_three_seconds() -> None:
    bench = Bench("vectornav")
    bench.value = ONE["ahrs"]
    bench.firmware.answer = lambda told: asked.append(told) or b""  # its receiving wire is cut
    asked: list[bytes] = []
    assert len(bench.fly(10.0)) == pytest.approx(400, abs=1)
    packets = INSTRUMENTS["vectornav"].talk.packets
    assert asked == [*packets] * 4


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
