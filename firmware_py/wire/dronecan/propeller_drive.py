"""The propeller's speed controller as its io file describes it: how a speed is told to it.

Most controllers know RawCommand alone, a share of full speed or of full thrust; some RPMCommand.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.wire.dronecan.equipment_messages import RawCommand, RpmCommand
from firmware_py.wire.dronecan.message_table import RAW_COMMAND, RPM_COMMAND, MessageType

FULL = 8191
"""Full speed ahead in a RawCommand."""


class SpeedCommand(enum.Enum):
    """How a speed is told."""

    RPM = enum.auto()
    RAW = enum.auto()


@dataclass(frozen=True, slots=True)
class PropellerParams:
    """Table [propeller] of io_*.toml."""

    command: SpeedCommand = SpeedCommand.RPM
    index: int = param(0, low=0, high=19, doc="Place of the propeller in commands, and in its reports.")
    reversed: bool = param(False, doc="Whether it turns astern at a positive speed.")
    full_speed: float = param(1000.0, unit="rpm", low=10.0, high=1e5, doc="Speed at a RawCommand of 8191; measure it.")


class PropellerDrive:
    """Tells the speed of one propeller, and understands its reports; others on the bus are told to stand still."""

    def __init__(self, params: PropellerParams) -> None:
        self._params = params
        self._sign = -1.0 if params.reversed else 1.0
        self._others = (0,) * params.index
        self.kind: MessageType[Any] = RPM_COMMAND if params.command is SpeedCommand.RPM else RAW_COMMAND

    def command(self, n: float) -> RpmCommand | RawCommand:
        """Return the command for a speed, rev/s."""
        n *= self._sign
        if self._params.command is SpeedCommand.RPM:
            return RpmCommand((*self._others, round(n * 60.0)))
        return RawCommand((*self._others, round(FULL * clip(n / self._params.full_speed, -1.0, 1.0))))

    def speed(self, index: int, rpm: int) -> float | None:
        """Return the reported speed, rev/s; None if it is of another propeller."""
        return self._sign * rpm / 60.0 if index == self._params.index else None

    def report(self, n: float) -> tuple[int, int]:
        """Return index and speed, rpm, of a report at n, rev/s; for simulated controllers."""
        return self._params.index, round(self._sign * n * 60.0)

    def obeyed(self, command: RpmCommand | RawCommand) -> float | None:
        """Return the speed that a command asks for, rev/s; None if it asks this propeller for none.

        It is for simulated controllers: a real one obeys one kind alone too.
        """
        values = command.rpm if isinstance(command, RpmCommand) else command.cmd
        if isinstance(command, RpmCommand) != (self._params.command is SpeedCommand.RPM):
            return None
        if len(values) <= self._params.index:
            return None
        value = self._sign * values[self._params.index]
        return value / 60.0 if isinstance(command, RpmCommand) else value / FULL * self._params.full_speed
