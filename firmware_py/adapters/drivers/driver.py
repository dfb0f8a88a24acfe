"""What a driver is: it reads and moves the devices on one bus or one line, and knows nothing of what they are for.

A driver is asked once a tick what has come, and told once a tick what is to be done. It never waits, and raises nothing
once it is made: a device that is not there is silence, and is heard again when it is back. What was lost is counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py.records.command import Applied
from firmware_py.records.cycle import Cycle
from firmware_py.records.sensing import Heard, NodeBits
from firmware_py.tick import Tick

PAYLOAD = "payload"
"""The role of a reading whose value is a `PayloadReading`; several may come in a tick."""


class Reading(NamedTuple):
    """One measurement that has come.

    Attributes:
        role: the field of `SensorFrame` that it belongs to.
        number: which of the fins, or which of the devices of that role in the order of priority, from 0.
        heard: the measurement.
    """

    role: str
    number: int
    heard: Heard[Any]


SOUND = NodeBits()


class Driver:
    """A driver of devices that are only read, and have no nodes; others do more.

    Attributes:
        received: how many messages have come that are read.
    """

    received = 0

    def poll(self, t: float) -> Sequence[Reading]:
        """Return what has come up to `t`, s, in its order; with bounded work."""
        raise NotImplementedError

    def nodes(self, _t: float) -> NodeBits:
        """Return what is wrong with nodes at `t`, s."""
        return SOUND

    def act(self, _tick: Tick, _applied: Applied) -> None:
        """Send the commands of a tick, and what devices must be told or asked."""

    def ask(self, _tick: Tick) -> None:
        """Ask devices that speak only when asked, and change nothing: in place of `act`, where a bench tool listens."""

    def exercise(self, _on: bool) -> None:
        """Have fins follow what they are told although the vehicle is disarmed, for a bench tool; or no longer."""

    def note(self, _cycle: Cycle) -> None:
        """Take from a cycle, once a second, what other nodes are to know of it."""

    def park(self) -> None:
        """Centre the fins, stop the propeller and tell that the vehicle is disarmed, at once, as the last of a run."""

    def losses(self) -> Mapping[str, int]:
        """Return how much of what came could not be used, by cause."""
        return {}

    def close(self) -> None:
        """Leave the bus or the line; may be called twice."""
