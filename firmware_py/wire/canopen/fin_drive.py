"""Fins on CANopen drives, as the io file describes them, and how an angle of the fin is told to a drive in counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firmware_py.params import ParamError, param
from firmware_py.tick import Rate
from firmware_py.wire.canopen.cia402 import Mode
from firmware_py.wire.fin_positions import AtRest, FinPositions, by_fin, refuse_rate

_HEARTBEATS = 2


@dataclass(frozen=True, slots=True)
class FinDriveParams:
    """Table [[canopen.fins]] of io_*.toml: the drive of one fin."""

    name: str = param(doc="Of the fin in vehicle.toml.")
    node: int = param(low=1, high=127, doc="Node id of the drive.")
    counts_per_turn: float = param(
        low=16.0, high=1e9, doc="Counts of the drive's position for one turn of the fin's shaft, gears included."
    )
    reversed: bool = param(False, doc="Whether the drive turns against the fin.")
    zero: float = param(
        0.0, unit="deg", low=-180.0, high=180.0, doc="What the drive's position is where the fin is at 0."
    )
    travel: float = param(
        45.0, unit="deg", low=1.0, high=180.0, doc="Where targets stop, to either side of the fin's 0."
    )
    speed: float = param(
        120.0, unit="deg/s", low=1.0, high=3600.0, doc="Fastest that a target moves: from where the fin is, if need be."
    )
    mode: Mode = Mode.CYCLIC_SYNCHRONOUS_POSITION
    at_rest: AtRest = AtRest.OFF


@dataclass(frozen=True, slots=True)
class CanOpenParams:
    """Table [canopen] of io_*.toml: fin drives (CiA 402)."""

    bus: str = param("", doc="Their bus, such as socketcan:can1; empty: that of [can], which they share.")
    node_id: int = param(
        1, low=0, high=127, doc="Node id of the autopilot, whose heartbeat the drives watch; 0: they watch none."
    )
    rate: Rate = Rate.HZ_50
    heartbeat: float = param(0.1, unit="s", low=0.01, high=5.0, doc="Period of each drive's heartbeat.")
    timeout: float = param(
        0.5,
        unit="s",
        low=0.05,
        high=10.0,
        doc="A drive without heartbeat and position for so long is lost, and configured anew.",
    )
    patience: float = param(
        0.5, unit="s", low=0.15, high=10.0, doc="A drive that misses the autopilot's heartbeat for so long stops."
    )
    latency: float = param(0.0, unit="s", low=0.0, high=1.0, doc="From the validity of a position to its arrival.")
    fins: tuple[FinDriveParams, ...] = ()

    def __post_init__(self) -> None:
        """Refuse one node for two drives, or for a drive and the autopilot, and times that contradict each other."""
        refuse_rate("canopen", self.rate)
        if self.timeout < _HEARTBEATS * self.heartbeat:
            raise ParamError(
                f"canopen.timeout_s = {self.timeout:g}: must be {_HEARTBEATS} times heartbeat_s = {self.heartbeat:g} "
                "or more; else sound drives are lost between two heartbeats"
            )
        taken = {self.node_id: "canopen.node_id"} if self.node_id else {}
        for one in self.fins:
            if one.node in taken:
                raise ParamError(f"canopen.fins: {one.name}: node = {one.node}: is {taken[one.node]} already")
            taken[one.node] = one.name

    @property
    def shares_bus(self) -> bool:
        """Return whether there are drives on the bus of [can]."""
        return bool(self.fins) and not self.bus


class FinDrive(FinPositions):
    """Tells a drive the angles of its fin, and understands its positions."""

    def __init__(self, params: FinDriveParams) -> None:
        self.params = params
        key = f"canopen.fins: {params.name}"
        travel, speed = params.travel, params.speed
        super().__init__(key, params.counts_per_turn, 0, params.zero, travel, speed, against=params.reversed)

    def refuse_less_than(self, delta_max: float) -> None:
        """Refuse a drive that is not to turn its fin to delta_max, rad.

        Raises:
            ParamError: it stops before, or has too many counts for 32 bits.
        """
        super().refuse_less_than(delta_max)
        if max(map(abs, self.ends)) >= 2**31:
            raise ParamError(f"{self.key}: counts_per_turn is too large for positions of 32 bits")


def drives_of(declared: Sequence[FinDriveParams], fins: Sequence[str]) -> tuple[FinDrive, ...]:
    """Return the drive of each fin, in the order of vehicle.toml; none if none is declared.

    Raises:
        ParamError: a fin without an entry, an entry without a fin, or twice.
    """
    return tuple(map(FinDrive, by_fin("canopen.fins", declared, fins)))
