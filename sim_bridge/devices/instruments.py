"""The instruments: what each of them measures, and the numbers of its data sheet.

Every `read` function takes the plant and the channel errors that `sensors.Sensor` draws for it. Instruments are along
the body's axes, and sit at its origin but for those that have another place (`Placed`); their values are the records
that the drivers of the autopilot produce.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from firmware_py.marine import Eta, Nu, Origin, body_to_ned, local_to_geodetic, pressure_of_depth, wrap
from firmware_py.params import ParamError, param
from firmware_py.records.sensing import Ahrs, Battery, Dvl, Fix
from sim_bridge.devices.sensors import Sensor, Timing


class MeasuredPlant(Protocol):
    """What instruments measure of the plant."""

    @property
    def eta(self) -> Eta:
        """Return position and attitude."""

    @property
    def nu(self) -> Nu:
        """Return the velocity over the ground, body axes."""

    @property
    def n(self) -> float:
        """Return the shaft speed, rev/s."""

    @property
    def altitude(self) -> float:
        """Return the height above the bottom, m."""


class Water(NamedTuple):
    """Reference of pressure and position: density (kg/m^3), pressure at the surface (Pa), the local origin."""

    density: float
    surface_pressure: float
    origin: Origin


Place = tuple[float, float, float]
"""Forward, to starboard and down of the body's origin, m."""


def _offset(plant: MeasuredPlant, at: Place) -> tuple[float, float, float]:
    """Return where a place in the body lies, north, east and down of its origin, m."""
    return body_to_ned(plant.eta.phi, plant.eta.theta, plant.eta.psi, *at)


@dataclass(frozen=True, slots=True)
class Placed(Timing):
    """What measures something that depends on its place in the body."""

    at: Place = param((0.0, 0.0, 0.0), unit="m", low=-100, high=100, doc="Its place: forward, to starboard, down.")


@dataclass(frozen=True, slots=True)
class AhrsParams(Timing):
    """Attitude and heading reference with rate gyro."""

    roll_pitch_noise: float = param(0.3, unit="deg", low=0, high=20, doc="Roll and pitch, white, 1 sigma.")
    yaw_noise: float = param(0.5, unit="deg", low=0, high=20, doc="Yaw, white, 1 sigma.")
    gyro_noise: float = param(0.05, unit="deg/s", low=0, high=20, doc="Body rates, white, 1 sigma.")
    roll_pitch_bias: float = param(0.0, unit="deg", low=0, high=20, doc="1 sigma over vehicles.")
    yaw_bias: float = param(0.0, unit="deg", low=0, high=20, doc="1 sigma over vehicles.")
    gyro_bias: float = param(0.0, unit="deg/s", low=0, high=20, doc="1 sigma over vehicles.")


@dataclass(frozen=True, slots=True)
class PressureParams(Placed):
    """Water pressure sensor."""

    noise: float = param(50.0, unit="Pa", low=0, high=1e6, doc="White, 1 sigma.")
    bias: float = param(0.0, unit="Pa", low=0, high=1e6, doc="1 sigma over vehicles.")


@dataclass(frozen=True, slots=True)
class DvlParams(Placed):
    """Doppler velocity log looking down."""

    noise: float = param(
        0.01, unit="m/s", low=0, high=1, doc="Each axis, white, 1 sigma; also reported as figure of merit."
    )
    bias: float = param(0.0, unit="m/s", low=0, high=1, doc="Each axis, 1 sigma over vehicles.")
    altitude_noise: float = param(0.02, unit="m", low=0, high=10, doc="Distance to the bottom, white, 1 sigma.")
    range_min: float = param(0.3, unit="m", low=0, high=10, doc="Nearer than this there is no bottom lock.")
    range_max: float = param(50.0, unit="m", low=1, high=1000, doc="Further than this there is no bottom lock.")


@dataclass(frozen=True, slots=True)
class AltimeterParams(Placed):
    """Single-beam echo sounder looking down."""

    noise: float = param(0.03, unit="m", low=0, high=10, doc="White, 1 sigma.")
    bias: float = param(0.0, unit="m", low=0, high=10, doc="1 sigma over vehicles.")
    range_min: float = param(0.3, unit="m", low=0, high=10, doc="Nearer than this there is no echo.")
    range_max: float = param(60.0, unit="m", low=1, high=1000, doc="Further than this there is no echo.")


@dataclass(frozen=True, slots=True)
class FixParams(Placed):
    """Satellite receiver; it receives only at the surface."""

    noise: float = param(2.0, unit="m", low=0, high=100, doc="North and east, white, 1 sigma; also reported.")
    bias: float = param(0.0, unit="m", low=0, high=100, doc="North and east, 1 sigma over vehicles.")
    depth_max: float = param(0.3, unit="m", low=0, high=10, doc="Deeper than this there is no fix.")


@dataclass(frozen=True, slots=True)
class BatteryParams(Timing):
    """Battery with an internal resistance, and its load."""

    capacity: float = param(2000.0, unit="Wh", low=1, high=1e6, doc="Energy when full.")
    charge: float = param(100.0, unit="%", low=0, high=100, doc="State of charge at the start.")
    voltage_full: float = param(50.4, unit="V", low=1, high=1000, doc="At rest, full.")
    voltage_empty: float = param(42.0, unit="V", low=1, high=1000, doc="At rest, empty.")
    resistance: float = param(0.05, unit="ohm", low=0, high=10, doc="Internal resistance.")
    hotel: float = param(60.0, unit="W", low=0, high=1e5, doc="Everything but the propeller.")
    propeller: float = param(
        400.0, unit="W", low=0, high=1e5, doc="The propeller at `propeller_at`; with the cube of n."
    )
    propeller_at: float = param(500.0, unit="rpm", low=1, high=1e4, doc="Shaft speed that takes that power.")
    noise: float = param(0.02, unit="V", low=0, high=10, doc="Voltage, white, 1 sigma.")
    bias: float = param(0.0, unit="V", low=0, high=10, doc="Voltage, 1 sigma over vehicles.")


@dataclass(frozen=True, slots=True)
class LeakParams(Timing):
    """Hygrometer inside the hull."""

    humidity: float = param(35.0, unit="%", low=0, high=100, doc="Of the dry hull.")
    noise: float = param(0.5, unit="%", low=0, high=10, doc="White, 1 sigma.")
    bias: float = param(0.0, unit="%", low=0, high=10, doc="1 sigma over vehicles.")


@dataclass(frozen=True, slots=True)
class InstrumentsParams:
    """Every instrument."""

    ahrs: AhrsParams
    pressure: PressureParams
    dvl: DvlParams
    altimeter: AltimeterParams
    fix: FixParams
    battery: BatteryParams
    leak: LeakParams


class BatteryModel:
    """The battery: drains with hotel load and the cube of the shaft speed, one sample interval at a time."""

    def __init__(self, params: BatteryParams) -> None:
        if params.voltage_empty > params.voltage_full:
            raise ParamError("battery: voltage_empty_v is above voltage_full_v")
        self._params = params
        self._energy = params.charge * params.capacity

    def read(self, plant: MeasuredPlant, error: Sequence[float]) -> Battery:
        """Return voltage at the terminals, current, and state of charge in [0, 1]; an empty battery still reports."""
        p = self._params
        remaining = self._energy / p.capacity
        at_rest = p.voltage_empty + (p.voltage_full - p.voltage_empty) * remaining
        power = p.hotel + p.propeller * abs(plant.n / p.propeller_at) ** 3
        current = power / at_rest
        self._energy = max(0.0, self._energy - power / p.rate)
        return Battery(at_rest - current * p.resistance + error[0], current, remaining)


class Instruments:
    """All instruments, seeded, one `Sensor` each. What cannot be measured is None, inf or 0; see each `read`.

    Args:
        params: of each kind.
        water: what they are in.
        seed: of the run.
        base_hz: ticks a second.
        spares: names of further ones, "pressure.2": of the kind, at the same place, with errors of their own.
        asked: names of those that measure when they are asked: their values are those of every tick, at once.
    """

    def __init__(
        self,
        params: InstrumentsParams,
        water: Water,
        seed: int,
        base_hz: int,
        spares: Iterable[str] = (),
        asked: Container[str] = (),
    ) -> None:
        def sensor(read: Any, timing: Timing, noise: Sequence[float], bias: Sequence[float]) -> _Maker:
            def make(name: str) -> Sensor[MeasuredPlant, Any]:
                when = Timing(base_hz) if name in asked else timing
                return Sensor(name, when, read, noise, bias, seed, base_hz)

            return make

        a, d, p, t = params.ahrs, params.dvl, params.pressure, params.altimeter
        f, b, h = params.fix, params.battery, params.leak
        makers: dict[str, _Maker] = {
            "ahrs": sensor(
                _attitude,
                a,
                (a.roll_pitch_noise,) * 2 + (a.yaw_noise,) + (a.gyro_noise,) * 3,
                (a.roll_pitch_bias,) * 2 + (a.yaw_bias,) + (a.gyro_bias,) * 3,
            ),
            "dvl": sensor(_velocity(d), d, (d.noise,) * 3 + (d.altitude_noise,), (d.bias,) * 3 + (0.0,)),
            "pressure": sensor(_pressure(p, water), p, (p.noise,), (p.bias,)),
            "altimeter": sensor(_altitude(t), t, (t.noise,), (t.bias,)),
            "fix": sensor(_position(f, water.origin), f, (f.noise,) * 2, (f.bias,) * 2),
            "battery": sensor(BatteryModel(b).read, b, (b.noise,), (b.bias,)),
            "leak": sensor(_humidity(h), h, (h.noise,), (h.bias,)),
        }
        self.by_name: dict[str, Sensor[MeasuredPlant, Any]] = {name: make(name) for name, make in makers.items()}
        self.by_name |= {name: makers[name.partition(".")[0]](name) for name in spares}
        self.ahrs: Sensor[MeasuredPlant, Ahrs] = self.by_name["ahrs"]
        self.dvl: Sensor[MeasuredPlant, Dvl | None] = self.by_name["dvl"]
        self.pressure: Sensor[MeasuredPlant, float] = self.by_name["pressure"]
        self.altimeter: Sensor[MeasuredPlant, float] = self.by_name["altimeter"]
        self.fix: Sensor[MeasuredPlant, Fix | None] = self.by_name["fix"]
        self.battery: Sensor[MeasuredPlant, Battery] = self.by_name["battery"]
        self.leak: Sensor[MeasuredPlant, float] = self.by_name["leak"]


_Maker = Callable[[str], Sensor[MeasuredPlant, Any]]


def _attitude(plant: MeasuredPlant, e: Sequence[float]) -> Ahrs:
    _, _, _, phi, theta, psi = plant.eta
    _, _, _, p, q, r = plant.nu
    return Ahrs(phi + e[0], theta + e[1], wrap(psi + e[2]), p + e[3], q + e[4], r + e[5])


def _pressure(params: PressureParams, water: Water) -> Callable[[MeasuredPlant, Sequence[float]], float]:
    def read(plant: MeasuredPlant, e: Sequence[float]) -> float:
        """Return the absolute pressure, Pa."""
        return (
            pressure_of_depth(plant.eta.z + _offset(plant, params.at)[2], water.surface_pressure, water.density) + e[0]
        )

    return read


def _velocity(params: DvlParams) -> Callable[[MeasuredPlant, Sequence[float]], Dvl | None]:
    def read(plant: MeasuredPlant, e: Sequence[float]) -> Dvl | None:
        """Return None without bottom lock."""
        altitude = plant.altitude - _offset(plant, params.at)[2]
        if not params.range_min <= altitude <= params.range_max:
            return None
        x, y, z = params.at
        u, v, w, p, q, r = plant.nu
        u, v, w = u + q * z - r * y, v + r * x - p * z, w + p * y - q * x
        return Dvl(u + e[0], v + e[1], w + e[2], params.noise, altitude + e[3])

    return read


def _altitude(params: AltimeterParams) -> Callable[[MeasuredPlant, Sequence[float]], float]:
    def read(plant: MeasuredPlant, e: Sequence[float]) -> float:
        """Return 0 when too near, inf without an echo."""
        altitude = plant.altitude - _offset(plant, params.at)[2]
        if altitude < params.range_min:
            return 0.0
        return math.inf if altitude > params.range_max else altitude + e[0]

    return read


def _position(params: FixParams, origin: Origin) -> Callable[[MeasuredPlant, Sequence[float]], Fix | None]:
    def read(plant: MeasuredPlant, e: Sequence[float]) -> Fix | None:
        """Return None under water."""
        north, east, down = _offset(plant, params.at)
        if plant.eta.z + down > params.depth_max:
            return None
        latitude, longitude = local_to_geodetic(origin, plant.eta.x + north + e[0], plant.eta.y + east + e[1])
        return Fix(latitude, longitude, params.noise)

    return read


def _humidity(params: LeakParams) -> Callable[[MeasuredPlant, Sequence[float]], float]:
    def read(_plant: MeasuredPlant, e: Sequence[float]) -> float:
        return min(1.0, max(0.0, params.humidity + e[0]))

    return read
