"""What the messages say of a cycle: units, signs, unknowns, and when they say it."""

from __future__ import annotations

import collections
import dataclasses
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from firmware_py.marine import Eta, Nu
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.records.command import Applied
from firmware_py.records.estimate import NOTHING_LEARNED, Learned
from firmware_py.records.health import (
    ALL_GOOD,
    ActuatorFault,
    ActuatorHealth,
    SensorHealth,
    SourceFault,
    SourceHealth,
    SourceState,
    sound,
)
from firmware_py.records.order import Mode
from firmware_py.records.sensing import Battery, Heard, silence
from tests.unit.firmware_py.mavlink.station import LEARNED, NAMES, ORIGIN, cycle, frame, heard, node, parse, told


def reports(vehicle, cycles) -> list:
    return [message for each in cycles for message in parse(vehicle.report(each)[0])]


def test_attitude_is_in_radians_about_the_bodys_axes() -> None:
    said = told(eta=Eta(0, 0, 5, 0.1, -0.2, 3.0 + math.tau), nu=Nu(0, 0, 0, 0.01, 0.02, -0.03))["ATTITUDE"]
    assert (said.roll, said.pitch, said.yaw) == pytest.approx((0.1, -0.2, 3.0))
    assert (said.rollspeed, said.pitchspeed, said.yawspeed) == pytest.approx((0.01, 0.02, -0.03))
    assert said.time_boot_ms == 900


def test_a_place_north_and_east_of_the_origin_is_there_on_the_globe() -> None:
    # One minute of arc along a meridian at 46.5 deg is 1852.5 m (WGS-84), and across it 1279.5 m.
    said = told(eta=Eta(1852.5, 1279.5, 5.0, 0, 0, 0))["GLOBAL_POSITION_INT"]
    assert said.lat / 1e7 - math.degrees(ORIGIN.latitude) == pytest.approx(1 / 60, rel=1e-3)
    assert said.lon / 1e7 - math.degrees(ORIGIN.longitude) == pytest.approx(1 / 60, rel=1e-3)


@pytest.mark.parametrize(
    ("psi", "centidegrees", "degrees"), [(0.0, 0, 0), (-math.pi / 2, 27000, 270), (-1e-6, 0, 0), (7.0, 4107, 41)]
)
def test_heading_is_a_compass_reading(psi: float, centidegrees: int, degrees: int) -> None:
    said = told(eta=Eta(0, 0, 5, 0, 0, psi))
    assert said["GLOBAL_POSITION_INT"].hdg == centidegrees
    assert said["VFR_HUD"].heading == degrees


@pytest.mark.parametrize(
    ("north", "east", "speed", "compass"),
    [(0.6, 0.0, 3, 0), (0.0, 0.6, 3, 90), (0.0, -0.6, 3, 270), (-0.6, 0.8, 5, 126), (math.nan, math.nan, 0, 0)],
)
def test_high_latency_says_the_current_as_wind_towards_where_it_sets(
    north: float, east: float, speed: int, compass: int
) -> None:
    vehicle = node(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
    learned = dataclasses.replace(LEARNED, current=(north, east))
    (said,) = parse(vehicle.report(cycle(0, learned=learned))[0])
    assert said.windspeed == speed  # 0.2 m/s
    assert said.wind_heading * 2 == compass


def test_fins_and_propeller_are_commanded_in_pulses_and_reported_in_radians() -> None:
    applied = Applied((0.4, -0.4, 0.2, 0.0), -5.0, armed=True, limited=False)
    said = told(applied=applied)
    servo = said["SERVO_OUTPUT_RAW"]
    assert [servo.servo1_raw, servo.servo2_raw, servo.servo3_raw, servo.servo4_raw] == [2000, 1000, 1750, 1500]
    assert servo.servo5_raw == 1250
    assert (servo.servo6_raw, servo.servo16_raw) == (0, 0)
    assert said["fins"].data[:4] == pytest.approx((0.1, -0.1, 0.2, -0.2))
    assert said["RPM"].rpm1 == 300.0
    assert said["VFR_HUD"].throttle == 50


def test_a_fin_that_fell_silent_is_unknown_and_makes_the_motors_unhealthy() -> None:
    sensors = frame(1.0)
    sensors = dataclasses.replace(sensors, fins=(heard(0.1, -5.0), *sensors.fins[1:]))
    said = told(sensors=sensors)
    angles = said["fins"].data
    assert math.isnan(angles[0])
    assert angles[1] == pytest.approx(-0.1)
    assert not said["SYS_STATUS"].onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS


@pytest.mark.parametrize(
    "actuators",
    [
        ActuatorHealth((ActuatorFault.NONE, ActuatorFault.JAMMED, *[ActuatorFault.NONE] * 2), ActuatorFault.NONE),
        ActuatorHealth((ActuatorFault.NONE,) * 4, ActuatorFault.LOST),
    ],
)
def test_a_fault_of_a_fin_or_of_the_propeller_makes_the_motors_unhealthy(actuators: ActuatorHealth) -> None:
    bit = mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
    for health, healthy in ((sound(4), True), (actuators, False)):
        status = told(actuators=health)["SYS_STATUS"]
        assert status.onboard_control_sensors_present & status.onboard_control_sensors_enabled & bit
        assert bool(status.onboard_control_sensors_health & bit) is healthy
        vehicle = node(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
        (short,) = parse(vehicle.report(cycle(actuators=health))[0])
        assert bool(short.failure_flags & mavlink.HL_FAILURE_FLAG_ENGINE) is not healthy


@pytest.mark.parametrize("state", [SourceState.SUSPECT, SourceState.LOST])
@pytest.mark.parametrize(
    ("sensor", "bit"),
    [
        ("ahrs", mavlink.MAV_SYS_STATUS_AHRS | mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO),
        ("dvl", mavlink.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL),
        ("pressure", mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE),
        ("altitude", mavlink.MAV_SYS_STATUS_SENSOR_LASER_POSITION),
        ("fix", mavlink.MAV_SYS_STATUS_SENSOR_GPS),
        ("battery", mavlink.MAV_SYS_STATUS_SENSOR_BATTERY),
    ],
)
def test_a_sensor_that_is_not_believed_is_unhealthy_and_no_other(sensor: str, bit: int, state: SourceState) -> None:
    sound, failed = (
        status_with(ALL_GOOD._replace(**{sensor: SourceHealth(one, fault)}))
        for one, fault in ((SourceState.GOOD, SourceFault.NONE), (state, SourceFault.FROZEN))
    )
    assert sound.onboard_control_sensors_health & bit == bit
    assert sound.onboard_control_sensors_health & ~failed.onboard_control_sensors_health == bit
    assert failed.onboard_control_sensors_present == sound.onboard_control_sensors_present
    assert failed.onboard_control_sensors_health_extended == sound.onboard_control_sensors_health_extended


def test_a_leak_sensor_that_is_not_believed_is_unhealthy() -> None:
    lost = ALL_GOOD._replace(leak=SourceHealth(SourceState.LOST, SourceFault.SILENT))
    assert status_with(ALL_GOOD).onboard_control_sensors_health_extended & 0x02
    assert not status_with(lost).onboard_control_sensors_health_extended & 0x02


def status_with(sensors: SensorHealth) -> Any:
    """SYS_STATUS of a vehicle that hears all and believes so much of it."""
    vehicle, state = node(), {"sensors": sensors, "attitude_ok": True, "depth_ok": True, "velocity_ok": True}
    cycles = [cycle(k) for k in range(100)]
    told = reports(vehicle, [dataclasses.replace(c, state=dataclasses.replace(c.state, **state)) for c in cycles])
    return [message for message in told if message.get_type() == "SYS_STATUS"][-1]


def test_the_battery_is_told_in_millivolts_centiamperes_and_percent() -> None:
    said = told(late=3)
    status, battery = said["SYS_STATUS"], said["BATTERY_STATUS"]
    assert (status.voltage_battery, status.current_battery, status.battery_remaining) == (48000, 300, 80)
    assert status.errors_count1 == 3
    assert battery.voltages == [48000, *[65535] * 9]
    assert (battery.current_battery, battery.battery_remaining) == (300, 80)
    assert (battery.current_consumed, battery.energy_consumed, battery.temperature) == (-1, -1, 32767)


def test_a_voltage_beyond_one_cells_field_goes_on_in_the_next() -> None:
    sensors = dataclasses.replace(frame(), battery=heard(Battery(150.0, 3.0, 0.8)))
    cells = told(sensors=sensors)["BATTERY_STATUS"].voltages
    assert cells == [65534, 65534, 150_000 - 2 * 65534, *[65535] * 7]


@pytest.mark.parametrize(("t_valid", "ok"), [(-2.5, True), (0.0, False)], ids=["silent", "not sound"])
def test_a_battery_whose_monitor_is_silent_or_not_sound_is_unknown(t_valid: float, ok: bool) -> None:
    battery = Heard(Battery(48.0, 3.0, 0.8), t_valid, False, ok)
    for sensors, known in ((frame(), True), (dataclasses.replace(frame(), battery=battery), False)):
        said = told(sensors=sensors)
        status, each = said["SYS_STATUS"], said["BATTERY_STATUS"]
        expected = (48000, 300, 80) if known else (65535, -1, -1)
        assert (status.voltage_battery, status.current_battery, status.battery_remaining) == expected
        assert (each.voltages[0], each.current_battery, each.battery_remaining) == expected
        vehicle = node(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
        (short,) = parse(vehicle.report(cycle(sensors=sensors))[0])
        assert short.battery == expected[2]
        assert bool(short.failure_flags & mavlink.HL_FAILURE_FLAG_BATTERY) is not known


@pytest.mark.parametrize(("remaining", "believed", "failed"), [
    (0.8, True, False), (0.15, True, True), (math.nan, True, True), (0.8, False, True),
])  # fmt: skip
def test_a_charge_that_is_low_unknown_or_not_believed_is_a_failure_on_an_acoustic_link(
    remaining: float, believed: bool, failed: bool
) -> None:
    one = cycle(sensors=dataclasses.replace(frame(), battery=heard(Battery(48.0, 3.0, remaining))))
    if not believed:
        sensors = one.state.sensors._replace(battery=SourceHealth(SourceState.SUSPECT, SourceFault.FROZEN))
        one = dataclasses.replace(one, state=dataclasses.replace(one.state, sensors=sensors))
    vehicle = node(configurations=[LinkConfiguration(Identity.ARDUSUB, high_latency=True)])
    (short,) = parse(vehicle.report(one)[0])
    assert bool(short.failure_flags & mavlink.HL_FAILURE_FLAG_BATTERY) is failed


def test_what_was_never_heard_is_unknown() -> None:
    said = told(sensors=silence(4))
    status = said["SYS_STATUS"]
    assert (status.voltage_battery, status.current_battery, status.battery_remaining) == (65535, -1, -1)
    assert said["BATTERY_STATUS"].voltages == [65535] * 10
    assert said["BATTERY_STATUS"].battery_remaining == -1
    assert math.isnan(said["RPM"].rpm1)
    assert math.isnan(said["SCALED_PRESSURE2"].press_abs)
    assert said["SYSTEM_TIME"].time_unix_usec == 0


def test_a_leak_is_the_extended_bit_two() -> None:
    for leak, health in ((False, 0x02), (True, 0x00)):
        status = told(leak=leak)["SYS_STATUS"]
        assert status.onboard_control_sensors_present & mavlink.MAV_SYS_STATUS_EXTENSION_USED
        assert status.onboard_control_sensors_enabled_extended & 0x02
        assert status.onboard_control_sensors_health_extended & 0x02 == health


def test_the_prearm_check_is_always_there_and_healthy_where_arming_would_be_granted() -> None:
    vehicle, bit = node(), mavlink.MAV_SYS_STATUS_PREARM_CHECK
    healths = []
    for k in range(300):
        now = cycle(k)
        now = dataclasses.replace(now, mode=dataclasses.replace(now.mode, ready=100 <= k < 200))
        for m in parse(vehicle.report(now)[0]):
            if m.get_type() == "SYS_STATUS":
                assert m.onboard_control_sensors_present & m.onboard_control_sensors_enabled & bit
                healths.append((k // 100, bool(m.onboard_control_sensors_health & bit)))
    assert set(healths) == {(0, False), (1, True), (2, False)}


def test_deeper_than_the_depth_limit_is_beyond_the_fence() -> None:
    vehicle, statuses = node(), []
    for k in range(300):
        deep = 100 <= k < 200
        for m in parse(vehicle.report(cycle(k, decided={"too_deep": deep}))[0]):
            if m.get_type() == "FENCE_STATUS":
                statuses.append((k // 100, m.breach_status, m.breach_type, m.breach_count))
    assert set(statuses) == {(0, 0, 0, 0), (1, 1, mavlink.FENCE_BREACH_MINALT, 1), (2, 0, 0, 1)}


def test_a_place_that_is_not_known_is_not_said() -> None:
    said = told(eta=Eta(math.nan, 0.0, 5.0, 0.0, 0.0, 0.0))
    assert "GLOBAL_POSITION_INT" not in said
    assert "WATER_DEPTH" not in said
    assert math.isnan(said["LOCAL_POSITION_NED"].x)


@pytest.mark.parametrize(("identity", "autopilot", "which"), [(Identity.ARDUSUB, 3, 0), (Identity.GENERIC, 0, 1)])
@pytest.mark.parametrize(
    ("mode", "customs", "armed", "state"),  # ArduSub's number, and PX4's sub and main mode in one
    [
        (Mode.DISARMED, (19, 0x00010000), 0, mavlink.MAV_STATE_STANDBY),
        (Mode.MANUAL, (19, 0x00010000), 128, mavlink.MAV_STATE_ACTIVE),
        (Mode.HOLD, (2, 0x00020000), 128, mavlink.MAV_STATE_ACTIVE),
        (Mode.LOITER, (16, 0x03040000), 128, mavlink.MAV_STATE_ACTIVE),
        (Mode.GUIDED, (4, 0x00060000), 128, mavlink.MAV_STATE_ACTIVE),
        (Mode.MISSION, (3, 0x04040000), 128, mavlink.MAV_STATE_ACTIVE),
    ],
)
def test_the_heartbeat_is_a_submarines(identity, autopilot, which, mode, customs, armed, state) -> None:
    custom = customs[which]
    beats = reports(node(identities=(identity,)), [cycle(k, mode) for k in range(100)])
    (beat,) = [message for message in beats if message.get_type() == "HEARTBEAT"]
    assert (beat.get_srcSystem(), beat.get_srcComponent()) == (1, mavlink.MAV_COMP_ID_AUTOPILOT1)
    assert beat.type == 12
    assert beat.autopilot == autopilot
    assert (beat.custom_mode, beat.base_mode & 128, beat.system_status) == (custom, armed, state)
    assert beat.base_mode & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED


@pytest.mark.parametrize(
    ("before", "failsafe", "state"),
    [
        (Mode.MISSION, True, mavlink.MAV_STATE_CRITICAL),
        (Mode.MANUAL, True, mavlink.MAV_STATE_CRITICAL),
        (Mode.MISSION, False, mavlink.MAV_STATE_ACTIVE),
        (Mode.HOLD, False, mavlink.MAV_STATE_ACTIVE),
    ],
)
def test_surfacing_is_critical_if_a_failsafe_entered_it(before, failsafe, state) -> None:
    cycles = [
        cycle(0, before),
        *[cycle(k, Mode.SURFACE, decided={"failsafe": failsafe}) for k in range(1, 200)],
        *[cycle(k, Mode.DISARMED) for k in range(200, 300)],
    ]
    beats = [m for m in reports(node(), cycles) if m.get_type() == "HEARTBEAT"]
    assert [beat.system_status for beat in beats] == [state, state, mavlink.MAV_STATE_STANDBY]
    assert [beat.custom_mode for beat in beats] == [9, 9, 19]


@pytest.mark.parametrize("learned", [NOTHING_LEARNED, LEARNED], ids=["nothing", "learned"])
def test_each_message_comes_at_its_rate_and_no_tick_carries_two(learned: Learned) -> None:
    vehicle, counts, fullest = node(coefficients=NAMES), collections.Counter(), 0
    for k in range(1000):
        messages = parse(vehicle.report(cycle(k, learned=learned))[0])
        counts.update(message.get_type() for message in messages)
        fullest = max(fullest, len(messages))
    assert fullest == 1
    assert counts == {
        **dict.fromkeys(("HEARTBEAT", "SYS_STATUS", "BATTERY_STATUS", "SYSTEM_TIME", "WATER_DEPTH"), 10),
        **dict.fromkeys(("GPS_RAW_INT", "HOME_POSITION", "EXTENDED_SYS_STATE", "UNKNOWN_436"), 10),  # CURRENT_MODE
        **dict.fromkeys(("MISSION_CURRENT", "FENCE_STATUS"), 10),
        **dict.fromkeys(("VFR_HUD", "ALTITUDE", "RPM", "SCALED_PRESSURE2", "ESTIMATOR_STATUS"), 20),
        **dict.fromkeys(("DISTANCE_SENSOR", "NAV_CONTROLLER_OUTPUT"), 20),
        **dict.fromkeys(("LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "SERVO_OUTPUT_RAW"), 50),
        **dict.fromkeys(("SCALED_IMU", "ODOMETRY"), 50),
        **dict.fromkeys(("ATTITUDE", "DEBUG_FLOAT_ARRAY"), 100),
        **({"NAMED_VALUE_FLOAT": 50} if learned.value else {}),
    }


def test_frames_are_mavlink_2_numbered_in_sequence() -> None:
    vehicle = node()
    datagrams = [vehicle.report(cycle(k))[0] for k in range(1000)]
    frames = [datagram for datagram in datagrams if datagram]
    assert {datagram[0] for datagram in frames} == {0xFD}
    assert [datagram[4] for datagram in frames] == [i % 256 for i in range(len(frames))]


number = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=100)
@given(st.tuples(*[number] * 6), st.tuples(*[number] * 6), number, number)
def test_no_state_however_broken_makes_telling_it_fail(eta, nu, altitude, n) -> None:
    applied = Applied((n, altitude, 0.0, 0.0), n, armed=True, limited=False)
    sensors = dataclasses.replace(frame(), battery=heard(Battery(n, altitude, n)), pressure=heard(n), n=heard(n))
    vehicle = node()
    for k in range(50):
        parse(
            vehicle.report(cycle(k, eta=Eta(*eta), nu=Nu(*nu), altitude=altitude, applied=applied, sensors=sensors))[0]
        )


def test_what_is_beyond_a_fields_range_stands_at_its_end() -> None:
    applied = Applied((-4.0, 4.0, 0.0, 0.0), 0.0, armed=True, limited=False)
    said = told(nu=Nu(-1000.0, 1000.0, 0, 0, 0, 0), applied=applied)
    assert (said["GLOBAL_POSITION_INT"].vx, said["GLOBAL_POSITION_INT"].vy) == (-32767, 32767)
    assert (said["SERVO_OUTPUT_RAW"].servo1_raw, said["SERVO_OUTPUT_RAW"].servo2_raw) == (1000, 2000)
