"""Sensors and actuators over MAVLink: the interface of PX4-compatible simulators.

HIL_SENSOR gives rates and pressure, and is the tick; each is answered by one HIL_ACTUATOR_CONTROLS. It has neither
attitude nor velocity, and the interface has no message of a DVL: both are taken from HIL_STATE_QUATERNION, which is the
simulator's truth, so they have no errors of an AHRS or a DVL. The velocity is rotated into the body frame and taken
five times a second, as a DVL does; its field is in whole cm/s. There is no feedback of fins and propeller: the
estimator uses the commands. There is no leak sensor either: our own simulator says the humidity by name.

The control after the propeller's is 1 from when the drop weight is to be released. The interface does not say what
becomes of it; our own simulator says by name which load still hangs.

Steering does not suffer from that, learning does: the lag of the servos is attributed to the hull, and an attitude
without noise contradicts the noise that the filter expects, so that no coefficient becomes valid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from typing import Any

from firmware_py.adapters.hil.hil_link import ARMED, LOCKSTEP, MOST_CONTROLS, HilLink, Stop
from firmware_py.adapters.lockstep.lockstep_link import TIMEOUT, LockstepError
from firmware_py.marine import euler_from_quaternion, ned_to_body
from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.records.command import Applied
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix, Hardpoint, Heard, SensorFrame, silence
from firmware_py.tick import Rate, Tick

DVL_PERIOD_US = 200_000
"""Time between two velocities: 5 Hz, as a DVL."""
VELOCITY_STD = 0.01 / math.sqrt(12.0)
"""1 sigma of a velocity that is rounded to cm/s, m/s."""
GYRO = dialect.HIL_SENSOR_UPDATED_XGYRO | dialect.HIL_SENSOR_UPDATED_YGYRO | dialect.HIL_SENSOR_UPDATED_ZGYRO
PRESSURE = dialect.HIL_SENSOR_UPDATED_ABS_PRESSURE
FIX_3D = 3
_UNKNOWN_U16 = 65535
_INVALID_SIGNAL = 1
_DOWN = dialect.MAV_SENSOR_ROTATION_PITCH_270
LEAK = "LEAK"
"""Name of the humidity inside the hull, in [0, 1]: the interface has no message for it, ours says it by name."""
WEIGHT = "WEIGHT"
"""Name of the drop weight that still hangs, N, of our own simulator."""

_USED: dict[int, Callable[[Message], bool]] = {
    # Which messages are used, and of which instance: simulators may send several.
    dialect.MAVLINK_MSG_ID_HIL_SENSOR: lambda message: message.id == 0,
    dialect.MAVLINK_MSG_ID_HIL_GPS: lambda message: message.id == 0,
    dialect.MAVLINK_MSG_ID_HIL_STATE_QUATERNION: lambda _: True,
    dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR: lambda message: message.orientation == _DOWN,
    dialect.MAVLINK_MSG_ID_BATTERY_STATUS: lambda message: message.id == 0,
    dialect.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: lambda message: message.name in (LEAK, WEIGHT),
}


class HilHardware:
    """A `ports.Hardware` over the link: messages to one frame a tick, commands to shares of full scale.

    Args:
        link: to the simulator.
        full_scale: of each fin, rad, and last of the propeller, rev/s: what a control of 1 stands for.
    """

    def __init__(self, link: HilLink, full_scale: Sequence[float]) -> None:
        self._link = link
        self._scale = tuple(full_scale)
        nothing = silence(len(self._scale) - 1)
        self._fins = nothing.fins
        self._heard: dict[str, Any] = {
            field.name: getattr(nothing, field.name)
            for field in fields(nothing)
            if isinstance(getattr(nothing, field.name), Heard)  # neither fins nor what is known of a bus alone
        }
        self._received: dict[int | str, Message] = {}
        """By id; named values by name."""
        self._epoch_us = 0
        self._velocity_us = -math.inf
        self._attitude: tuple[tuple[float, float, float], float] | None = None

    def set_epoch(self, epoch_us: int) -> None:
        """Set the simulator's time at tick 0."""
        self._epoch_us = epoch_us

    def accept(self, message: Message) -> None:
        """Keep a message for the next `read`; of each kind the newest counts."""
        kind = message.get_msgId()
        ours = _USED.get(kind)
        if ours is not None and ours(message):
            named = kind == dialect.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT
            self._received[message.name if named else kind] = message

    def read(self, tick: Tick) -> SensorFrame:
        """Return what was received since the last tick; a channel without a new value keeps its value and its time."""
        heard, received = self._heard, self._received
        for name, old in heard.items():
            if old.fresh:
                heard[name] = Heard(old.value, old.t_valid, False, old.ok)
        state = received.get(dialect.MAVLINK_MSG_ID_HIL_STATE_QUATERNION)
        if state is not None:
            self._state(state)
        sensor = received.get(dialect.MAVLINK_MSG_ID_HIL_SENSOR)
        if sensor is not None:
            self._sensor(sensor)
        gps = received.get(dialect.MAVLINK_MSG_ID_HIL_GPS)
        if gps is not None:
            heard["fix"] = _fix(gps, self._t(gps.time_usec))
        # The others have no time, or one of another clock: they are valid when they arrive.
        distance = received.get(dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR)
        if distance is not None:
            heard["altitude"] = _altitude(distance, tick.t)
        battery = received.get(dialect.MAVLINK_MSG_ID_BATTERY_STATUS)
        if battery is not None:
            heard["battery"] = _battery(battery, tick.t)
        leak = received.get(LEAK)
        if leak is not None:
            heard["leak"] = Heard(leak.value, tick.t, True, math.isfinite(leak.value))
        weight = received.get(WEIGHT)
        if weight is not None:
            load = Hardpoint(weight.value > 0.0, weight.value)
            heard["hardpoint"] = Heard(load, tick.t, True, math.isfinite(weight.value))
        received.clear()
        return SensorFrame(two_senders=0, unhealthy=0, replaced=0, restarted=0, fins=self._fins, **heard)

    def write(self, tick: Tick, applied: Applied) -> None:
        """Answer the tick; send a heartbeat before it once a second."""
        link, commands = self._link, (*applied.fins, applied.n)
        if tick.every(Rate.HZ_1):
            link.send(link.heartbeat(applied.armed))
        controls = [value / full for value, full in zip(commands, self._scale, strict=True)]
        controls.append(1.0 if applied.drop else 0.0)
        controls = [*controls, *[0.0] * MOST_CONTROLS][:MOST_CONTROLS]
        mode = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (ARMED if applied.armed else 0)
        now_us = self._epoch_us + tick.t_ns // 1000
        link.send(dialect.MAVLink_hil_actuator_controls_message(now_us, controls, mode, LOCKSTEP))

    def _t(self, time_us: int) -> float:
        return (time_us - self._epoch_us) / 1e6

    def _state(self, message: Message) -> None:
        w, x, y, z = message.attitude_quaternion
        phi, theta, psi = euler_from_quaternion(x, y, z, w)
        t = self._t(message.time_usec)
        self._attitude = (phi, theta, psi), t
        if message.time_usec - self._velocity_us >= DVL_PERIOD_US:
            self._velocity_us = message.time_usec
            velocity = ned_to_body(phi, theta, psi, *(0.01 * v for v in (message.vx, message.vy, message.vz)))
            ok = all(map(math.isfinite, velocity))
            self._heard["dvl"] = Heard(Dvl(*velocity, VELOCITY_STD, math.nan), t, True, ok)

    def _sensor(self, message: Message) -> None:
        """Use the rates together with a new attitude as one AHRS value, at the attitude's time."""
        updated = message.fields_updated
        if updated & GYRO == GYRO and self._attitude is not None:
            angles, t = self._attitude
            self._attitude = None
            value = Ahrs(*angles, message.xgyro, message.ygyro, message.zgyro)
            self._heard["ahrs"] = Heard(value, t, True, all(map(math.isfinite, value)))
        if updated & PRESSURE:
            pressure = 100.0 * message.abs_pressure
            self._heard["pressure"] = Heard(pressure, self._t(message.time_usec), True, math.isfinite(pressure))


class HilSchedule:
    """A `ports.Schedule` that waits for the simulator's HIL_SENSOR: its time is the vehicle's.

    Args:
        hardware: takes the messages that arrive over `link`.
        link: to the simulator.
        dt_ns: the step, a whole number of microseconds.
        stop: asked at every tick and while waiting.
    """

    def __init__(self, hardware: HilHardware, link: HilLink, dt_ns: int, stop: Stop) -> None:
        self._hardware = hardware
        self._link = link
        self._dt_ns = dt_ns
        self._stop = stop

    def __iter__(self) -> Iterator[Tick]:
        """Yield ticks, one for each HIL_SENSOR, until either side ends the run.

        Raises:
            LockstepError: the simulator is silent or gone, or its time does not advance by our step.
        """
        link, accept = self._link, self._hardware.accept
        link.send(link.heartbeat(False), _request_state(self._dt_ns // 1000))
        k, epoch_us = 0, 0
        while True:
            sensor = link.receive(_is_tick, accept, TIMEOUT, self._stop)
            if self._stop():
                break
            if sensor is None:
                if link.ended:
                    return
                raise link.missing(k)
            if k == 0:
                epoch_us = sensor.time_usec
                self._hardware.set_epoch(epoch_us)
            self._check(k, sensor.time_usec - epoch_us)
            accept(sensor)
            yield Tick(k, self._dt_ns)
            k += 1
        link.bye()

    def _check(self, k: int, passed_us: int) -> None:
        step_us = self._dt_ns // 1000
        if passed_us == k * step_us:
            return
        if k == 1 and passed_us > 0:
            raise LockstepError(
                f"the plant steps {passed_us / 1e3:g} ms, the vehicle {step_us / 1e3:g} ms: set one rate_hz"
            )
        raise LockstepError(f"HIL_SENSOR of {passed_us / 1e6:.6f} s came when {k * step_us / 1e6:.6f} s was due")


def _is_tick(message: Message) -> bool:
    return bool(message.get_msgId() == dialect.MAVLINK_MSG_ID_HIL_SENSOR and message.id == 0)


def _request_state(period_us: int) -> Message:
    """Return the request for HIL_STATE_QUATERNION, which simulators send on request, as PX4 does it."""
    state = dialect.MAVLINK_MSG_ID_HIL_STATE_QUATERNION
    command = dialect.MAV_CMD_SET_MESSAGE_INTERVAL
    return dialect.MAVLink_command_long_message(0, 0, command, 0, state, period_us, 0, 0, 0, 0, 0)


def _fix(message: Message, t: float) -> Heard[Fix]:
    """Return the fix; `eph` is an error in cm, as PX4 reads it (MAVLink itself calls it a dilution)."""
    std = message.eph * 0.01 if 0 < message.eph < _UNKNOWN_U16 else math.nan
    value = Fix(math.radians(message.lat * 1e-7), math.radians(message.lon * 1e-7), std)
    return Heard(value, t, True, message.fix_type >= FIX_3D and math.isfinite(std))


def _altitude(message: Message, t: float) -> Heard[float]:
    distance = message.current_distance
    ok = message.min_distance <= distance <= message.max_distance and message.signal_quality != _INVALID_SIGNAL
    return Heard(0.01 * distance, t, True, ok)


def _battery(message: Message, t: float) -> Heard[Battery]:
    cells = [voltage for voltage in message.voltages if voltage != _UNKNOWN_U16]
    voltage = 1e-3 * sum(cells) if cells else math.nan
    current = 0.01 * message.current_battery if message.current_battery >= 0 else math.nan
    remaining = 0.01 * message.battery_remaining if message.battery_remaining >= 0 else math.nan
    return Heard(Battery(voltage, current, remaining), t, True, math.isfinite(voltage))
