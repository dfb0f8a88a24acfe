"""What the measuring devices say, as pydronecan understands it."""

from __future__ import annotations

import math

import pytest
import serial

from firmware_py.marine import Eta, Nu, Origin, euler_from_quaternion, local_to_geodetic
from firmware_py.wire.serial import waterlink_dvl

from .conftest import ORIGIN

EQUIPMENT = "uavcan.equipment."


def test_every_device_is_a_node_of_its_own_that_beats_once_a_second(launch):
    simulated, peer = launch()
    simulated.publish(0, 301)
    beats = {}
    for source, status in peer.hear("uavcan.protocol.NodeStatus"):
        beats.setdefault(source, []).append(status.uptime_sec)
        assert (status.health, status.mode) == (status.HEALTH_OK, status.MODE_OPERATIONAL)
    assert sorted(beats) == sorted(node.node_id for node in simulated.devices.nodes.values())
    assert len(beats) == 8
    assert all(uptimes == [0, 1, 2, 3] for uptimes in beats.values())


@pytest.mark.parametrize(
    ("name", "device", "rate"),
    [
        ("uavcan.equipment.ahrs.Solution", "ahrs", 100),
        ("uavcan.equipment.air_data.StaticPressure", "pressure", 20),
        ("uavcan.equipment.range_sensor.Measurement", "altimeter", 10),
        ("uavcan.equipment.gnss.Fix2", "fix", 1),
        ("uavcan.equipment.power.BatteryInfo", "battery", 1),
        ("dronecan.sensors.hygrometer.Hygrometer", "battery", 1),
        ("uavcan.equipment.actuator.Status", "servo_hub", 4 * 50),
        ("uavcan.equipment.esc.Status", "esc", 25),
    ],
)
def test_each_message_comes_from_its_node_at_its_rate_and_from_the_first_tick(launch, name, device, rate):
    simulated, peer = launch()
    simulated.publish(0)
    assert len(peer.hear(name)) == (4 if device == "servo_hub" else 1)
    simulated.publish(1, 100)
    simulated.publish(100, 200)
    heard = peer.hear(name)
    assert {source for source, _ in heard} == {simulated.devices.nodes[device].node_id}
    assert len(heard) == 2 * rate - (4 if device == "servo_hub" else 1)


@pytest.mark.parametrize("attitude", [(0.0, 0.0, 0.0), (0.2, -0.3, 1.0), (-0.5, 0.4, -3.0), (3.0, 1.2, 2.0)])
def test_ahrs_says_the_attitude_and_rates(launch, attitude):
    simulated, peer = launch()
    simulated.plant.eta = Eta(1.0, 2.0, 3.0, *attitude)
    simulated.plant.nu = Nu(1.0, 0.0, 0.0, 0.01, -0.02, 0.03)
    simulated.publish(0)
    [(_, solution)] = peer.hear(EQUIPMENT + "ahrs.Solution")
    assert euler_from_quaternion(*solution.orientation_xyzw) == pytest.approx(attitude, abs=2e-3)
    assert list(solution.angular_velocity) == pytest.approx([0.01, -0.02, 0.03], rel=1e-3)
    assert all(math.isnan(a) for a in solution.linear_acceleration)
    assert len(solution.orientation_covariance) == 0
    assert solution.timestamp.usec == 0


def test_pressure_is_absolute_and_good_to_a_millimetre(launch):
    simulated, peer = launch()
    simulated.plant.eta = simulated.plant.eta._replace(z=12.345)
    simulated.publish(0)
    [(_, message)] = peer.hear(EQUIPMENT + "air_data.StaticPressure")
    assert message.static_pressure == pytest.approx(101_325.0 + 12.345 * 9806.65, abs=9.8)


@pytest.mark.parametrize(
    ("altitude", "reading", "distance"), [(12.5, 1, 12.5), (0.1, 2, 0.0), (-2.0, 2, 0.0), (61.0, 3, None)]
)
def test_altimeter_says_whether_its_range_means_anything(launch, altitude, reading, distance):
    simulated, peer = launch()
    simulated.plant.altitude = altitude
    simulated.publish(0)
    [(_, message)] = peer.hear(EQUIPMENT + "range_sensor.Measurement")
    assert message.reading_type == reading
    assert message.sensor_type == message.SENSOR_TYPE_SONAR
    if distance is not None:
        assert message.range == pytest.approx(distance)


def test_fix_is_the_place_on_earth_at_the_surface_and_no_fix_below(launch):
    simulated, peer = launch()
    simulated.plant.eta = Eta(250.0, -130.0, 0.1, 0.0, 0.0, 0.0)
    simulated.publish(0)
    [(_, fix)] = peer.hear(EQUIPMENT + "gnss.Fix2")
    assert fix.status == fix.STATUS_3D_FIX
    place = Origin(*local_to_geodetic(ORIGIN, 250.0, -130.0))
    assert math.radians(fix.latitude_deg_1e8 * 1e-8) == pytest.approx(place.latitude, abs=1e-9)
    assert math.radians(fix.longitude_deg_1e8 * 1e-8) == pytest.approx(place.longitude, abs=1e-9)
    simulated.plant.eta = simulated.plant.eta._replace(z=2.0)
    simulated.publish(100)
    [(_, fix)] = peer.hear(EQUIPMENT + "gnss.Fix2")
    assert fix.status == fix.STATUS_NO_FIX
    assert fix.sats_used == 0
    assert len(fix.covariance) == 0


def test_fix_carries_its_variance(launch):
    simulated, peer = launch(fix={"noise_m": 2.0})
    simulated.plant.eta = simulated.plant.eta._replace(z=0.0)
    simulated.publish(0)
    [(_, fix)] = peer.hear(EQUIPMENT + "gnss.Fix2")
    assert list(fix.covariance)[:2] == [4.0, 4.0]
    assert fix.num_leap_seconds == 0


def test_battery_and_hull_are_in_the_units_of_the_standard(launch):
    simulated, peer = launch(battery={"charge_pct": 50.0})
    simulated.plant.n = 500 / 60
    simulated.publish(0)
    transfers = peer.listen()
    battery = next(t.payload for t in transfers if t.data_type_id == 1092)
    assert battery.remaining_capacity_wh == 1000.0
    assert battery.full_charge_capacity_wh == 2000.0
    assert battery.state_of_charge_pct == 50
    assert battery.current == pytest.approx((60 + 400) / (42 + 4.2), rel=1e-3)
    assert battery.voltage == pytest.approx(46.2 - 0.05 * battery.current, rel=1e-3)
    hull = next(t.payload for t in transfers if t.data_type_id == 1032)
    assert hull.humidity == 35.0


def test_an_unpowered_device_falls_silent_and_no_other(launch):
    simulated, peer = launch()
    simulated.devices.switch_off("ahrs")
    simulated.publish(0, 101)
    heard = {t.source_node_id for t in peer.listen()}
    assert heard == {node.node_id for name, node in simulated.devices.nodes.items() if name != "ahrs"}


@pytest.fixture
def pinged(launch):
    """Speaks some ticks and returns what the real driver reads of the DVL."""

    def make(change=lambda plant: None, ticks=31, **dvl):
        simulated, _ = launch(dvl=dvl)
        change(simulated.plant)
        with serial.Serial(simulated.line.path, 115200, timeout=0) as port:
            simulated.devices.initialise(simulated.plant)
            heard = []
            for k in range(ticks):
                simulated.publish(k)
                if port.in_waiting:
                    heard.append((k, port.read(4096)))
        return heard

    return make


def test_dvl_lines_reach_pyserial_whole_in_the_tick_that_delivers_them(pinged):
    def move(plant):
        plant.nu = Nu(1.8, -0.25, 0.125, 0.0, 0.0, 0.0)

    heard = pinged(move, latency_s=0.1)
    assert [k for k, _ in heard] == [10, 30]
    for _, line in heard:
        assert line.count(b"\r\n") == 1
        report = waterlink_dvl.decode(line.strip())
        assert (report.vx, report.vy, report.vz, report.valid, report.altitude) == (1.8, -0.25, 0.125, True, 20.0)
        assert report.time_of_transmission_us - report.time_of_validity_us == 100_000
    first, second = (waterlink_dvl.decode(line.strip()) for _, line in heard)
    assert second.time_of_validity_us - first.time_of_validity_us == 200_000
    assert second.time_ms == 200.0


def test_dvl_reads_over_water_too_deep_for_it_say_so(pinged):
    def deep(plant):
        plant.altitude = 50.5
        plant.nu = Nu(1.8, 0.0, 0.0, 0.0, 0.0, 0.0)

    for _, line in pinged(deep):
        report = waterlink_dvl.decode(line.strip())
        assert not report.valid
        assert (report.vx, report.vy, report.vz, report.altitude) == (0.0, 0.0, 0.0, -1.0)


def test_readings_under_way_at_the_start_are_delivered_in_time(pinged):
    heard = pinged(latency_s=0.3, ticks=50)
    assert [k for k, _ in heard] == [10, 30]
