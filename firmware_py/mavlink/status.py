"""How the vehicle is: sensors, battery, water in the hull, and what its actuators are told and say."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.mavlink.codec import Message, dialect
from firmware_py.mavlink.lateness import Lateness
from firmware_py.mavlink.scale import INT16, UINT16, boot_ms, boot_us, boot_us32, whole
from firmware_py.mavlink.telemetry import Maker
from firmware_py.records.cycle import Cycle
from firmware_py.schedule import NS_PER_S

_RECENT = 2.0
"""What was last heard longer ago, s, counts as silent."""
_PWM_CENTRE, _PWM_SPAN = 1500, 500
_SERVO_FIELDS, _ARRAY_FIELDS, _CELLS = 16, 58, 10
_MV, _CA, _PERCENT = 1e-3, 1e-2, 1e-2
_CELL_MOST, _CELL_UNKNOWN = 65534, 65535
_GYRO, _PRESSURE = dialect.MAV_SYS_STATUS_SENSOR_3D_GYRO, dialect.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
_AHRS, _BATTERY = dialect.MAV_SYS_STATUS_AHRS, dialect.MAV_SYS_STATUS_SENSOR_BATTERY
_GPS, _DVL = dialect.MAV_SYS_STATUS_SENSOR_GPS, dialect.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
_ALTIMETER, _FINS = dialect.MAV_SYS_STATUS_SENSOR_LASER_POSITION, dialect.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
_EXTENDED, _LEAK = dialect.MAV_SYS_STATUS_EXTENSION_USED, dialect.MAV_SYS_STATUS_SENSOR_LEAK
_PRESENT = _GYRO | _AHRS | _PRESSURE | _GPS | _DVL | _ALTIMETER | _FINS | _BATTERY | _EXTENDED


class Actuators(NamedTuple):
    """What full deflection is: of each fin, rad, and of the propeller, rev/s."""

    delta_max: tuple[float, ...]
    n_max: float


class Status:
    """Makers of the messages on health and actuators."""

    def __init__(self, actuators: Actuators, late: Lateness) -> None:
        self._late = late
        self._full = (*actuators.delta_max, actuators.n_max)

    def makers(self) -> dict[int, Maker]:
        """A maker for each message id."""
        return {
            dialect.MAVLINK_MSG_ID_SYS_STATUS: self.sys_status,
            dialect.MAVLINK_MSG_ID_BATTERY_STATUS: self.battery,
            dialect.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: self.servo_output,
            dialect.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY: self.arrays,
            dialect.MAVLINK_MSG_ID_RPM: self.rpm,
            dialect.MAVLINK_MSG_ID_SYSTEM_TIME: self.system_time,
        }

    def sys_status(self, cycle: Cycle) -> Message:
        """SYS_STATUS. errors_count1 is the late cycles of the last second; the DVL has the bit of x-y control."""
        frame, state, t = cycle.frame, cycle.state, cycle.tick.t
        battery = frame.battery.value
        health = _EXTENDED
        for bit, healthy in (
            (_GYRO | _AHRS, state.attitude_ok),
            (_PRESSURE, state.depth_ok),
            (_GPS, frame.fix.usable(t, _RECENT)),
            (_DVL, state.velocity_ok),
            (_ALTIMETER, math.isfinite(state.altitude)),
            (_FINS, all(fin.usable(t, _RECENT) for fin in frame.fins)),
            (_BATTERY, frame.battery.usable(t, _RECENT)),
        ):
            health |= bit if healthy else 0
        return dialect.MAVLink_sys_status_message(
            _PRESENT,
            _PRESENT,
            health,
            0,
            whole(battery.voltage, _MV, UINT16, unknown=65535),
            whole(battery.current, _CA, INT16, unknown=-1),
            whole(battery.remaining, _PERCENT, (0, 100), unknown=-1),
            0,
            0,
            min(cycle.mode.late, 65535),
            0,
            0,
            0,
            _LEAK,
            _LEAK,
            0 if state.leak else _LEAK,
        )

    def battery(self, cycle: Cycle) -> Message:
        """BATTERY_STATUS: the whole voltage in the first cell, and what it cannot hold in the next."""
        value = cycle.frame.battery.value
        unknown = -1
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
        """SERVO_OUTPUT_RAW: what is asked of fins and propeller, in that order, as a pulse would say it.

        1500 us is the centre, 1000 and 2000 are full deflection; the sign is the fin angle's own.
        """
        asked = (*cycle.applied.fins, cycle.applied.n)
        pulses = [
            _PWM_CENTRE + whole(value / full, 1.0 / _PWM_SPAN, (-_PWM_SPAN, _PWM_SPAN), unknown=0)
            for value, full in zip(asked, self._full, strict=True)
        ]
        pulses = (pulses + [0] * _SERVO_FIELDS)[:_SERVO_FIELDS]
        return dialect.MAVLink_servo_output_raw_message(boot_us32(cycle.tick), 0, *pulses)

    def arrays(self, cycle: Cycle) -> Message:
        """DEBUG_FLOAT_ARRAY: the lateness in the first fifth of each second, the fins in the rest."""
        if cycle.tick.t_ns % NS_PER_S < NS_PER_S // 5:
            return self._late.message(cycle)
        return self.fins(cycle)

    def fins(self, cycle: Cycle) -> Message:
        """DEBUG_FLOAT_ARRAY "fins": the angles that the servos report, rad; NaN where none came of late."""
        t = cycle.tick.t
        angles = [fin.value if fin.usable(t, _RECENT) else math.nan for fin in cycle.frame.fins][:_ARRAY_FIELDS]
        angles += [0.0] * (_ARRAY_FIELDS - len(angles))
        return dialect.MAVLink_debug_float_array_message(boot_us(cycle.tick), b"fins", 0, angles)

    def rpm(self, cycle: Cycle) -> Message:
        """RPM: the propeller's, as its controller reports it."""
        n = cycle.frame.n
        return dialect.MAVLink_rpm_message(n.value * 60.0 if n.usable(cycle.tick.t, _RECENT) else math.nan, math.nan)

    def system_time(self, cycle: Cycle) -> Message:
        """SYSTEM_TIME: the vehicle knows no other time than its own."""
        return dialect.MAVLink_system_time_message(0, boot_ms(cycle.tick))


def _cells(voltage: float) -> list[int]:
    rest = whole(voltage, _MV, (0, _CELLS * _CELL_MOST), unknown=-1)
    cells = [_CELL_UNKNOWN] * _CELLS
    for i in range(_CELLS):
        if rest < 0 or (i and rest == 0):
            break
        cells[i] = min(rest, _CELL_MOST)
        rest -= cells[i]
    return cells
