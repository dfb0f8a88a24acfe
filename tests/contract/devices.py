"""What each device says, in pydronecan's words, and what the vehicle's frame shall hold of it."""

from __future__ import annotations

import dataclasses
import math

import dronecan

from firmware_py.records.sensing import Ahrs, Battery, Fix, Hardpoint, SensorFrame, silence

from .vehicle import FINS

NAN = math.nan
HALF = math.sqrt(0.5)
UAVCAN = dronecan.uavcan.equipment


def solution(quaternion=(0.0, 0.0, 0.0, 1.0), rates=(0.0, 0.0, 0.0)):
    return UAVCAN.ahrs.Solution(
        orientation_xyzw=list(quaternion), angular_velocity=list(rates), linear_acceleration=[NAN] * 3
    )


def pressure(pascal):
    return UAVCAN.air_data.StaticPressure(static_pressure=pascal, static_pressure_variance=2500.0)


def distance(metres, reading=1, which=0):
    return UAVCAN.range_sensor.Measurement(reading_type=reading, sensor_type=1, range=metres, sensor_id=which)


def fix(latitude_deg=36.6, longitude_deg=-121.9, status=3, covariance=(4.0, 4.0, 9.0, 1.0, 1.0, 1.0), pdop=0.0):
    return UAVCAN.gnss.Fix2(
        latitude_deg_1e8=round(latitude_deg * 1e8),
        longitude_deg_1e8=round(longitude_deg * 1e8),
        status=status,
        covariance=list(covariance),
        pdop=pdop,
    )


def fin(actuator_id, position):
    return UAVCAN.actuator.Status(actuator_id=actuator_id, position=position, force=NAN, speed=0.4)


def propeller(rpm, index=0):
    return UAVCAN.esc.Status(rpm=rpm, esc_index=index, voltage=48.0, current=3.0, temperature=300.0)


def battery(voltage=48.0, current=3.0, charge=90, which=0):
    return UAVCAN.power.BatteryInfo(voltage=voltage, current=current, state_of_charge_pct=charge, battery_id=which)


def hardpoint(status, load=NAN, which=0):
    return UAVCAN.hardpoint.Status(hardpoint_id=which, payload_weight=load, payload_weight_variance=NAN, status=status)


def humidity(percent, which=0):
    return dronecan.dronecan.sensors.hygrometer.Hygrometer(temperature=20.0, humidity=percent, id=which)


GOOD = {
    "ahrs level north": ("ahrs", lambda: solution(), "ahrs", Ahrs(0, 0, 0, 0, 0, 0)),
    "ahrs rolled to starboard": (
        "ahrs",
        lambda: solution((math.sin(0.15), 0.0, 0.0, math.cos(0.15))),
        "ahrs",
        Ahrs(0.3, 0, 0, 0, 0, 0),
    ),
    "ahrs nose up": (
        "ahrs",
        lambda: solution((0.0, math.sin(0.1), 0.0, math.cos(0.1))),
        "ahrs",
        Ahrs(0, 0.2, 0, 0, 0, 0),
    ),
    "ahrs heading east, turning": (
        "ahrs",
        lambda: solution((0.0, 0.0, HALF, HALF), (0.5, -0.25, 0.125)),
        "ahrs",
        Ahrs(0, 0, math.pi / 2, 0.5, -0.25, 0.125),
    ),
    "ahrs that does not normalise": (
        "ahrs",
        lambda: solution((0.0, 0.0, 2.0, -2.0)),
        "ahrs",
        Ahrs(0, 0, -math.pi / 2, 0, 0, 0),
    ),
    "pressure": ("pressure", lambda: pressure(151_325.0), "pressure", 151_325.0),
    "altimeter": ("altimeter", lambda: distance(12.5), "altitude", 12.5),
    "fix": ("fix", fix, "fix", Fix(0.6387905062299245, -2.1275563581810113, 2.0)),
    "propeller ahead": ("esc", lambda: propeller(500), "n", 500 / 60),
    "propeller astern": ("esc", lambda: propeller(-600), "n", -10.0),
    "battery": ("battery", battery, "battery", Battery(48.0, 3.0, 0.9)),
    "hardpoint that holds": ("hardpoint", lambda: hardpoint(2, 1335.0), "hardpoint", Hardpoint(True, 1335.0)),
    "hardpoint that is open": ("hardpoint", lambda: hardpoint(0, 0.0), "hardpoint", Hardpoint(False, 0.0)),
    "hygrometer": ("battery", lambda: humidity(35.0), "leak", 0.35),
}


def fields(frame: SensorFrame) -> dict[str, object]:
    """The frame as text per field, so that NaN equals NaN."""
    return {field.name: repr(getattr(frame, field.name)) for field in dataclasses.fields(frame)}


NOTHING = fields(silence(FINS))
