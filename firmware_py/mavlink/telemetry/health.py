"""Messages on health: sensors, battery, leak, actuators, estimator and learned coefficients."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.scaling import INT16, UINT16, boot_ms, boot_us, boot_us32, whole
from firmware_py.mavlink.plans.plan_store import KNOWN_POSITION, PlanStore
from firmware_py.mavlink.telemetry.communication import Communication
from firmware_py.mavlink.telemetry.lateness import Lateness
from firmware_py.mavlink.telemetry.pose import Encoder
from firmware_py.records.adoption import Adopted
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import Learned
from firmware_py.records.fence import NO_FENCE
from firmware_py.records.health import FinEvidence, WeightState
from firmware_py.records.sensing import Battery
from firmware_py.tick import NS_PER_S

_RECENT = 2.0
"""A device that was last heard longer ago, s, counts as silent."""
_UNKNOWN_BATTERY = Battery(math.nan, math.nan, math.nan)
_PWM_CENTRE, _PWM_SPAN = 1500, 500
_SERVO_FIELDS, _ARRAY_FIELDS, _CELLS = 16, 58, 10
_MV, _CA, _PERCENT = 1e-3, 1e-2, 1e-2
_CELL_MAX, _CELL_UNKNOWN = 65534, 65535
_GYRO, _PRESSURE = dialect.MAV_SYS_STATUS_SENSOR_3D_GYRO, dialect.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
_AHRS, _BATTERY = dialect.MAV_SYS_STATUS_AHRS, dialect.MAV_SYS_STATUS_SENSOR_BATTERY
_GPS, _DVL = dialect.MAV_SYS_STATUS_SENSOR_GPS, dialect.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
_ALTIMETER, _FINS = dialect.MAV_SYS_STATUS_SENSOR_LASER_POSITION, dialect.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
_EXTENDED, _LEAK = dialect.MAV_SYS_STATUS_EXTENSION_USED, dialect.MAV_SYS_STATUS_SENSOR_LEAK
_FINS_ARRAY, _VALUE_ARRAY, _STD_ARRAY, _STATE_ARRAY, _DESIGN_ARRAY, _DAMAGE_ARRAY = 0, 2, 3, 4, 5, 6
"""Array ids, by which stations tell arrays apart; 1 is the lateness."""
_RATIO = 9.0
"""A test ratio of 1 stands for innovations of 3 sigma (root mean square); a consistent filter has 1/9."""
_OTHERS = ("nis_dvl", "nis_gyro", "nis_att", "current_n", "current_e", "turbulence")
_GEOFENCE, _PREARM = dialect.MAV_SYS_STATUS_GEOFENCE, dialect.MAV_SYS_STATUS_PREARM_CHECK
_PRESENT = _GYRO | _AHRS | _PRESSURE | _GPS | _DVL | _ALTIMETER | _FINS | _BATTERY | _EXTENDED | _PREARM


class Actuators(NamedTuple):
    """Full scale of the actuators: each fin, rad, and the propeller, rev/s."""

    delta_max: tuple[float, ...]
    n_max: float


def battery_now(cycle: Cycle) -> Battery:
    """Return what the battery's monitor says; unknown (NaN) while it is silent, or not sound."""
    battery = cycle.frame.battery
    return battery.value if battery.usable(cycle.tick.t, _RECENT) else _UNKNOWN_BATTERY


class HealthTelemetry:
    """Encoders of the messages on health and actuators."""

    def __init__(
        self, actuators: Actuators, lateness: Lateness, plan_store: PlanStore, communication: Communication
    ) -> None:
        self._lateness, self._plan_store = lateness, plan_store
        self._communication = communication
        self._full = (*actuators.delta_max, actuators.n_max)

    def encoders(self) -> dict[int, Encoder]:
        """Return the encoder of each message id."""
        return {
            dialect.MAVLINK_MSG_ID_SYS_STATUS: self.sys_status,
            dialect.MAVLINK_MSG_ID_BATTERY_STATUS: self.battery,
            dialect.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: self.servo_output,
            dialect.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY: self.arrays,
            dialect.MAVLINK_MSG_ID_RPM: self.rpm,
            dialect.MAVLINK_MSG_ID_ESTIMATOR_STATUS: self.estimator,
        }

    def sys_status(self, cycle: Cycle) -> Message:
        """Encode SYS_STATUS: errors_count1 counts late cycles of the last second; the DVL has the x-y control bit.

        `Communication` has drop_rate_comm and errors_count2 (bus), 3 (serial) and 4 (stations); the link errors_comm.
        "Motor outputs" are all actuators: healthy while all fins report, and the actuator watch names no fault. A
        sensor is healthy while it is heard and believed; without the altimeter the DVL still may measure the altitude.
        """
        frame, state, t = cycle.heard, cycle.state, cycle.tick.t
        sensors = state.sensors
        battery = battery_now(cycle)
        health = _EXTENDED
        for bit, healthy in (
            (_GYRO | _AHRS, state.attitude_ok and sensors.ahrs.believed),
            (_PRESSURE, state.depth_ok and sensors.pressure.believed),
            (_GPS, frame.fix.usable(t, _RECENT) and sensors.fix.believed),
            (_DVL, state.velocity_ok and sensors.dvl.believed),
            (_ALTIMETER, math.isfinite(state.altitude) and sensors.altitude.believed),
            (_FINS, cycle.actuators.faultless and all(fin.usable(t, _RECENT) for fin in frame.fins)),
            (_BATTERY, frame.battery.usable(t, _RECENT) and sensors.battery.believed),
            (_PREARM, cycle.mode.ready),
            # Only with a fence: some stations take a missing fence for a breached one.
            (_GEOFENCE, not self._plan_store.outside_fence),
        ):
            health |= bit if healthy else 0
        present = _PRESENT if self._plan_store.fence == NO_FENCE else _PRESENT | _GEOFENCE
        return dialect.MAVLink_sys_status_message(
            present,
            present,
            health,
            0,
            whole(battery.voltage, _MV, UINT16, unknown=65535),
            whole(battery.current, _CA, INT16, unknown=-1),
            whole(battery.remaining, _PERCENT, (0, 100), unknown=-1),
            self._communication.drop_rate,
            0,
            min(cycle.mode.late, 65535),
            self._communication.bus,
            self._communication.serial,
            self._communication.stations,
            _LEAK,
            _LEAK,
            _LEAK if sensors.leak.believed and not state.leak else 0,
        )

    def battery(self, cycle: Cycle) -> Message:
        """Encode BATTERY_STATUS: the voltage of the battery in the first cell; what exceeds its range in the next."""
        value, unknown = battery_now(cycle), -1
        return dialect.MAVLink_battery_status_message(
            0,
            dialect.MAV_BATTERY_FUNCTION_ALL,
            dialect.MAV_BATTERY_TYPE_UNKNOWN,
            32767,
            _cells(value.voltage),
            whole(value.current, _CA, INT16, unknown),
            unknown,
            unknown,
            whole(value.remaining, _PERCENT, (0, 100), unknown),
        )

    def servo_output(self, cycle: Cycle) -> Message:
        """Encode SERVO_OUTPUT_RAW: the commands of fins and propeller, in that order, as pulse widths.

        1500 us is the centre, 1000 and 2000 us are full deflection; the sign is that of the fin angle.
        """
        commands = (*cycle.applied.fins, cycle.applied.n)
        pulses = [
            _PWM_CENTRE + whole(value / full, 1.0 / _PWM_SPAN, (-_PWM_SPAN, _PWM_SPAN), unknown=0)
            for value, full in zip(commands, self._full, strict=True)
        ]
        pulses = (pulses + [0] * _SERVO_FIELDS)[:_SERVO_FIELDS]
        return dialect.MAVLink_servo_output_raw_message(boot_us32(cycle.tick), 0, *pulses)

    def arrays(self, cycle: Cycle) -> Message:
        """Encode DEBUG_FLOAT_ARRAY by tenths of a second: 0 lateness; 1, 3, 5, 7 what is learned; 9 damage; else fins.

        "xi" are the coefficients, "xi_std" their 1 sigma; "xi_state" is 1 for valid, 2 for excited, 3 for both. Their
        order is that of the configuration's estimation.coefficients.names; at most 58 are sent. "design" is what the
        laws are designed from: M_q, M_ds, Y_v, Y_r, Y_dr, N_v, N_r, N_dr; then of the depth law and of the heading law
        `Source`, `Refusal`, s'b and the fins' authority, rad/s^2, at the trim speed; then the caution. "damage" is 1 if
        a fin is damaged, else 0; the shares of diving and of turning that are left; the radius of the tightest turn, m;
        the least speed, m/s; then of each fin the share of its effect, and the angle at which it is stuck, rad (NaN: it
        is not).
        """
        tenth, learned = cycle.tick.t_ns % NS_PER_S // (NS_PER_S // 10), cycle.state.learned
        if tenth == 0:
            return self._lateness.message(cycle)
        if tenth == 9:
            return _array(cycle, b"damage", _DAMAGE_ARRAY, _damage(cycle))
        if learned.value:
            if tenth == 1:
                return _array(cycle, b"xi", _VALUE_ARRAY, learned.value)
            if tenth == 3:
                return _array(cycle, b"xi_std", _STD_ARRAY, learned.std)
            if tenth == 5:
                return _array(cycle, b"xi_state", _STATE_ARRAY, _states(learned))
            if tenth == 7:
                return _array(cycle, b"design", _DESIGN_ARRAY, _design(cycle.adopted))
        return self.fins(cycle)

    def fins(self, cycle: Cycle) -> Message:
        """Encode DEBUG_FLOAT_ARRAY "fins": the fin angles reported by the servos, rad; NaN without a recent report."""
        t = cycle.tick.t
        angles = (fin.value if fin.usable(t, _RECENT) else math.nan for fin in cycle.frame.fins)
        return _array(cycle, b"fins", _FINS_ARRAY, angles)

    def rpm(self, cycle: Cycle) -> Message:
        """Encode RPM: the propeller speed reported by its controller."""
        n = cycle.frame.n
        return dialect.MAVLink_rpm_message(n.value * 60.0 if n.usable(cycle.tick.t, _RECENT) else math.nan, math.nan)

    def estimator(self, cycle: Cycle) -> Message:
        """Encode ESTIMATOR_STATUS: `vel_ratio` is that of the DVL, `mag_ratio` that of attitude; NaN is unknown."""
        state, (dvl, _, attitude) = cycle.state, cycle.state.learned.nis
        velocity_ok = state.velocity_ok and state.attitude_ok
        position_ok = velocity_ok and state.position_std <= KNOWN_POSITION
        flags = 0
        for bits, true in (
            (dialect.ESTIMATOR_ATTITUDE, state.attitude_ok),
            (dialect.ESTIMATOR_VELOCITY_HORIZ | dialect.ESTIMATOR_VELOCITY_VERT, velocity_ok),
            (dialect.ESTIMATOR_POS_HORIZ_REL | dialect.ESTIMATOR_PRED_POS_HORIZ_REL, velocity_ok),
            (dialect.ESTIMATOR_POS_HORIZ_ABS | dialect.ESTIMATOR_PRED_POS_HORIZ_ABS, position_ok),
            (dialect.ESTIMATOR_POS_VERT_ABS, state.depth_ok),
            (dialect.ESTIMATOR_POS_VERT_AGL, math.isfinite(state.altitude)),
        ):
            flags |= bits if true else 0
        nan = math.nan
        return dialect.MAVLink_estimator_status_message(
            boot_us(cycle.tick),
            flags,
            dvl / _RATIO,
            nan,
            nan,
            attitude / _RATIO,
            nan,
            nan,
            state.position_std,
            state.depth_std,
        )


class NamedValues:
    """Encoder of the learned values and of the drop weight's state as NAMED_VALUE_FLOAT; each link has its own.

    One name comes after the other: those of the coefficients, then "weight" (`WeightState`) if a hardpoint reports.
    """

    def __init__(self, coefficients: Sequence[str]) -> None:
        """`coefficients` are the names of the estimated coefficients, in the order of the records."""
        self._coefficients = coefficients
        self._index = -1

    def encoders(self) -> dict[int, Encoder]:
        """Return the encoder of each message id."""
        return {dialect.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: self.next}

    def next(self, cycle: Cycle) -> Message | None:
        """Encode the next value, with 10 characters of its name at most; None if nothing is estimated."""
        learned, weight = cycle.state.learned, cycle.actuators.drop_weight
        named: list[tuple[str, float]] = []
        if learned.value:
            others = (*learned.nis, *learned.current, learned.turbulence)
            named += [*zip(self._coefficients, learned.value, strict=False), *zip(_OTHERS, others, strict=True)]
        if weight is not WeightState.UNREPORTED:
            named.append(("weight", float(weight)))
        if not named:
            return None
        self._index = (self._index + 1) % len(named)
        name, value = named[self._index]
        return dialect.MAVLink_named_value_float_message(boot_ms(cycle.tick), name.encode()[:10], value)


def _array(cycle: Cycle, name: bytes, number: int, values: Iterable[float]) -> Message:
    fields = [*values][:_ARRAY_FIELDS]
    fields += [0.0] * (_ARRAY_FIELDS - len(fields))
    return dialect.MAVLink_debug_float_array_message(boot_us(cycle.tick), name, number, fields)


def _states(learned: Learned) -> Iterable[float]:
    return (valid + 2.0 * excited for valid, excited in zip(learned.valid, learned.excited, strict=True))


def _design(adopted: Adopted) -> Iterable[float]:
    laws = adopted.depth, adopted.heading
    said = [float(one) for law in laws for one in (law.source, law.refusal, law.s_b, law.authority)]
    return (*adopted.diving, *adopted.steering, *said, adopted.caution)


def _damage(cycle: Cycle) -> Iterable[float]:
    left, fins = cycle.left, cycle.actuators.left
    damaged = any(fin.source is not FinEvidence.NONE for fin in fins)
    said = [one for fin in fins for one in (fin.effect, fin.stuck)]
    return (float(damaged), left.dive_left, left.turn_left, left.turn_radius, left.speed, *said)


def _cells(voltage: float) -> list[int]:
    rest = whole(voltage, _MV, (0, _CELLS * _CELL_MAX), unknown=-1)
    cells = [_CELL_UNKNOWN] * _CELLS
    for i in range(_CELLS):
        if rest < 0 or (i and rest == 0):
            break
        cells[i] = min(rest, _CELL_MAX)
        rest -= cells[i]
    return cells
