"""The plant's end of the simulator interface, with an autopilot that is nothing but pymavlink on a socket."""

from __future__ import annotations

import dataclasses
import math
import socket
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mav

from firmware_py.adapters.buses.can_bus import open_bus
from firmware_py.adapters.hil.hil_link import HilLink
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.lockstep.lockstep_link import LockstepError
from firmware_py.marine import GRAVITY, Eta, Nu, Origin, euler_from_quaternion
from firmware_py.params import ParamError, load
from sim_bridge import build, hil_server
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.instruments import Instruments, Water
from sim_bridge.devices.serial_line import SerialLine
from sim_bridge.faults.sensor_faults import changed, not_a_number
from sim_bridge.hil_messages import specific_force
from sim_bridge.hil_server import HilDevices, HilServer, refuse_faults, time_at
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario, parse

CONFIGS = Path(__file__).resolve().parents[3] / "configs" / "npsauv2"
BASE_HZ, DT_NS = 100, 10_000_000
ORIGIN = Origin(math.radians(36.8), math.radians(-121.8))
TRAVEL, N_MAX = math.radians(23.0), 1000.0 / 60.0
GYRO, PRESSURE = 0x38, 0x200
SCENARIO = """
description = "Under way."
completes = "time"
duration_s = 60.0
[environment]
current_ned_m_s = [0.1, -0.05, 0.0]
turbulence_m_s = 0.05
[start]
depth_m = 5.0
u_m_s = 1.8
n_rpm = 492.0
"""


def sensors(quiet: bool) -> DevicesParams:
    table = tomllib.loads((CONFIGS / "sensors.toml").read_text())
    if quiet:
        for name, keys in table.items():
            table[name] = {
                key: 0.0 if "noise" in key or "bias" in key or key == "dropout" else x for key, x in keys.items()
            }
    return load(DevicesParams, table, "sensors.toml")


def truth() -> Truth:
    return load(Truth, tomllib.loads((CONFIGS / "truth.toml").read_text()), "truth.toml")


def scenario(text: str = SCENARIO) -> Scenario:
    return parse(tomllib.loads(text), "a test")


class Simulator:
    """Devices around a plant that stands where a test puts it, and the bare socket of an autopilot."""

    def __init__(self, quiet: bool = True) -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            ours = socket.create_connection(server.getsockname())
            self.autopilot, _ = server.accept()
        self.link = HilLink(ours, 1, vehicle=False)
        self.mav = mav.MAVLink(None, srcSystem=9)
        params = dataclasses.replace(sensors(quiet), ahrs=dataclasses.replace(sensors(quiet).ahrs, latency=0.0))
        self.plant = SimpleNamespace(
            dt=1.0 / BASE_HZ,
            eta=Eta(0.0, 0.0, 5.0, 0.0, 0.0, 0.0),
            nu=Nu(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            nu_dot=(0.0,) * 6,
            n=0.0,
            altitude=20.0,
            drop_weight=0.0,
        )
        self.instruments = Instruments(params, Water(1000.0, 101_325.0, ORIGIN), 1, BASE_HZ)
        self.devices = HilDevices(params, self.instruments, ORIGIN, self.link, 4, BASE_HZ)

    def says(self, first: int = 0, last: int = 1) -> dict[str, list]:
        """What the autopilot hears of these ticks, by type."""
        heard: dict[str, list] = {}
        for k in range(first, last):
            self.devices.publish(k, k / BASE_HZ, self.plant)
            for message in self.mav.parse_buffer(self.autopilot.recv(65536)):
                heard.setdefault(message.get_type(), []).append(message)
        return heard

    def tell(self, *messages) -> None:
        self.autopilot.sendall(b"".join(message.pack(self.mav) for message in messages))

    def close(self) -> None:
        self.link.close()
        self.autopilot.close()


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    made = Simulator()
    yield made
    made.close()


def controls(k: int = 0, *, fins=(0.0, 0.0, 0.0, 0.0), n: float = 0.0, mode: int = 129, flags: int = 1):
    return mav.MAVLink_hil_actuator_controls_message(time_at(k / BASE_HZ), (*fins, n, *(0.0,) * 11), mode, flags)


def test_hil_sensor_ends_every_tick_and_says_its_time(simulator: Simulator) -> None:
    for k in range(3):
        simulator.devices.publish(k, k / BASE_HZ, simulator.plant)
        *_, last = simulator.mav.parse_buffer(simulator.autopilot.recv(65536))
        assert last.get_type() == "HIL_SENSOR"
        assert last.time_usec == 10_000_000 + 10_000 * k


SLOW = ("DISTANCE_SENSOR", "HIL_GPS", "BATTERY_STATUS", "NAMED_VALUE_FLOAT", "HEARTBEAT")


def test_each_instrument_speaks_at_its_rate(simulator: Simulator) -> None:
    heard = simulator.says(0, 100)
    updated = [message.fields_updated for message in heard["HIL_SENSOR"]]
    assert len(updated) == len(heard["HIL_STATE_QUATERNION"]) == 100
    assert sum(bits & GYRO == GYRO for bits in updated) == 100
    assert sum(bits & PRESSURE == PRESSURE for bits in updated) == 20
    assert {name: len(heard[name]) for name in SLOW} == {
        "DISTANCE_SENSOR": 10,
        "HIL_GPS": 1,
        "BATTERY_STATUS": 1,
        "NAMED_VALUE_FLOAT": 1,
        "HEARTBEAT": 1,
    }


def test_rates_and_pressure_are_in_the_units_of_the_message(simulator: Simulator) -> None:
    simulator.plant.nu = Nu(1.8, 0.0, 0.0, 0.01, -0.02, 0.05)
    (sensor,) = simulator.says()["HIL_SENSOR"]
    assert (sensor.xgyro, sensor.ygyro, sensor.zgyro) == pytest.approx((0.01, -0.02, 0.05))
    assert sensor.abs_pressure == pytest.approx(1013.25 + 5.0 * 1000.0 * GRAVITY / 100.0)


@pytest.mark.parametrize(
    ("phi", "theta", "force"),
    [
        (0.0, 0.0, (0.0, 0.0, -GRAVITY)),
        (0.0, math.pi / 2, (GRAVITY, 0.0, 0.0)),  # nose up: what holds it pushes forward
        (math.pi / 2, 0.0, (0.0, -GRAVITY, 0.0)),
    ],
)
def test_the_accelerometer_at_rest_feels_what_holds_it(simulator: Simulator, phi: float, theta: float, force) -> None:
    simulator.plant.eta = Eta(0.0, 0.0, 5.0, phi, theta, 1.0)
    (sensor,) = simulator.says()["HIL_SENSOR"]
    assert (sensor.xacc, sensor.yacc, sensor.zacc) == pytest.approx(force, abs=1e-5)


@pytest.mark.parametrize(
    ("velocity", "rates", "force"),
    [
        ((2.0, 0.0, 0.0), (0.0, 0.0, 0.1), (0.0, 0.2, 0.0)),  # to starboard, as it turns
        ((2.0, 0.0, 0.5), (0.0, 0.1, 0.0), (0.05, 0.0, -0.2)),  # pitching up
        ((0.0, 1.0, 0.5), (0.3, 0.0, 0.1), (-0.1, -0.15, 0.3)),
    ],
)
def test_the_accelerometer_in_a_steady_turn_feels_the_centripetal_force(velocity, rates, force) -> None:
    plant = SimpleNamespace(eta=Eta(0.0, 0.0, 5.0, 0.0, 0.0, 0.0), nu=Nu(*velocity, *rates), nu_dot=(0.0,) * 6)
    felt = specific_force(plant)
    assert felt == pytest.approx((*force[:2], force[2] - GRAVITY))  # omega x v, and what holds it up


@pytest.mark.parametrize("psi", [0.0, 1.0, -2.5])
def test_the_magnetometer_shows_north_and_dips_in_the_north(simulator: Simulator, psi: float) -> None:
    simulator.plant.eta = Eta(0.0, 0.0, 5.0, 0.0, 0.0, psi)
    (sensor,) = simulator.says()["HIL_SENSOR"]
    assert math.atan2(-sensor.ymag, sensor.xmag) == pytest.approx(psi, abs=1e-6)
    assert sensor.zmag == pytest.approx(2.0 * math.tan(ORIGIN.latitude) * math.hypot(sensor.xmag, sensor.ymag))
    assert math.sqrt(sensor.xmag**2 + sensor.ymag**2 + sensor.zmag**2) == pytest.approx(0.48, abs=0.06)  # Monterey


def test_the_state_is_the_truth(simulator: Simulator) -> None:
    simulator.plant.eta = Eta(100.0, 200.0, 7.5, 0.1, -0.2, 2.0)
    simulator.plant.nu = Nu(1.8, 0.0, 0.0, 0.01, 0.02, 0.03)
    (state,) = simulator.says()["HIL_STATE_QUATERNION"]
    w, x, y, z = state.attitude_quaternion
    assert euler_from_quaternion(x, y, z, w) == pytest.approx((0.1, -0.2, 2.0), abs=1e-6)
    assert (state.rollspeed, state.pitchspeed, state.yawspeed) == pytest.approx((0.01, 0.02, 0.03))
    along = 180.0 * math.cos(-0.2)
    expected = (along * math.cos(2.0), along * math.sin(2.0), -180.0 * math.sin(-0.2))
    assert (state.vx, state.vy, state.vz) == pytest.approx(expected, abs=0.5)
    assert state.alt == -7500
    assert (state.lat * 1e-7 - 36.8) * 111_000 == pytest.approx(100.0, rel=0.01)
    assert (state.lon * 1e-7 + 121.8) * 111_320 * math.cos(ORIGIN.latitude) == pytest.approx(200.0, rel=0.01)


def test_a_fix_comes_at_the_surface_alone(simulator: Simulator) -> None:
    (under,) = simulator.says(0, 1)["HIL_GPS"]
    assert (under.fix_type, under.eph) == (1, 65535)
    simulator.plant.eta = Eta(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    simulator.plant.nu = Nu(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    (above,) = simulator.says(100, 101)["HIL_GPS"]
    assert (above.fix_type, above.lat, above.lon) == (3, 368_000_000, -1_218_000_000)
    assert (above.vn, above.ve, above.vel, above.cog) == (100, 0, 100, 0)
    assert above.time_usec == 11_000_000


@pytest.mark.parametrize(("altitude", "cm", "quality"), [(12.34, 1234, 100), (0.1, 0, 1), (75.0, 6001, 1)])
def test_the_distance_to_the_bottom_and_none(simulator: Simulator, altitude: float, cm: int, quality: int) -> None:
    simulator.plant.altitude = altitude
    (message,) = simulator.says()["DISTANCE_SENSOR"]
    assert (message.current_distance, message.signal_quality) == (cm, quality)
    assert (message.min_distance, message.max_distance, message.orientation) == (30, 6000, 25)


def test_noise_is_that_of_sensors_toml() -> None:
    simulator = Simulator(quiet=False)
    heard = simulator.says(0, 3000)
    rates = np.array([message.xgyro for message in heard["HIL_SENSOR"]])
    assert np.degrees(rates.std()) == pytest.approx(0.05, rel=0.1)
    pascals = 100.0 * np.array([m.abs_pressure for m in heard["HIL_SENSOR"] if m.fields_updated & PRESSURE])
    assert pascals.std() == pytest.approx(50.0, rel=0.15)
    assert {tuple(message.attitude_quaternion) for message in heard["HIL_STATE_QUATERNION"]} == {(1.0, 0.0, 0.0, 0.0)}
    simulator.close()


def test_the_control_after_the_propeller_releases_the_drop_weight_armed_or_not(simulator: Simulator) -> None:
    for mode in (129, 1):
        message = controls(mode=mode)
        message.controls = (*message.controls[:5], 0.4, *message.controls[6:])
        simulator.devices.accept_command(message)
        assert not simulator.devices.released
    message.controls = (*message.controls[:5], 1.0, *message.controls[6:])
    simulator.devices.accept_command(message)
    simulator.devices.accept_command(controls())
    assert simulator.devices.released


@pytest.mark.parametrize(
    ("message", "fins", "n"),
    [
        (controls(fins=(1.0, -1.0, 0.5, 0.0), n=0.5), (TRAVEL, -TRAVEL, 0.5 * TRAVEL, 0.0), 0.5 * N_MAX),
        (controls(fins=(2.0, -math.inf, 0.0, 0.0), n=-3.0), (TRAVEL, -TRAVEL, 0.0, 0.0), -N_MAX),
        (controls(fins=(math.nan, 0.5, 0.0, 0.0), n=math.nan), (0.0, 0.5 * TRAVEL, 0.0, 0.0), 0.0),
        (controls(fins=(1.0, 1.0, 1.0, 1.0), n=1.0, mode=1), (0.0,) * 4, 0.0),  # not armed
    ],
)
def test_controls_are_shares_of_full_scale(simulator: Simulator, message, fins, n: float) -> None:
    simulator.devices.accept_command(controls(fins=(0.3,) * 4, n=0.3))
    simulator.devices.accept_command(message)
    told = simulator.devices.commands(0.0, (0.0,) * 4)
    assert told[0] == pytest.approx(fins)
    assert told[1] == pytest.approx(n)


@pytest.mark.parametrize("device", ["ahrs", "pressure", "altimeter", "fix", "battery", "leak"])
def test_what_has_no_power_is_not_heard(simulator: Simulator, device: str) -> None:
    simulator.devices.switch_off(device)
    heard = simulator.says()
    bits = heard["HIL_SENSOR"][0].fields_updated
    silent = {
        "ahrs": not bits & GYRO,
        "pressure": not bits & PRESSURE,
        "altimeter": "DISTANCE_SENSOR" not in heard,
        "fix": "HIL_GPS" not in heard,
        "battery": "BATTERY_STATUS" not in heard,
        "leak": "NAMED_VALUE_FLOAT" not in heard,
    }
    assert [name for name, is_silent in silent.items() if is_silent] == [device]


def test_a_dvl_cannot_be_switched_off_where_there_is_none() -> None:
    for fault in (
        "off:dvl@10",
        "late:dvl=1@10",
        "nan:dvl@10",  # a velocity in whole numbers is always one
        "late:ahrs=1@10",
        "babble:bus=100@10",
        "jump:clock=1@10",
    ):
        with pytest.raises(ParamError, match=f"fault {fault}: mavlink-hil has no"):
            refuse_faults(dataclasses.replace(scenario(), faults=(fault,)))


def test_a_simulator_with_a_drop_weight_says_what_hangs(simulator: Simulator) -> None:
    assert "WEIGHT" not in {value.name for value in simulator.says().get("NAMED_VALUE_FLOAT", ())}
    simulator.plant.drop_weight = 1335.0
    simulator.devices.initialise(simulator.plant)
    for left in (1335.0, 0.0):
        simulator.plant.drop_weight = left
        assert [m.value for m in simulator.says()["NAMED_VALUE_FLOAT"] if m.name == "WEIGHT"] == [left]


def test_leak_and_battery_at_a_time_are_told(simulator: Simulator) -> None:
    for name, humidity in (("leak", 1.0), ("battery", 0.05)):
        simulator.instruments.by_name[name].corruptions.append(changed(name, lambda _x, _t, value=humidity: value))
    heard = simulator.says()
    assert heard["NAMED_VALUE_FLOAT"][0].name == "LEAK"
    assert heard["NAMED_VALUE_FLOAT"][0].value == 1.0
    assert heard["BATTERY_STATUS"][0].battery_remaining == 5


def test_what_is_not_a_number_is_told_as_unknown(simulator: Simulator) -> None:
    simulator.plant.eta = Eta(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    for name in ("fix", "battery", "altimeter", "leak", "pressure"):
        simulator.instruments.by_name[name].corruptions.append(not_a_number(name))
    heard = simulator.says()
    assert (heard["HIL_GPS"][0].fix_type, heard["HIL_GPS"][0].eph) == (1, 65535)
    assert heard["BATTERY_STATUS"][0].battery_remaining == -1
    assert heard["DISTANCE_SENSOR"][0].signal_quality == 1
    assert math.isnan(heard["NAMED_VALUE_FLOAT"][0].value)
    assert math.isnan(heard["HIL_SENSOR"][0].abs_pressure)


@pytest.mark.parametrize(("charge", "percent"), [(1.0, 100), (3.0, 100), (-3.0, 0)])
def test_a_charge_beyond_what_a_battery_holds_is_told_as_full_or_empty(
    simulator: Simulator, charge: float, percent: int
) -> None:
    simulator.instruments.battery.corruptions.append(changed("battery", lambda _x, _t: charge))
    assert simulator.says()["BATTERY_STATUS"][0].battery_remaining == percent


def test_a_fix_beyond_the_earth_is_told_within_its_field(simulator: Simulator) -> None:
    simulator.plant.eta = Eta(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    simulator.instruments.fix.corruptions.append(changed("fix.north", lambda _x, _t: 1e9))
    assert simulator.says()["HIL_GPS"][0].lat == 2**31 - 1


def test_a_biased_attitude_and_velocity_are_told_in_place_of_the_truth(simulator: Simulator) -> None:
    before = simulator.says()["HIL_STATE_QUATERNION"][0]
    ahrs, dvl = simulator.instruments.ahrs, simulator.instruments.dvl
    ahrs.corruptions.append(changed("ahrs.yaw", lambda psi, _t: psi + math.pi / 2.0))
    dvl.corruptions.append(changed("dvl.u", lambda u, _t: u + 1.0))
    after = simulator.says()["HIL_STATE_QUATERNION"][0]
    yaw = [2.0 * math.atan2(said.attitude_quaternion[3], said.attitude_quaternion[0]) for said in (before, after)]
    assert yaw[1] - yaw[0] == pytest.approx(math.pi / 2.0, abs=1e-3)
    assert math.hypot(after.vx - before.vx, after.vy - before.vy) > 90.0  # cm/s


def test_plant_and_environment_are_those_of_a_bus() -> None:
    simulator = Simulator()
    behind_mavlink, _ = hil_server.build_hil_bridge(truth(), sensors(False), scenario(), simulator.link, 3, BASE_HZ)
    io = load(IoParams, tomllib.loads((CONFIGS / "io_sitl.toml").read_text()), "io_sitl.toml")
    wired = build.wiring(io, truth())
    line, bus = SerialLine(), open_bus("virtual", "the-same-simulator")
    on_a_bus = build.build_bridge(truth(), sensors(False), wired, scenario(), bus, [line], 3, BASE_HZ, autopilot_id=10)
    for k in range(300):
        for bridge in (behind_mavlink, on_a_bus):
            bridge.step(k)
        simulator.autopilot.recv(65536)
    assert behind_mavlink.truth() == on_a_bus.truth()
    assert behind_mavlink.truth().current != (0.1, -0.05, 0.0)
    bus.close()
    line.close()
    simulator.close()


def advance(simulator: Simulator, *messages, k: int = 0) -> bool:
    """Whether a tick was played when the autopilot had answered so."""
    simulator.tell(*messages)
    server = HilServer(lambda _: None, simulator.devices, simulator.link, DT_NS)
    return server.advance(k, lambda: False)


def test_a_tick_is_over_when_it_is_answered(simulator: Simulator) -> None:
    assert advance(simulator, mav.MAVLink_heartbeat_message(12, 0, 0, 0, 4, 3), controls(7, n=0.5), k=7)
    assert simulator.devices.commands(0.0, ())[1] == pytest.approx(0.5 * N_MAX)


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (controls(6), "the vehicle answered 10060000 us when it was 10070000 us"),
        (controls(7, flags=0), "the vehicle does not fly in lockstep"),
    ],
)
def test_another_answer_ends_the_run(simulator: Simulator, message, words: str) -> None:
    with pytest.raises(LockstepError, match=words):
        advance(simulator, message, k=7)


def test_a_vehicle_that_says_farewell_ends_the_run(simulator: Simulator) -> None:
    assert not advance(simulator, mav.MAVLink_heartbeat_message(12, 0, 0, 0, mav.MAV_STATE_POWEROFF, 3))


def test_a_vehicle_that_is_gone_is_named(simulator: Simulator) -> None:
    simulator.autopilot.close()
    with pytest.raises(LockstepError, match="the vehicle has closed the connection, at tick 5: was it ended"):
        HilServer(lambda _: None, simulator.devices, simulator.link, DT_NS).advance(5, lambda: False)
