"""Sensors of one's own: simulated on nodes of their own, whose readings go over the bus as KeyValue messages.

A real instrument that sends the same keys takes the place of the simulated one without a change aboard the vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from firmware_py.adapters.buses.can_bus import FramePort
from firmware_py.adapters.own_parts import find
from firmware_py.error_text import failure_text, quoted
from firmware_py.params import ParamError, load, named_values, param
from firmware_py.wire.dronecan.message_table import KEY_VALUE
from firmware_py.wire.dronecan.node_messages import KEY_LONGEST, KeyValue
from sim_bridge.devices.node import DeviceNode
from sim_bridge.devices.sensors import Sensor, Timing, due

if TYPE_CHECKING:
    from sim_bridge.plant.plant import Plant

GROUP = "sternplane.sensors"
"""The group of their entry points."""


@dataclass(frozen=True, slots=True)
class NoSensorParams:
    """The parameters of a sensor that has none."""


class PayloadSensor:
    """A simulated sensor that the autopilot does not know.

    Attributes:
        Params: a frozen dataclass of `param(...)` fields; its table in sensors.toml is checked like any other.
        keys: what it sends, such as ("ctd.temperature", "ctd.salinity"); at most 58 characters of ASCII each.
        params: a `Params`.
    """

    Params: ClassVar[type[Any]] = NoSensorParams
    keys: Sequence[str] = ()

    def __init__(self, params: Any) -> None:
        self.params = params

    def measure(self, plant: Plant, chance: np.random.Generator) -> Sequence[float]:
        """Return a value for each of `keys`; NaN: not known. They travel as float32.

        Args:
            plant: the true vehicle, to be read: eta (m, rad), nu (m/s, rad/s), nu_r, altitude (m), current_ned (m/s).
            chance: seeded by the run's seed, node id and name; draw all noise from it.
        """
        raise NotImplementedError


@dataclass(frozen=True, slots=True, kw_only=True)
class PayloadParams(Timing):
    """A sensor of one's own on the simulated bus."""

    sensor: str = param(doc="An entry point of `sternplane.sensors`, or module:Class.")
    node: int = param(60, low=1, high=125, doc="Its node id.")
    own: Mapping[str, Any] = named_values("Parameters of the sensor.")


class PayloadDevice:
    """One of them with its node."""

    def __init__(self, params: PayloadParams, where: str, bus: FramePort, seed: int, base_hz: int) -> None:
        """Make it; `where` is for errors.

        Raises:
            ParamError: there is no such sensor, it cannot be made, or its keys or its parameters are wrong.
        """
        name = params.sensor
        try:
            cls = find(name, GROUP, PayloadSensor)
        except ParamError as error:
            raise ParamError(f"{where}: sensor = {error}") from error
        given = load(cls.Params, params.own, f"{where}: own")
        try:
            self._own = cls(given)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ParamError(f"{where}: {name} cannot be made: {failure_text(error)}") from error
        self._name, self._base_hz = name, base_hz
        self._keys = _keys(self._own, f"{where}: {name}")
        chance = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, params.node, *name.encode()])))
        self._sensor: Sensor[Plant, tuple[float, ...]] = Sensor(
            f"payload.{params.node}.{name}",
            params,
            lambda plant, _: self._measured(plant, chance),
            (),
            (),
            seed,
            base_hz,
        )
        self.node = DeviceNode(params.node, name.rpartition(":")[2].lower(), bus)

    def update(self, k: int, t: float, plant: Plant) -> None:
        """Measure and send what is due at tick `k`, at time `t`, s."""
        reading = self._sensor.update(k, plant)
        for key, value in zip(self._keys, reading.value, strict=True) if reading else ():
            self.node.publish(KEY_VALUE, KeyValue(value, key))
        if due(k, 1, self._base_hz):
            self.node.publish_status(t)

    def _measured(self, plant: Plant, chance: np.random.Generator) -> tuple[float, ...]:
        try:
            values = tuple([float(value) for value in self._own.measure(plant, chance)])
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # whatever somebody's code may raise
            raise ParamError(f"sensor {self._name} failed at {plant.t:.2f} s: {failure_text(error)}") from error
        if len(values) != len(self._keys):
            raise ParamError(f"sensor {self._name} measured {len(values)} values for {len(self._keys)} keys")
        return values


def _keys(own: PayloadSensor, where: str) -> list[bytes]:
    try:
        keys = own.keys
        listed = [] if isinstance(keys, str) else list(keys)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever somebody's code may raise
        raise ParamError(f"{where}: its keys cannot be read: {failure_text(error)}") from error
    if isinstance(keys, str):
        raise ParamError(f"{where}: keys = {quoted(keys)}: must be a list of texts, such as ({quoted(keys)},)")
    return [_key(key, where) for key in listed]


def _key(key: object, where: str) -> bytes:
    if not (isinstance(key, str) and key.isascii() and key.isprintable() and 0 < len(key) <= KEY_LONGEST):
        raise ParamError(f"{where}: key {quoted(key)}: must be 1 to {KEY_LONGEST} characters of ASCII")
    return key.encode()
