"""Foreign nodes between the autopilot's bus and the plant, in place of some of the simulated devices."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterator
from typing import Any, Generic, TypeVar

import pytest
from sternplane.sitl import flight

from firmware_py.adapters.buses.can_bus import CanBus, open_bus
from sim_bridge import build
from sim_bridge.bridge import Bridge
from sim_bridge.devices.devices import Devices
from sim_bridge.plant.plant import Plant
from sim_bridge.scenarios import Scenario
from tests.foreign_actuators import ForeignBus, ForeignNode

N = TypeVar("N", bound=ForeignNode)


class ForeignPort(Generic[N]):
    """A `bridge.DevicePort`: the simulated devices, and foreign nodes beside them on their bus; `commands` are
    theirs."""

    def __init__(self, devices: Devices, nodes: Collection[N], bus: CanBus, base_hz: int) -> None:
        self._devices, self._bus, self.base_hz = devices, ForeignBus(bus, *nodes), base_hz

    @property
    def released(self) -> bool:
        return self._devices.released

    @property
    def babbled(self) -> int:
        return self._devices.babbled

    def initialise(self, plant: Plant) -> None:
        self._devices.initialise(plant)

    def receive(self, t: float) -> None:
        self._devices.receive(t)
        self._bus.hear()

    def publish(self, k: int, t: float, plant: Plant) -> None:
        self._devices.publish(k, t, plant)


P = TypeVar("P", bound=ForeignPort[Any])


class _Without:
    """A bus on which nobody sends under some ids."""

    def __init__(self, bus: CanBus, ids: Collection[int]) -> None:
        self._bus, self._ids = bus, frozenset(ids)
        self.drain, self.losses, self.close = bus.drain, bus.losses, bus.close

    @property
    def sound(self) -> bool:
        return self._bus.sound

    def send(self, frames: Collection[tuple[int, bytes]]) -> None:
        self._bus.send([frame for frame in frames if frame[0] & 0x7F not in self._ids])


@contextlib.contextmanager
def in_place_of(ids: Collection[int], port: Callable[[Devices, CanBus, Scenario, int], P]) -> Iterator[list[P]]:
    """Fly with such ports, in place of the simulated devices of these ids; yield the port of each flight.

    A port is made of the devices, the foreign end of the bus, the scenario, and the rate of the plant, Hz.
    """
    made: list[P] = []
    with contextlib.ExitStack() as stack:
        patch = stack.enter_context(pytest.MonkeyPatch.context())

        def with_foreign(*arguments: Any) -> Bridge:
            *before, scenario, bus, lines, seed, hz, own_id, second = arguments
            theirs = open_bus(bus.name)
            stack.callback(theirs.close)

            def fitted(plant: Plant, devices: Devices, faults: Any) -> Bridge:
                made.append(port(devices, theirs, scenario, hz))
                return Bridge(plant, made[-1], faults)

            patch.setattr(build, "Bridge", fitted)
            return build.build_bridge(*before, scenario, _Without(bus, ids), lines, seed, hz, own_id, second)

        patch.setattr(flight, "build_bridge", with_foreign)
        yield made
