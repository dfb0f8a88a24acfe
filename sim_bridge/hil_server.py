"""The plant as a PX4-compatible simulator: sends HIL_SENSOR, receives HIL_ACTUATOR_CONTROLS, over TCP in lockstep.

Rates, pressure, fixes, altitude, battery and humidity are what the instruments of sensors.toml read, with noise;
those of HIL_SENSOR without their latency, because it has one time for all. HIL_STATE_QUATERNION is the truth. The
vehicle has neither accelerometer nor magnetometer: HIL_SENSOR gives both without error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as dialect  # type: ignore[import-untyped]

from firmware_py.adapters.hil.hil_link import ARMED, LOCKSTEP, HilLink
from firmware_py.adapters.lockstep.lockstep_link import TIMEOUT, LockstepError
from firmware_py.marine import Origin, clip, ned_to_body
from firmware_py.params import ParamError
from firmware_py.records.sensing import Ahrs, Dvl
from sim_bridge import hil_messages
from sim_bridge.bridge import Bridge
from sim_bridge.build import plant_and_instruments
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.devices.instruments import Instruments
from sim_bridge.devices.sensors import Reading, Sensor, due
from sim_bridge.faults.injector import FaultInjector
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
_EPOCH_US = 10_000_000
"""The simulator's time at tick 0; late measurements from before it need a time too."""


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
    faults = FaultInjector(scenario.injected, plant, devices, instruments.by_name, seed)
    return Bridge(plant, devices, faults), devices


def refuse_faults(scenario: Scenario) -> None:
    """Raise ParamError if a fault concerns what this interface does not have.

    Attitude and velocity come as one message without latency: they can be wrong, but not lost or late by themselves.
    The velocity is in whole numbers, none of which says that it is unknown.
    """
    for fault in scenario.injected:
        name, target = fault.kind.name, fault.target
        if not fault.kind.on_hil:
            raise ParamError(f"fault {fault.text}: mavlink-hil has no {target}")
        if (target == "dvl" and name in ("off", "late", "lossy", "nan")) or (target == "ahrs" and name == "late"):
            raise ParamError(f"fault {fault.text}: mavlink-hil has no {target}; its values come with the truth")


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
        self.released = False
        """Whether the drop weight was let go."""
        self.babbled = 0
        """Frames of no use: there is no bus."""
        self._holds_weight = False

    def initialise(self, plant: Plant) -> None:
        """Sample before tick 0, so that readings delayed by latency arrive from tick 0 on."""
        self._holds_weight = plant.drop_weight > 0.0
        for sensor in self._instruments.by_name.values():
            for k in range(-sensor.delay, 0):
                sensor.update(k, plant)

    def receive(self, _t: float, /) -> None:
        """Do nothing: a tick ends with the answer, which `accept_command` has taken."""

    def accept_command(self, answer: Any) -> None:
        """Take HIL_ACTUATOR_CONTROLS: the fins in order, then the propeller, each a share of full scale in [-1, 1].

        The control after these releases the drop weight if it is more than half, armed or not.
        A vehicle that is not armed centres the fins and stops the propeller; a share that is NaN counts as 0.
        """
        fins = len(self._commanded[0])
        self.released |= any(share > 0.5 for share in answer.controls[fins + 1 : fins + 2])
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
        messages.append(
            hil_messages.state_quaternion(plant, self._measured(k * plant.dt, plant), self._origin, time_us)
        )
        fix = read.fix.update(k, plant)
        if fix is not None and "fix" not in self._off:
            messages.append(hil_messages.gps(fix.value, plant, time_at(fix.t_valid)))
        altitude = read.altimeter.update(k, plant)
        if altitude is not None and "altimeter" not in self._off:
            messages.append(
                hil_messages.distance_sensor(altitude.value, self._params.altimeter, time_at(altitude.t_valid) // 1000)
            )
        battery = read.battery.update(k, plant)
        if battery is not None and "battery" not in self._off:
            messages.append(hil_messages.battery_status(battery.value))
        leak = read.leak.update(k, plant)
        if leak is not None and "leak" not in self._off:
            messages.append(hil_messages.leak(leak.value, time_at(leak.t_valid) // 1000))
        if self._holds_weight and due(k, self._params.hardpoint.status, self._base_hz):
            messages.append(hil_messages.drop_weight(plant.drop_weight, time_us // 1000))
        messages.append(self._sensor(k, plant, time_us))
        self._link.send(*messages)

    def switch_off(self, device: str) -> Callable[[], None]:
        """Switch a device off."""
        self._off.add(device)
        return lambda: self._off.discard(device)

    def _measured(self, t: float, plant: Plant) -> tuple[Ahrs, Dvl]:
        """Return attitude and velocity of HIL_STATE_QUATERNION: the truth, but for faults of AHRS and DVL."""
        ahrs, dvl = Ahrs(*plant.eta[3:], *plant.nu[3:]), Dvl(*plant.nu[:3], 0.0, plant.altitude)
        return _faulty(ahrs, t, self._instruments.ahrs), _faulty(dvl, t, self._instruments.dvl)

    def _sensor(self, k: int, plant: Plant, time_us: int) -> Any:
        ahrs, pressure = self._instruments.ahrs.update(k, plant), self._instruments.pressure.update(k, plant)
        rates, hectopascals, updated = (0.0, 0.0, 0.0), 0.0, _UPDATED["motion"]
        if ahrs is not None and "ahrs" not in self._off:
            rates, updated = ahrs.value[3:], updated | _UPDATED["gyro"]
        if pressure is not None and "pressure" not in self._off:
            hectopascals, updated = 0.01 * pressure.value, updated | _UPDATED["pressure"]
        field = hil_messages.magnetic_field(self._origin.latitude)
        return dialect.MAVLink_hil_sensor_message(
            time_us,
            *hil_messages.specific_force(plant),
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


def _is_answer(message: Any) -> bool:
    return bool(message.get_msgId() == dialect.MAVLINK_MSG_ID_HIL_ACTUATOR_CONTROLS)


def _faulty(value: Any, t: float, sensor: Sensor[Any, Any]) -> Any:
    """Return what the faults of a sensor make of a value; nothing is lost."""
    for corrupt in sensor.corruptions:
        value = (corrupt(Reading(value, t)) or Reading(value, t)).value
    return value
