"""Interfaces of the four objects that the cycle is given. Adapters implement them; the core knows no more of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick


class Hardware(Protocol):
    """Sensors and actuators."""

    def read(self, tick: Tick) -> SensorFrame:
        """Drain every bus and serial line once, with bounded work, and return what arrived as one frame."""

    def write(self, tick: Tick, applied: Applied) -> None:
        """Send the commands of this tick."""


class Ground(Protocol):
    """Ground stations."""

    def read(self, tick: Tick) -> Order:
        """Return what was commanded since the last tick."""

    def write(self, cycle: Cycle) -> None:
        """Send telemetry of the cycle, decimated, with bounded work."""


class Recorder(Protocol):
    """The log."""

    def write(self, cycle: Cycle) -> None:
        """Write one cycle to the log."""


class Schedule(Protocol):
    """Source of the ticks: a real-time clock, lockstep with a plant, or a replay."""

    def __iter__(self) -> Iterator[Tick]:
        """Yield each tick at its time, until the run ends."""
