"""Messages of devices: actuators, propellers, sensors, power.

Fields are those of the DSDL definitions, in the units of the wire; NaN is "unknown" where the definition says so.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple, TypeAlias

from firmware_py.wire.dronecan.dsdl_types import (
    UINT8,
    Integer,
    array,
    boolean,
    float16,
    float32,
    int5,
    int14,
    int18,
    int27,
    int36,
    int37,
    uint2,
    uint3,
    uint4,
    uint5,
    uint6,
    uint7,
    uint8,
    uint11,
    uint16,
    uint32,
    upto,
    usec,
    void,
)

Floats: TypeAlias = tuple[float, ...]
Ints: TypeAlias = tuple[int, ...]


class ActuatorCommand(NamedTuple):
    """One actuator's command: type 0 unitless in [-1, 1], 1 rad or m, 2 N or N m, 3 rad/s or m/s, 4 PWM us."""

    actuator_id: uint8
    command_type: uint8
    command_value: float16


class ArrayCommand(NamedTuple):
    """Commands to at most 15 actuators."""

    commands: Annotated[tuple[ActuatorCommand, ...], upto(ActuatorCommand, 15)]


class ActuatorStatus(NamedTuple):
    """State of an actuator: rad or m, N m or N, rad/s or m/s; power 127 is unknown. Ids repeat across nodes."""

    actuator_id: uint8
    position: float16
    force: float16
    speed: float16
    power_rating_pct: Annotated[int, void(1), Integer(7)] = 127


class RawCommand(NamedTuple):
    """Propellers: 8191 is full ahead."""

    cmd: Annotated[Ints, upto(int14, 20)]


class RpmCommand(NamedTuple):
    """Propellers: rpm, signed."""

    rpm: Annotated[Ints, upto(int18, 20)]


class EscStatus(NamedTuple):
    """A propeller's controller: V, A, K, rpm, % of its greatest power."""

    error_count: uint32
    voltage: float16
    current: float16
    temperature: float16
    rpm: int18
    power_rating_pct: uint7
    esc_index: uint5


class AhrsSolution(NamedTuple):
    """Attitude (quaternion x y z w), body rates (rad/s), acceleration (m/s^2)."""

    timestamp: usec
    orientation_xyzw: Annotated[Floats, array(float16, 4)]
    orientation_covariance: Annotated[Floats, void(4), upto(float16, 9)]
    angular_velocity: Annotated[Floats, array(float16, 3)]
    angular_velocity_covariance: Annotated[Floats, void(4), upto(float16, 9)]
    linear_acceleration: Annotated[Floats, array(float16, 3)]
    linear_acceleration_covariance: Annotated[Floats, upto(float16, 9)] = ()


class RawImu(NamedTuple):
    """Inertial samples: s, rad/s, rad, m/s^2, m/s."""

    timestamp: usec
    integration_interval: float32
    rate_gyro_latest: Annotated[Floats, array(float16, 3)]
    rate_gyro_integral: Annotated[Floats, array(float32, 3)]
    accelerometer_latest: Annotated[Floats, array(float16, 3)]
    accelerometer_integral: Annotated[Floats, array(float32, 3)]
    covariance: Annotated[Floats, upto(float16, 36)] = ()


class StaticPressure(NamedTuple):
    """Absolute pressure: Pa, Pa^2."""

    static_pressure: float32
    static_pressure_variance: float16


class CoarseOrientation(NamedTuple):
    """Direction in which a sensor looks: roll, pitch, yaw in units of 12 deg (4.7746482927568605 per rad)."""

    fixed_axis_roll_pitch_yaw: Annotated[Ints, array(int5, 3)] = (0, 0, 0)
    orientation_defined: boolean = False


class RangeMeasurement(NamedTuple):
    """A narrow beam: rad, m; sensor type 1 is a sonar, reading type 1 is valid, 2 too close, 3 too far."""

    timestamp: usec
    sensor_id: uint8
    beam_orientation_in_body_frame: CoarseOrientation
    field_of_view: float16
    sensor_type: uint5
    reading_type: uint3
    range: float16


class EcefPositionVelocity(NamedTuple):
    """Part of Fix2: m/s, mm."""

    velocity_xyz: Annotated[Floats, array(float32, 3)]
    position_xyz_mm: Annotated[Ints, array(int36, 3)]
    covariance: Annotated[Floats, void(6), upto(float16, 36)] = ()


class Fix2(NamedTuple):
    """A satellite fix; status 0 none, 1 time only, 2 2D, 3 3D."""

    timestamp: usec
    gnss_timestamp: usec
    gnss_time_standard: uint3
    num_leap_seconds: Annotated[int, void(13), UINT8]
    longitude_deg_1e8: int37
    latitude_deg_1e8: int37
    height_ellipsoid_mm: int27
    height_msl_mm: int27
    ned_velocity: Annotated[Floats, array(float32, 3)]
    sats_used: uint6
    status: uint2
    mode: uint4
    sub_mode: uint6
    covariance: Annotated[Floats, upto(float16, 36)]
    pdop: float16
    ecef_position_velocity: Annotated[tuple[EcefPositionVelocity, ...], upto(EcefPositionVelocity, 1)] = ()


class BatteryInfo(NamedTuple):
    """K, V, A, W, W h, W h, h; then state of charge and of health."""

    temperature: float16
    voltage: float16
    current: float16
    average_power_10sec: float16
    remaining_capacity_wh: float16
    full_charge_capacity_wh: float16
    hours_to_full_charge: float16
    status_flags: uint11
    state_of_health_pct: uint7
    state_of_charge_pct: uint7
    state_of_charge_pct_stdev: uint7
    battery_id: uint8
    model_instance_id: uint32
    model_name: Annotated[bytes, upto(uint8, 31)]


class HardpointCommand(NamedTuple):
    """What holds a load: command 0 releases it, 1 holds it."""

    hardpoint_id: uint8
    command: uint16


class HardpointStatus(NamedTuple):
    """State of a hardpoint: N, N^2; then as the command has it."""

    hardpoint_id: uint8
    payload_weight: float16
    payload_weight_variance: float16
    status: uint16


class CircuitStatus(NamedTuple):
    """A supply: V, A."""

    circuit_id: uint16
    voltage: float16
    current: float16
    error_flags: uint8


class Hygrometer(NamedTuple):
    """Air inside the hull: °C, relative humidity in %."""

    temperature: float16
    humidity: float16
    id: uint8


class ArmingStatus(NamedTuple):
    """0 is disarmed, 255 fully armed."""

    status: uint8


class SafetyState(NamedTuple):
    """The safety switch: 0 on, 255 off, which does not mean armed."""

    status: uint8
