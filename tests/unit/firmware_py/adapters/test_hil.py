"""The vehicle's end of the simulator interface, with a simulator that is nothing but pymavlink on a socket."""

from __future__ import annotations

import math
import socket
import struct
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import common as mav

from firmware_py.adapters.hil import hil_hardware, hil_link
from firmware_py.adapters.hil.hil_hardware import HilHardware, HilSchedule
from firmware_py.adapters.hil.hil_link import HilLink
from firmware_py.adapters.lockstep.lockstep_link import LockstepError
from firmware_py.marine import quaternion_from_euler
from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick

DT_NS = 10_000_000
EPOCH_US = 1_700_000_000_000_000  # a simulator that counts from 1970
DELTA_MAX, N_MAX = (0.4, 0.4, 0.2, 0.2), 16.0
ALL = 0x1FFF
IDLE = Applied((0.0,) * 4, 0.0, armed=False, limited=False)


class Simulator:
    """The foreign end: pymavlink's own dialect, packing and parsing."""

    def __init__(self, stream: socket.socket) -> None:
        self.stream = stream
        self._mav = mav.MAVLink(None, srcSystem=42)
        self._mav.robust_parsing = True

    def send(self, *messages: mav.MAVLink_message) -> None:
        self.stream.sendall(b"".join(message.pack(self._mav) for message in messages))

    def received(self) -> list[mav.MAVLink_message]:
        self.stream.setblocking(False)
        try:
            return self._mav.parse_buffer(self.stream.recv(65536)) or []
        except BlockingIOError:
            return []


class Pair:
    """A vehicle and the simulator it is connected to."""

    def __init__(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            ours = socket.create_connection(server.getsockname())
            theirs, _ = server.accept()
        self.simulator = Simulator(theirs)
        self.link = HilLink(ours, 7, vehicle=True)
        self.hardware = HilHardware(self.link, (*DELTA_MAX, N_MAX))
        self.ticks = iter(HilSchedule(self.hardware, self.link, DT_NS, lambda: False))

    def frame(self, *messages: mav.MAVLink_message) -> SensorFrame:
        """The frame of the next tick, when the simulator has sent these; the vehicle answers it."""
        self.simulator.send(*messages)
        tick = next(self.ticks)
        frame = self.hardware.read(tick)
        self.hardware.write(tick, IDLE)
        return frame

    def close(self) -> None:
        self.link.close()
        self.simulator.stream.close()


@pytest.fixture
def pair() -> Iterator[Pair]:
    made = Pair()
    yield made
    made.close()


def sensor(k: int = 0, *, gyro=(0.1, 0.2, 0.3), pressure: float = 1200.0, updated: int = ALL, which: int = 0):
    t = EPOCH_US + k * DT_NS // 1000
    return mav.MAVLink_hil_sensor_message(t, 0, 0, -9.8, *gyro, 0.2, 0, 0.4, pressure, 0, 0, 20, updated, which)


def state(k: int = 0, *, angles=(0.0, 0.0, 0.0), velocity=(0, 0, 0), q: tuple[float, ...] | None = None):
    x, y, z, w = quaternion_from_euler(*angles)
    t = EPOCH_US + k * DT_NS // 1000
    return mav.MAVLink_hil_state_quaternion_message(
        t, q or (w, x, y, z), 9, 9, 9, 0, 0, 0, *velocity, 0, 0, 0, 0, -1000
    )


def gps(k: int = 0, *, fix_type: int = 3, eph: int = 150, which: int = 0):
    t = EPOCH_US + k * DT_NS // 1000
    return mav.MAVLink_hil_gps_message(t, fix_type, 368_000_000, -1_218_000_000, 0, eph, 65535, 0, 0, 0, 0, 0, 9, which)


def distance(cm: int, *, orientation: int = 25, quality: int = 0):
    return mav.MAVLink_distance_sensor_message(17, 30, 6000, cm, 1, 0, orientation, 9, signal_quality=quality)


def humidity(value: float, name: bytes = b"LEAK"):
    return mav.MAVLink_named_value_float_message(0, name, value)


def battery(voltages: tuple[int, ...], current: int = 250, remaining: int = 80):
    cells = voltages + (65535,) * (10 - len(voltages))
    return mav.MAVLink_battery_status_message(0, 0, 0, 32767, cells, current, -1, -1, remaining)


def crc_x25(data: bytes) -> int:
    """CRC-16/MCRF4XX, as the MAVLink guide has it."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def test_the_answer_is_the_frame_that_the_specification_describes(pair: Pair) -> None:
    pair.simulator.send(state(), sensor())
    tick = next(pair.ticks)
    pair.simulator.stream.recv(65536)  # what was said before the first tick
    pair.hardware.write(Tick(tick.k + 1, DT_NS), Applied((0.4, -0.1, 0.0, 0.2), -4.0, armed=True, limited=False))
    frame = pair.simulator.stream.recv(65536)
    # Fields by size, then as declared: time_usec and flags (u64), 16 controls (f32), mode (u8). CRC_EXTRA is 47.
    payload = struct.pack("<QQ16fB", EPOCH_US + 10_000, 1, 1.0, -0.25, 0.0, 1.0, -0.25, *(0.0,) * 11, 129)
    head = struct.pack("<BBBBBB", len(payload), 0, 0, frame[4], 7, 1) + (93).to_bytes(3, "little")
    assert frame == b"\xfd" + head + payload + struct.pack("<H", crc_x25(head + payload + b"\x2f"))


def test_disarmed_is_said_in_the_mode(pair: Pair) -> None:
    pair.frame(state(), sensor())
    beat, request, again, answer = pair.simulator.received()
    assert {beat.get_type(), again.get_type()} == {"HEARTBEAT"}
    assert beat.type == mav.MAV_TYPE_SUBMARINE
    assert (request.command, request.param1, request.param2) == (mav.MAV_CMD_SET_MESSAGE_INTERVAL, 115, 10_000)
    assert answer.mode == mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    assert answer.controls == [0.0] * 16


@pytest.mark.parametrize(("drop", "share"), [(False, 0.0), (True, 1.0)])
def test_the_control_after_the_propellers_releases_the_drop_weight(pair: Pair, drop: bool, share: float) -> None:
    pair.frame(state(), sensor())
    pair.hardware.write(Tick(1, DT_NS), replace(IDLE, drop=drop))
    answer = pair.simulator.received()[-1]
    assert answer.controls[4:] == [0.0, share, *[0.0] * 10]


def test_one_answer_for_each_hil_sensor_and_none_for_a_second_imu(pair: Pair) -> None:
    for k in range(50):
        pair.frame(state(k), sensor(k, which=1), sensor(k))
    answers = [m for m in pair.simulator.received() if m.get_type() == "HIL_ACTUATOR_CONTROLS"]
    assert [answer.time_usec - EPOCH_US for answer in answers] == [10_000 * k for k in range(50)]
    assert {answer.flags for answer in answers} == {1}


def test_rates_are_the_gyros_and_angles_those_of_the_state(pair: Pair) -> None:
    angles = (0.1, -0.2, 3.0)
    frame = pair.frame(state(angles=angles), sensor(gyro=(0.01, -0.02, 0.5)))
    assert frame.ahrs.value == pytest.approx((*angles, 0.01, -0.02, 0.5), abs=1e-6)
    assert (frame.ahrs.t_valid, frame.ahrs.fresh, frame.ahrs.ok) == (0.0, True, True)


def test_a_simulator_that_sends_its_state_behind_its_tick_is_heard_a_tick_later_with_its_time(pair: Pair) -> None:
    assert not pair.frame(sensor(0), state(0, angles=(0.0, 0.0, 0.5))).ahrs.fresh
    frame = pair.frame(sensor(1), state(1, angles=(0.0, 0.0, 0.6)))
    assert frame.ahrs.value.psi == pytest.approx(0.5)
    assert frame.ahrs.t_valid == 0.0
    assert frame.dvl.t_valid == 0.0


@pytest.mark.parametrize(
    ("angles", "velocity", "body"),
    [
        ((0.0, 0.0, 0.0), (180, -20, 10), (1.8, -0.2, 0.1)),
        ((0.0, 0.0, math.pi / 2), (0, 180, 0), (1.8, 0.0, 0.0)),  # heading east
        ((0.0, 0.0, math.pi / 2), (50, 0, 0), (0.0, -0.5, 0.0)),  # drifting north, to port
        ((0.0, math.pi / 6, 0.0), (0, 0, -100), (0.5, 0.0, -math.sqrt(3) / 2)),  # rising, nose up
        ((math.pi / 2, 0.0, 0.0), (0, 0, 100), (0.0, 1.0, 0.0)),  # on its starboard side
    ],
)
def test_velocity_is_turned_from_ned_into_the_body(pair: Pair, angles, velocity, body) -> None:
    dvl = pair.frame(state(angles=angles, velocity=velocity), sensor()).dvl
    assert dvl.ok
    assert dvl.value[:3] == pytest.approx(body, abs=1e-6)
    assert math.isnan(dvl.value.altitude)


def test_velocity_comes_five_times_a_second_and_attitude_at_every_tick(pair: Pair) -> None:
    frames = [pair.frame(state(k), sensor(k)) for k in range(100)]
    assert [k for k, frame in enumerate(frames) if frame.dvl.fresh] == [0, 20, 40, 60, 80]
    assert all(frame.ahrs.fresh for frame in frames)
    assert [frame.ahrs.t_valid for frame in frames] == [Tick(k, DT_NS).t for k in range(100)]


@pytest.mark.parametrize(
    ("updated", "ahrs", "pressure"),
    [
        (ALL, True, True),
        (ALL & ~mav.HIL_SENSOR_UPDATED_YGYRO, False, True),
        (ALL & ~mav.HIL_SENSOR_UPDATED_ABS_PRESSURE, True, False),
        (0, False, False),
    ],
)
def test_what_is_not_said_to_be_updated_is_not_heard(pair: Pair, updated: int, ahrs: bool, pressure: bool) -> None:
    pair.frame(state(0), sensor(0, pressure=1100.0))
    frame = pair.frame(state(1), sensor(1, pressure=1300.0, updated=updated))
    assert (frame.ahrs.fresh, frame.pressure.fresh) == (ahrs, pressure)
    assert frame.pressure.value == pytest.approx(130_000.0 if pressure else 110_000.0)
    assert frame.pressure.t_valid == (0.01 if pressure else 0.0)


NAN = math.nan


@pytest.mark.parametrize(
    ("messages", "field"),
    [
        ((state(), sensor(gyro=(0.0, NAN, 0.0))), "ahrs"),
        ((state(q=(NAN, 0.0, 0.0, 0.0)), sensor()), "ahrs"),
        ((state(q=(0.0, 0.0, 0.0, 0.0)), sensor()), "ahrs"),
        ((state(q=(NAN, 0.0, 0.0, 0.0)), sensor()), "dvl"),
        ((state(), sensor(pressure=NAN)), "pressure"),
        ((state(), sensor(pressure=math.inf)), "pressure"),
        ((gps(eph=65535), sensor()), "fix"),
        ((gps(eph=0), sensor()), "fix"),
        ((gps(fix_type=1), sensor()), "fix"),
        ((distance(29), sensor()), "altitude"),
        ((distance(6001), sensor()), "altitude"),
        ((distance(500, quality=1), sensor()), "altitude"),
        ((battery(()), sensor()), "battery"),
        ((humidity(math.nan), sensor()), "leak"),
    ],
)
def test_what_is_unknown_or_no_number_is_heard_and_not_vouched_for(pair: Pair, messages, field: str) -> None:
    heard = getattr(pair.frame(*messages), field)
    assert heard.fresh
    assert not heard.ok


def test_fix_distance_and_battery_are_in_si(pair: Pair) -> None:
    frame = pair.frame(state(), gps(), distance(1234), battery((65534, 466)), sensor())
    assert frame.fix.value == pytest.approx((math.radians(36.8), math.radians(-121.8), 1.5))
    assert frame.altitude.value == pytest.approx(12.34)
    assert frame.battery.value == pytest.approx((66.0, 2.5, 0.8))
    assert frame.fix.ok
    assert frame.altitude.ok
    assert frame.battery.ok


def test_humidity_is_heard_by_its_name(pair: Pair) -> None:
    frame = pair.frame(state(), humidity(0.25, b"OTHER"), sensor())
    assert not frame.leak.fresh
    frame = pair.frame(state(1), humidity(0.875), humidity(0.25, b"LEAKAGE"), sensor(1))
    assert (frame.leak.value, frame.leak.fresh, frame.leak.ok) == (0.875, True, True)


def test_the_weight_that_still_hangs_is_heard_by_its_name_beside_the_leak_sensor(pair: Pair) -> None:
    assert not pair.frame(state(), sensor()).hardpoint.ok
    frame = pair.frame(state(1), humidity(0.875), humidity(1335.0, b"WEIGHT"), sensor(1))
    assert (frame.leak.value, frame.hardpoint.value) == (0.875, (True, 1335.0))
    assert pair.frame(state(2), humidity(0.0, b"WEIGHT"), sensor(2)).hardpoint.value == (False, 0.0)


def test_what_looks_elsewhere_or_is_another_instance_is_not_heard(pair: Pair) -> None:
    frame = pair.frame(state(), distance(500), distance(200, orientation=0), gps(), gps(eph=900, which=1), sensor())
    assert frame.altitude.value == pytest.approx(5.0)
    assert frame.fix.value.std == pytest.approx(1.5)


def test_nothing_is_known_of_fins_propeller_and_hull(pair: Pair) -> None:
    frame = pair.frame(state(), sensor())
    assert [fin.ok for fin in frame.fins] == [False] * 4
    assert not frame.n.ok
    assert not frame.leak.ok


@pytest.mark.parametrize(
    ("times", "words"),
    [
        ((0, 4_000), "the plant steps 4 ms, the vehicle 10 ms: set one rate_hz"),
        ((0, 10_000, 30_000), "HIL_SENSOR of 0.030000 s came when 0.020000 s was due"),
        ((0, 10_000, 10_000), "HIL_SENSOR of 0.010000 s came when 0.020000 s was due"),
        ((0, -10_000), "HIL_SENSOR of -0.010000 s came when 0.010000 s was due"),
    ],
)
def test_a_time_that_does_not_go_on_by_the_step_ends_the_run(pair: Pair, times: tuple[int, ...], words: str) -> None:
    def at(time_us: int) -> mav.MAVLink_message:
        message = sensor()
        message.time_usec = EPOCH_US + time_us
        return message

    for time_us in times[:-1]:
        pair.frame(at(time_us))
    pair.simulator.send(at(times[-1]))
    with pytest.raises(LockstepError, match=f"^{words}$"):
        next(pair.ticks)


def farewell() -> mav.MAVLink_message:
    return mav.MAVLink_heartbeat_message(0, 8, 0, 0, mav.MAV_STATE_POWEROFF, 3)


def test_a_simulator_that_says_farewell_ends_the_run(pair: Pair) -> None:
    pair.frame(state(), sensor())
    pair.simulator.send(farewell())
    pair.simulator.stream.close()
    assert list(pair.ticks) == []


@pytest.mark.parametrize(
    ("leave", "words"),
    [
        (lambda stream: stream.close(), "the plant has closed the connection, at tick 1: was it ended\\?"),
        (lambda _: None, "the plant has been silent for 0.2 s, at tick 1: was it ended\\?"),
        (
            lambda stream: stream.sendall(b"hello"),
            "the plant has been silent for 0.2 s, at tick 1: was it ended\\?; 5 bytes that came are no MAVLink",
        ),
    ],
)
def test_a_simulator_that_is_gone_ends_the_run_with_one_line(
    pair: Pair, monkeypatch: pytest.MonkeyPatch, leave: Callable[[socket.socket], None], words: str
) -> None:
    for module in (hil_hardware, hil_link):
        monkeypatch.setattr(module, "TIMEOUT", 0.2)
    pair.frame(state(), sensor())
    pair.simulator.received()
    leave(pair.simulator.stream)
    with pytest.raises(LockstepError, match=f"^{words}$"):
        next(pair.ticks)


def test_who_is_asked_to_stop_says_farewell(pair: Pair) -> None:
    asked: list[bool] = []
    ticks = iter(HilSchedule(pair.hardware, pair.link, DT_NS, lambda: bool(asked)))
    pair.simulator.send(state(), sensor())
    assert next(ticks).k == 0
    asked.append(True)
    assert list(ticks) == []
    last = pair.simulator.received()[-1]
    assert (last.get_type(), last.system_status) == ("HEARTBEAT", mav.MAV_STATE_POWEROFF)
