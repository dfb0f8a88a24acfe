"""The plant as a PX4-compatible simulator: sends HIL_SENSOR, receives HIL_ACTUATOR_CONTROLS, over TCP in lockstep.

Rates, pressure, fixes, distance to the bottom and battery are what the instruments of sensors.toml read, with noise;
those of HIL_SENSOR without their latency, because it has one time for all. HIL_STATE_QUATERNION is the truth. The
vehicle has neither accelerometer nor magnetometer: HIL_SENSOR gives both without error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as dialect  # type: ignore[import-untyped]

from firmware_py.adapters.hil.hil_link import ARMED, LOCKSTEP, HilLink
from firmware_py.adapters.lockstep.lockstep_link import TIMEOUT, LockstepError
from firmware_py.marine import (
    GRAVITY,
    Origin,
    body_to_ned,
    clip,
    local_to_geodetic,
    ned_to_body,
    quaternion_from_euler,
)
from firmware_py.params import ParamError
from firmware_py.records.sensing import Battery, Fix
from sim_bridge.bridge import Bridge
from sim_bridge.build import plant_and_instruments
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.instruments import AltimeterParams, Instruments
from sim_bridge.devices.sensors import due
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario

_UPDATED = {
    name: sum(getattr(dialect, f"HIL_SENSOR_UPDATED_{field}") for field in fields)
    for name, fields in {
        "motion": ("XACC", "YACC", "ZACC", "XMAG", "YMAG", "ZMAG"),
        "gyro": ("XGYRO", "YGYRO", "ZGYRO"),
        "pressure": ("ABS_PRESSURE",),
    }.items()
}
_FIELD_AT_EQUATOR = 0.294048
"""Of the earth's axial dipole, gauss: g_1^0 of IGRF-13 for 2020."""
_EPOCH_US = 10_000_000
"""The simulator's time at tick 0; late measurements from before it need a time too."""
_UNKNOWN_U16 = 65535
_NO_FIX, _FIX_3D = 1, 3
_INVALID_SIGNAL, _PERFECT_SIGNAL = 1, 100


def build_hil_bridge(
    truth: Truth, params: DevicesParams, scenario: Scenario, link: HilLink, seed: int, base_hz: int
) -> tuple[Bridge, HilDevices]:
    """Return the simulated vehicle at the start of a scenario, on its end of the link; compare `build.build_bridge`.

    Raises:
        ParamError: an impossible body or battery, or a fault of a device or fin that does not exist.
    """
    refuse_faults(scenario)
    params = params.within(base_hz)
    ahrs, pressure = replace(params.ahrs, latency=0.0), replace(params.pressure, latency=0.0)
    params = replace(params, ahrs=ahrs, pressure=pressure)
    plant, instruments = plant_and_instruments(truth, params, scenario, seed, base_hz)
    devices = HilDevices(params, instruments, scenario.environment.origin, link, len(truth.fins), base_hz)
    return Bridge(plant, devices, scenario.faults), devices


def refuse_faults(scenario: Scenario) -> None:
    """Raise ParamError if a fault concerns a device that this interface does not have."""
    for fault in scenario.faults:
        if fault.name == "dvl-off":
            raise ParamError("fault dvl-off: mavlink-hil has no DVL to switch off; velocity comes with the truth")


class HilDevices:
    """The devices of the plant as messages of the interface; a `bridge.DevicePort`."""

    def __init__(
        self, params: DevicesParams, instruments: Instruments, origin: Origin, link: HilLink, fins: int, base_hz: int
    ) -> None:
        self._params = params
        self._instruments = instruments
        self._origin = origin
        self._link = link
        self._base_hz = base_hz
        self._commanded: tuple[tuple[float, ...], float] = ((0.0,) * fins, 0.0)
        self._off: set[str] = set()

    def initialise(self, plant: Plant) -> None:
        """Sample before tick 0, so that readings delayed by latency arrive from tick 0 on."""
        for sensor in self._instruments.all:
            for k in range(-sensor.delay, 0):
                sensor.update(k, plant)

    def receive(self, _t: float, /) -> None:
        """Do nothing: a tick ends with the answer, which `accept_command` has taken."""

    def accept_command(self, answer: Any) -> None:
        """Take HIL_ACTUATOR_CONTROLS: the fins in order, then the propeller, each a share of full scale in [-1, 1].

        A vehicle that is not armed centres the fins and stops the propeller; a share that is NaN counts as 0.
        """
        fins = len(self._commanded[0])
        if not answer.mode & ARMED:
            self._commanded = (0.0,) * fins, 0.0
            return
        shares = [clip(share, -1.0, 1.0) if share == share else 0.0 for share in answer.controls]
        travel, n_max = self._params.servo_hub.travel, self._params.esc.n_max
        self._commanded = tuple([share * travel for share in shares[:fins]]), shares[fins] * n_max

    def commands(self, _t: float, _fins: Sequence[float], /) -> tuple[Sequence[float], float]:
        """Return the commands to servos (rad) and shaft (rev/s)."""
        return self._commanded

    def publish(self, k: int, _t: float, plant: Plant, /) -> None:
        """Send the messages of tick k; HIL_SENSOR is the last, because the vehicle answers it."""
        time_us, read = time_at(k * plant.dt), self._instruments
        messages = []
        if due(k, 1, self._base_hz):
            messages.append(self._link.heartbeat(False))
        messages.append(_state(plant, self._origin, time_us))
        fix = read.fix.update(k, plant)
        if fix is not None and "fix" not in self._off:
            messages.append(_gps(fix.value, plant, time_at(fix.t_valid)))
        altitude = read.altimeter.update(k, plant)
        if altitude is not None and "altimeter" not in self._off:
            messages.append(_distance(altitude.value, self._params.altimeter, time_at(altitude.t_valid) // 1000))
        battery = read.battery.update(k, plant)
        if battery is not None:
            messages.append(_battery(battery.value))
        messages.append(self._sensor(k, plant, time_us))
        self._link.send(*messages)

    def switch_off(self, device: str) -> None:
        """Switch a device off."""
        self._off.add(device)

    def _sensor(self, k: int, plant: Plant, time_us: int) -> Any:
        ahrs, pressure = self._instruments.ahrs.update(k, plant), self._instruments.pressure.update(k, plant)
        rates, hectopascals, updated = (0.0, 0.0, 0.0), 0.0, _UPDATED["motion"]
        if ahrs is not None and "ahrs" not in self._off:
            rates, updated = ahrs.value[3:], updated | _UPDATED["gyro"]
        if pressure is not None and "pressure" not in self._off:
            hectopascals, updated = 0.01 * pressure.value, updated | _UPDATED["pressure"]
        field = _magnetic_field(self._origin.latitude)
        return dialect.MAVLink_hil_sensor_message(
            time_us,
            *specific_force(plant),
            *rates,
            *ned_to_body(*plant.eta[3:], *field),
            hectopascals,
            0.0,
            0.0,
            0.0,
            updated,
        )


class HilServer:
    """Runs a plant in lockstep: one HIL_ACTUATOR_CONTROLS for each HIL_SENSOR. `step(k)` moves it and sends tick k."""

    def __init__(self, step: Callable[[int], None], devices: HilDevices, link: HilLink, dt_ns: int) -> None:
        self._step = step
        self._devices = devices
        self._link = link
        self._dt = dt_ns * 1e-9

    def advance(self, k: int, stop: Callable[[], bool]) -> bool:
        """Step to tick k and wait for the vehicle's answer; return False if either side ends the run.

        Raises:
            LockstepError: the vehicle is silent or gone, answers another tick, or does not fly in lockstep.
        """
        self._step(k)
        answer = self._link.receive(_is_answer, lambda _: None, TIMEOUT, stop)
        if stop():
            return False
        if answer is None:
            if self._link.ended:
                return False
            raise self._link.missing(k)
        if not answer.flags & LOCKSTEP:
            raise LockstepError("the vehicle does not fly in lockstep: bit 0 of HIL_ACTUATOR_CONTROLS.flags is not set")
        if answer.time_usec != time_at(k * self._dt):
            raise LockstepError(f"the vehicle answered {answer.time_usec} us when it was {time_at(k * self._dt)} us")
        self._devices.accept_command(answer)
        return True

    def bye(self) -> None:
        """Tell the vehicle that there are no more ticks."""
        self._link.bye()


def time_at(t: float) -> int:
    """Return the simulator's time at `t` (s, 0 at tick 0), us."""
    return _EPOCH_US + round(t * 1e6)


def specific_force(plant: Plant) -> tuple[float, float, float]:
    """Return what an accelerometer at the body's origin would measure, m/s^2: at rest it is -g, up."""
    _, _, _, phi, theta, _ = plant.eta
    u, v, w, p, q, r = plant.nu
    u_dot, v_dot, w_dot = plant.nu_dot[:3]
    return (
        u_dot + q * w - r * v + GRAVITY * math.sin(theta),
        v_dot + r * u - p * w - GRAVITY * math.cos(theta) * math.sin(phi),
        w_dot + p * v - q * u - GRAVITY * math.cos(theta) * math.cos(phi),
    )


def _magnetic_field(latitude: float) -> tuple[float, float, float]:
    """Return the earth's field as that of an axial dipole, NED, gauss; it has no declination."""
    return _FIELD_AT_EQUATOR * math.cos(latitude), 0.0, 2.0 * _FIELD_AT_EQUATOR * math.sin(latitude)


def _is_answer(message: Any) -> bool:
    return bool(message.get_msgId() == dialect.MAVLINK_MSG_ID_HIL_ACTUATOR_CONTROLS)


def _state(plant: Plant, origin: Origin, time_us: int) -> Any:
    x, y, z, phi, theta, psi = plant.eta
    q_x, q_y, q_z, q_w = quaternion_from_euler(phi, theta, psi)
    latitude, longitude = local_to_geodetic(origin, x, y)
    velocity = body_to_ned(phi, theta, psi, *plant.nu[:3])
    return dialect.MAVLink_hil_state_quaternion_message(
        time_us,
        (q_w, q_x, q_y, q_z),
        *plant.nu[3:],
        _degrees_e7(latitude),
        _degrees_e7(longitude),
        round(-1e3 * z),
        *(_int16(100.0 * v) for v in velocity),
        0,
        0,
        *(_int16(1e3 * f / GRAVITY) for f in specific_force(plant)),
    )


def _gps(fix: Fix | None, plant: Plant, time_us: int) -> Any:
    """Return HIL_GPS: position of the receiver, its error as `eph` in cm (as PX4 reads it), the true velocity."""
    if fix is None:
        unknown = (_UNKNOWN_U16,) * 3
        return dialect.MAVLink_hil_gps_message(time_us, _NO_FIX, 0, 0, 0, *unknown, 0, 0, 0, _UNKNOWN_U16, 0)
    north, east, down = body_to_ned(*plant.eta[3:], *plant.nu[:3])
    course = round(math.degrees(math.atan2(east, north)) * 100.0) % 36000
    return dialect.MAVLink_hil_gps_message(
        time_us,
        _FIX_3D,
        _degrees_e7(fix.latitude),
        _degrees_e7(fix.longitude),
        round(-1e3 * plant.eta.z),
        min(round(100.0 * fix.std), _UNKNOWN_U16 - 1),
        _UNKNOWN_U16,
        min(round(100.0 * math.hypot(north, east)), _UNKNOWN_U16 - 1),
        *(_int16(100.0 * v) for v in (north, east, down)),
        course,
        9,
    )


def _distance(altitude: float, params: AltimeterParams, time_ms: int) -> Any:
    """Return DISTANCE_SENSOR; too near (0) or too far (inf) is a distance beyond the limits and an invalid signal."""
    near, far = (min(round(100.0 * limit), _UNKNOWN_U16 - 1) for limit in (params.range_min, params.range_max))
    valid = 0.0 < altitude < math.inf
    return dialect.MAVLink_distance_sensor_message(
        time_ms,
        near,
        far,
        min(round(100.0 * altitude), far) if valid else far + 1 if altitude else 0,
        dialect.MAV_DISTANCE_SENSOR_ULTRASOUND,
        0,
        dialect.MAV_SENSOR_ROTATION_PITCH_270,
        min(round((100.0 * params.noise) ** 2), 254),
        signal_quality=_PERFECT_SIGNAL if valid else _INVALID_SIGNAL,
    )


def _battery(battery: Battery) -> Any:
    whole = round(1e3 * battery.voltage)  # what exceeds one field continues in the next
    first = min(max(whole, 0), _UNKNOWN_U16 - 1)
    voltages = (first, whole - first if whole > first else _UNKNOWN_U16, *(_UNKNOWN_U16,) * 8)
    charge = round(100.0 * battery.remaining)
    kind = (0, dialect.MAV_BATTERY_FUNCTION_ALL, dialect.MAV_BATTERY_TYPE_UNKNOWN, 32767)
    return dialect.MAVLink_battery_status_message(*kind, voltages, _int16(100.0 * battery.current), -1, -1, charge)


def _degrees_e7(angle: float) -> int:
    return round(math.degrees(angle) * 1e7)


def _int16(value: float) -> int:
    return round(clip(value, -32767.0, 32767.0))
