"""What faults act on, and what each of them is told as it begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from sim_bridge.devices.faulty_bus import FaultyBus
from sim_bridge.devices.node import NodeFunction
from sim_bridge.devices.sensors import Corruption, Sensor
from sim_bridge.plant.plant import Plant

End: TypeAlias = Callable[[], object]
"""What ends a fault; its result is of no use."""


class DeviceFaults(Protocol):
    """What all devices offer to faults. Each method returns what ends the fault."""

    def switch_off(self, device: str, /) -> End:
        """Switch a device off; what it has measured and not yet sent is lost."""


class NodeFaults(Protocol):
    """What devices on a CAN bus offer beside it: their end of it, and each as a function of a node, by name."""

    bus: FaultyBus
    nodes: dict[str, NodeFunction]

    def silence_fin(self, fin: int, /) -> End:
        """Leave one fin out of the servos' reports."""

    def report_servo(self, fin: int, /) -> End:
        """Report the angle of a fin's servo, not of the fin."""

    def add_duplicate(self, sensor: str, corruption: Corruption, /) -> End:
        """Add a second node with the id of a sensor's."""

    def add_duplicate_autopilot(self) -> End:
        """Add a second node with the autopilot's id."""


class FaultTarget(Protocol):
    """What faults act on: `injector.FaultInjector`.

    Attributes:
        plant: the vehicle in the water.
        devices: what is on its wires.
        nodes: the same, where they are on a CAN bus.
        sensors: the instruments, by name.
        fin_overrides: angles (rad) by the place of the fin, in place of what is commanded.
        shaft_override: the same of the propeller, rev/s; NaN for none.
        weight_stuck: the drop weight stays where it is.
        t: time of the tick, s.
    """

    plant: Plant
    fin_overrides: dict[int, float]
    shaft_override: float
    weight_stuck: bool
    t: float

    @property
    def sensors(self) -> Mapping[str, Sensor[Any, Any]]:
        """Return the instruments."""

    @property
    def devices(self) -> DeviceFaults:
        """Return the devices."""

    @property
    def nodes(self) -> NodeFaults:
        """Return the devices as nodes on a CAN bus."""

    def fin(self, name: str) -> int:
        """Return the place of a fin."""


class Strike(NamedTuple):
    """One fault as it begins: on what, how much (SI; NaN if not given), whether for good, its random numbers."""

    target: str
    value: float
    for_good: bool
    random: np.random.Generator


Begin: TypeAlias = Callable[[FaultTarget, Strike], End]


class Effect(NamedTuple):
    """What a kind of fault does.

    Attributes:
        begin: lets it begin.
        replaces: what of its target it puts something else in place of; "" if its effects add up.
    """

    begin: Begin
    replaces: str = ""
