"""The boat's instruments: what each of them measures, and the numbers of its data sheet.

Every `read` function takes the boat and the channel errors that `sensors.Sensor` draws for it. Instruments sit at the
body's origin and along its axes; their values are the records that the vehicle's drivers make of them again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from firmware_py.marine import Eta, Nu, Origin, local_to_geodetic, pressure_of_depth, wrap
from firmware_py.params import ParamError, param
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix
from sim_bridge.devices.sensors import Sensor, Timing


class Boat(Protocol):
    """What instruments can see of the plant."""

    @property
    def eta(self) -> Eta:
        """Position and attitude."""

    @property
    def nu(self) -> Nu:
        """Velocity over the ground, body axes."""

    @property
    def n(self) -> float:
        """Shaft speed, rev/s."""

    @property
    def altitude(self) -> float:
        """Height above the bottom, m."""


class Water(NamedTuple):
    """What pressure and position mean here: density (kg/m^3), pressure at the surface (Pa), the local origin."""

    density: float
    surface_pressure: float
    origin: Origin


@dataclass(frozen=True, slots=True)
class AhrsParams(Timing):
    """Attitude and heading reference with rate gyro."""

    roll_pitch_noise: float = param(0.3, unit="deg", low=0, high=20, doc="Roll and pitch, white, 1 sigma.")
    yaw_noise: float = param(0.5, unit="deg", low=0, high=20, doc="Yaw, white, 1 sigma.")
    gyro_noise: float = param(0.05, unit="deg/s", low=0, high=20, doc="Body rates, white, 1 sigma.")
    roll_pitch_bias: float = param(0.0, unit="deg", low=0, high=20, doc="1 sigma over boats.")
    yaw_bias: float = param(0.0, unit="deg", low=0, high=20, doc="1 sigma over boats.")
    gyro_bias: float = param(0.0, unit="deg/s", low=0, high=20, doc="1 sigma over boats.")


@dataclass(frozen=True, slots=True)
class PressureParams(Timing):
    """Water pressure sensor."""

    noise: float = param(50.0, unit="Pa", low=0, high=1e6, doc="White, 1 sigma.")
    bias: float = param(0.0, unit="Pa", low=0, high=1e6, doc="1 sigma over boats.")


@dataclass(frozen=True, slots=True)
class DvlParams(Timing):
    """Doppler velocity log looking down."""

    noise: float = param(
        0.01, unit="m/s", low=0, high=1, doc="Each axis, white, 1 sigma; also reported as figure of merit."
    )
    bias: float = param(0.0, unit="m/s", low=0, high=1, doc="Each axis, 1 sigma over boats.")
    altitude_noise: float = param(0.02, unit="m", low=0, high=10, doc="Distance to the bottom, white, 1 sigma.")
    range_min: float = param(0.3, unit="m", low=0, high=10, doc="Nearer than this there is no bottom lock.")
    range_max: float = param(50.0, unit="m", low=1, high=1000, doc="Further than this there is no bottom lock.")


@dataclass(frozen=True, slots=True)
class AltimeterParams(Timing):
    """Single-beam echo sounder looking down."""

    noise: float = param(0.03, unit="m", low=0, high=10, doc="White, 1 sigma.")
    bias: float = param(0.0, unit="m", low=0, high=10, doc="1 sigma over boats.")
    range_min: float = param(0.3, unit="m", low=0, high=10, doc="Nearer than this the echo drowns in the ping.")
    range_max: float = param(60.0, unit="m", low=1, high=1000, doc="Further than this nothing comes back.")


@dataclass(frozen=True, slots=True)
class FixParams(Timing):
    """Satellite receiver; its antenna sees the sky only at the surface."""

    noise: float = param(2.0, unit="m", low=0, high=100, doc="North and east, white, 1 sigma; also reported.")
    bias: float = param(0.0, unit="m", low=0, high=100, doc="North and east, 1 sigma over boats.")
    depth_max: float = param(0.3, unit="m", low=0, high=10, doc="Deeper than this there is no fix.")


@dataclass(frozen=True, slots=True)
class BatteryParams(Timing):
    """Battery with an internal resistance, and what the boat takes from it."""

    capacity: float = param(2000.0, unit="Wh", low=1, high=1e6, doc="Energy when full.")
    charge: float = param(100.0, unit="%", low=0, high=100, doc="What is in it at the start.")
    voltage_full: float = param(50.4, unit="V", low=1, high=1000, doc="At rest, full.")
    voltage_empty: float = param(42.0, unit="V", low=1, high=1000, doc="At rest, empty.")
    resistance_ohm: float = param(0.05, low=0, high=10, doc="Internal resistance, ohm.")
    hotel: float = param(60.0, unit="W", low=0, high=1e5, doc="Everything but the propeller.")
    propeller: float = param(
        400.0, unit="W", low=0, high=1e5, doc="The propeller at `propeller_at`; with the cube of n."
    )
    propeller_at: float = param(500.0, unit="rpm", low=1, high=1e4, doc="Shaft speed that takes that power.")
    noise: float = param(0.02, unit="V", low=0, high=10, doc="Voltage, white, 1 sigma.")
    bias: float = param(0.0, unit="V", low=0, high=10, doc="Voltage, 1 sigma over boats.")


@dataclass(frozen=True, slots=True)
class LeakParams(Timing):
    """Hygrometer inside the hull."""

    humidity: float = param(35.0, unit="%", low=0, high=100, doc="Of the dry hull.")
    noise: float = param(0.5, unit="%", low=0, high=10, doc="White, 1 sigma.")
    bias: float = param(0.0, unit="%", low=0, high=10, doc="1 sigma over boats.")


@dataclass(frozen=True, slots=True)
class InstrumentsParams:
    """Everything the boat measures with."""

    ahrs: AhrsParams
    pressure: PressureParams
    dvl: DvlParams
    altimeter: AltimeterParams
    fix: FixParams
    battery: BatteryParams
    leak: LeakParams


class Accumulator:
    """The battery: drains with hotel load and the cube of the shaft speed, one sample interval at a time."""

    def __init__(self, params: BatteryParams) -> None:
        if params.voltage_empty > params.voltage_full:
            raise ParamError("battery: voltage_empty_v is above voltage_full_v")
        self._params = params
        self._energy = params.charge * params.capacity

    def read(self, boat: Boat, error: Sequence[float]) -> Battery:
        """Voltage at the terminals, current, and what is left in [0, 1]; an empty battery still reports."""
        p = self._params
        remaining = self._energy / p.capacity
        at_rest = p.voltage_empty + (p.voltage_full - p.voltage_empty) * remaining
        power = p.hotel + p.propeller * abs(boat.n / p.propeller_at) ** 3
        current = power / at_rest
        self._energy = max(0.0, self._energy - power / p.rate)
        return Battery(at_rest - current * p.resistance_ohm + error[0], current, remaining)


class Instruments:
    """All of them, seeded; one `Sensor` each. What an instrument cannot measure it says (None, inf, 0), see `read`s."""

    def __init__(self, params: InstrumentsParams, water: Water, seed: int, base_hz: int) -> None:
        a, d = params.ahrs, params.dvl
        self.ahrs = Sensor[Boat, Ahrs](
            "ahrs",
            a,
            _attitude,
            (a.roll_pitch_noise,) * 2 + (a.yaw_noise,) + (a.gyro_noise,) * 3,
            (a.roll_pitch_bias,) * 2 + (a.yaw_bias,) + (a.gyro_bias,) * 3,
            seed,
            base_hz,
        )
        self.dvl = Sensor[Boat, Dvl | None](
            "dvl", d, _velocity(d), (d.noise,) * 3 + (d.altitude_noise,), (d.bias,) * 3 + (0.0,), seed, base_hz
        )
        p = params.pressure
        self.pressure = Sensor[Boat, float]("pressure", p, _pressure(water), (p.noise,), (p.bias,), seed, base_hz)
        t = params.altimeter
        self.altimeter = Sensor[Boat, float]("altimeter", t, _altitude(t), (t.noise,), (t.bias,), seed, base_hz)
        f = params.fix
        self.fix = Sensor[Boat, Fix | None](
            "fix", f, _position(f, water.origin), (f.noise,) * 2, (f.bias,) * 2, seed, base_hz
        )
        b = params.battery
        self.battery = Sensor[Boat, Battery]("battery", b, Accumulator(b).read, (b.noise,), (b.bias,), seed, base_hz)
        h = params.leak
        self.leak = Sensor[Boat, float]("leak", h, _humidity(h), (h.noise,), (h.bias,), seed, base_hz)

        self.all: tuple[Sensor[Boat, Any], ...] = (
            self.ahrs,
            self.dvl,
            self.pressure,
            self.altimeter,
            self.fix,
            self.battery,
            self.leak,
        )


def _attitude(boat: Boat, e: Sequence[float]) -> Ahrs:
    _, _, _, phi, theta, psi = boat.eta
    _, _, _, p, q, r = boat.nu
    return Ahrs(phi + e[0], theta + e[1], wrap(psi + e[2]), p + e[3], q + e[4], r + e[5])


def _pressure(water: Water) -> Callable[[Boat, Sequence[float]], float]:
    def read(boat: Boat, e: Sequence[float]) -> float:
        """Absolute, Pa."""
        return pressure_of_depth(boat.eta.z, water.surface_pressure, water.density) + e[0]

    return read


def _velocity(params: DvlParams) -> Callable[[Boat, Sequence[float]], Dvl | None]:
    def read(boat: Boat, e: Sequence[float]) -> Dvl | None:
        """None without bottom lock."""
        altitude = boat.altitude
        if not params.range_min <= altitude <= params.range_max:
            return None
        u, v, w, _, _, _ = boat.nu
        return Dvl(u + e[0], v + e[1], w + e[2], params.noise, altitude + e[3])

    return read


def _altitude(params: AltimeterParams) -> Callable[[Boat, Sequence[float]], float]:
    def read(boat: Boat, e: Sequence[float]) -> float:
        """0 when too near, inf when nothing comes back."""
        altitude = boat.altitude
        if altitude < params.range_min:
            return 0.0
        return math.inf if altitude > params.range_max else altitude + e[0]

    return read


def _position(params: FixParams, origin: Origin) -> Callable[[Boat, Sequence[float]], Fix | None]:
    def read(boat: Boat, e: Sequence[float]) -> Fix | None:
        """None under water."""
        if boat.eta.z > params.depth_max:
            return None
        latitude, longitude = local_to_geodetic(origin, boat.eta.x + e[0], boat.eta.y + e[1])
        return Fix(latitude, longitude, params.noise)

    return read


def _humidity(params: LeakParams) -> Callable[[Boat, Sequence[float]], float]:
    def read(_boat: Boat, e: Sequence[float]) -> float:
        return min(1.0, max(0.0, params.humidity + e[0]))

    return read
