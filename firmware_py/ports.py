"""The four things the loop is handed, as it sees them. Adapters fulfil these; the core knows nothing more of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.order import Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.schedule import Tick


class Hardware(Protocol):
    """The boat: sensors and actuators."""

    def read(self, tick: Tick) -> SensorFrame:
        """Drains every bus and line once, bounded, into one frame."""

    def write(self, tick: Tick, applied: Applied) -> None:
        """Sends the commands of this tick."""


class Ground(Protocol):
    """Whoever gives orders."""

    def read(self, tick: Tick) -> Order:
        """What was asked since the last tick."""

    def write(self, cycle: Cycle) -> None:
        """Reports the cycle, decimated, with bounded work."""


class Recorder(Protocol):
    """Whoever keeps the log."""

    def write(self, cycle: Cycle) -> None:
        """Keeps one cycle."""


class Schedule(Protocol):
    """Whoever says when: real time, lockstep with a plant, a replay."""

    def __iter__(self) -> Iterator[Tick]:
        """Ticks, each at its time, until the run ends."""
