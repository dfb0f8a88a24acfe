"""What the driver of a CAN bus has to know: who is there, how often it sends, how late values are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from firmware_py.adapters.buses.can_bus import CanParams, NodeIds
from firmware_py.adapters.drivers.instrument_params import Device
from firmware_py.params import param
from firmware_py.tick import Rate
from firmware_py.wire.dronecan.propeller_drive import PropellerParams


@dataclass(frozen=True, slots=True)
class CommandParams:
    """Table [commands]."""

    rate: Rate = Rate.HZ_50
    safety_state: bool = param(True, doc="Whether SafetyState is sent: AP_Periph holds its outputs until it hears it.")


@dataclass(frozen=True, slots=True)
class NetworkParams:
    """Table [network]: what the autopilot does for the other nodes of the bus."""

    time_master: bool = param(
        True, doc="Whether it says the time of the network (GlobalTimeSync), unless a node of a lower id does."
    )
    allocate: bool = param(
        False, doc="Whether it gives node ids to nodes that ask for one, while disarmed; `--state` keeps them."
    )


@dataclass(frozen=True, slots=True)
class LatencyParams:
    """Table [latency]: delay from the validity of a value to its arrival, of the devices of [nodes]."""

    ahrs: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Attitude and rates.")
    pressure: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Water pressure.")
    altimeter: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Distance to the bottom.")
    fix: float = param(0.0, unit="s", low=0.0, high=2.0, doc="Position at the surface.")
    servo_hub: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Fin angles.")
    esc: float = param(0.0, unit="s", low=0.0, high=1.0, doc="Propeller speed.")


class BusParams(Protocol):
    """What of an io file is about the bus: `io_params.IoParams`."""

    @property
    def can(self) -> CanParams:
        """Return the id of the autopilot."""

    @property
    def nodes(self) -> NodeIds:
        """Return the ids of the devices."""

    @property
    def commands(self) -> CommandParams:
        """Return what is sent, and how often."""

    @property
    def network(self) -> NetworkParams:
        """Return what is done for the other nodes."""

    @property
    def propeller(self) -> PropellerParams:
        """Return what the propeller's controller obeys."""

    @property
    def latency(self) -> LatencyParams:
        """Return how late values are."""

    @property
    def devices(self) -> Sequence[Device]:
        """Return the devices that measure; those on lines of their own too."""

    @property
    def device_ids(self) -> Mapping[int, Sequence[str]]:
        """Return the names of what each node on the bus is, by its id."""
