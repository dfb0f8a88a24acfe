"""Fins on CANopen drives, as the io file describes them, and how an angle of the fin is told to a drive in counts."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import ParamError, param
from firmware_py.tick import Rate
from firmware_py.wire.canopen.cia402 import Mode

_TURN = 2.0 * math.pi


class AtRest(enum.Enum):
    """What a drive does while the vehicle is disarmed."""

    OFF = enum.auto()
    """Its motor has no power."""
    CENTRE = enum.auto()
    HOLD = enum.auto()
    """It stays at the last angle of before."""


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

    bus: str = param("", doc="Their bus, if it is not that of [can]: as there, such as socketcan:can1.")
    node_id: int = param(
        1, low=0, high=127, doc="Node id of the autopilot, whose heartbeat the drives watch; 0: they watch none."
    )
    rate: Rate = Rate.HZ_50
    heartbeat: float = param(0.1, unit="s", low=0.01, high=5.0, doc="Period of each drive's heartbeat.")
    timeout: float = param(
        0.5, unit="s", low=0.05, high=10.0, doc="A drive without a heartbeat for so long is lost, and configured anew."
    )
    patience: float = param(
        0.5, unit="s", low=0.15, high=10.0, doc="A drive that misses the autopilot's heartbeat for so long stops."
    )
    latency: float = param(0.0, unit="s", low=0.0, high=1.0, doc="From the validity of a position to its arrival.")
    fins: tuple[FinDriveParams, ...] = ()

    def __post_init__(self) -> None:
        """Refuse one node for two drives, or for a drive and the autopilot."""
        taken = {self.node_id: "canopen.node_id"} if self.node_id else {}
        for one in self.fins:
            if one.node in taken:
                raise ParamError(f"canopen.fins: {one.name}: node = {one.node}: is {taken[one.node]} already")
            taken[one.node] = one.name

    @property
    def shares_bus(self) -> bool:
        """Return whether there are drives on the bus of [can]."""
        return bool(self.fins) and not self.bus


class FinDrive:
    """Tells a drive the angles of its fin, and understands its positions."""

    def __init__(self, params: FinDriveParams) -> None:
        self.params = params
        self._counts = params.counts_per_turn / _TURN * (-1.0 if params.reversed else 1.0)
        self._zero = params.zero / _TURN * params.counts_per_turn

    def counts(self, angle: float) -> int:
        """Return the position of a fin angle, rad; one beyond the travel stops at its end."""
        travel = self.params.travel
        return round(self._zero + self._counts * clip(angle, -travel, travel))

    def angle(self, counts: int) -> float:
        """Return the fin angle of a position, rad."""
        return (counts - self._zero) / self._counts

    def refuse_less_than(self, delta_max: float) -> None:
        """Refuse a drive that is not to turn its fin to delta_max, rad.

        Raises:
            ParamError: it stops before, or has too many counts for 32 bits.
        """
        params = self.params
        if delta_max > params.travel + 1e-9:
            raise ParamError(
                f"canopen.fins: {params.name}: travel_deg = {math.degrees(params.travel):.4g}: must be at least the "
                f"fin's delta_max_deg = {math.degrees(delta_max):.4g}"
            )
        if max(abs(self.counts(side * params.travel)) for side in (-1.0, 1.0)) >= 2**31:
            raise ParamError(f"canopen.fins: {params.name}: counts_per_turn is too large for positions of 32 bits")


def drives_of(declared: Sequence[FinDriveParams], fins: Sequence[str]) -> tuple[FinDrive, ...]:
    """Return the drive of each fin, in the order of vehicle.toml; none if none is declared.

    Raises:
        ParamError: a fin without an entry, an entry without a fin, or twice.
    """
    by_name: dict[str, FinDriveParams] = {}
    for one in declared:
        if one.name not in fins:
            raise ParamError(f"canopen.fins: {one.name}: is no fin of vehicle.toml, which has {', '.join(fins)}")
        if one.name in by_name:
            raise ParamError(f"canopen.fins: {one.name}: stands there twice")
        by_name[one.name] = one
    missing = [name for name in fins if name not in by_name]
    if declared and missing:
        raise ParamError(f"canopen.fins: {missing[0]}: has no entry; where one fin has one, all must have one")
    return tuple([FinDrive(by_name[name]) for name in fins]) if declared else ()
