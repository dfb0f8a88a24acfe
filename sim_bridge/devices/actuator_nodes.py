"""The devices that obey: the servo hub of the fins and the propeller's speed controller."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.wire.dronecan.equipment import ActuatorStatus, ArrayCommand, EscStatus, RpmCommand
from firmware_py.wire.dronecan.messages import ACTUATOR_STATUS, ESC_STATUS
from sim_bridge.devices.node import Node

UNITLESS, POSITION = 0, 1
"""Command types of equipment.actuator.Command that the hub obeys."""
UNKNOWN_POWER = 127


class Silence(enum.Enum):
    """What fins do when nobody commands them any more."""

    HOLD = enum.auto()
    """They go to the last command and stay there."""
    CENTRE = enum.auto()
    LIMP = enum.auto()
    """The servos let go; friction keeps the fins where they are."""


@dataclass(frozen=True, slots=True)
class ServoHubParams:
    """A hub that drives every fin."""

    silent: Silence
    travel: float = param(unit="deg", low=1, high=90, doc="Where commands saturate; full scale of a unitless one.")
    silence: float = param(unit="s", low=0.02, high=3600, doc="Without a command for longer, `silent` applies.")
    status: int = param(unit="Hz", low=1, high=200, doc="Feedback of each fin; above the base rate: every tick.")


@dataclass(frozen=True, slots=True)
class EscParams:
    """The propeller's speed controller."""

    n_max: float = param(unit="rpm", low=1, high=1e5, doc="Where commands saturate, ahead and astern.")
    silence: float = param(unit="s", low=0.02, high=3600, doc="Without a command for longer, the propeller stops.")
    status: int = param(unit="Hz", low=1, high=200, doc="Feedback; above the base rate: every tick.")


class ServoHub:
    """ArrayCommand in, one Status per fin out; actuator ids count the fins of the boat from 0.

    Each fin is on its own: a command that leaves one out, or says NaN for it, leaves it to its silence.
    """

    def __init__(self, params: ServoHubParams, node: Node, fins: int) -> None:
        self.node = node
        self._params = params
        self._wanted = [0.0] * fins
        self._heard = [-math.inf] * fins
        self._last: tuple[float, ...] = ()

    def obey(self, command: ArrayCommand, t: float) -> None:
        """Takes what it can use of a command: known fins, radians or unitless; saturates the rest."""
        travel, wanted = self._params.travel, self._wanted
        for fin, kind, value in command.commands:
            if fin < len(wanted) and value == value and kind in (POSITION, UNITLESS):
                wanted[fin] = clip(value if kind == POSITION else value * travel, -travel, travel)
                self._heard[fin] = t

    def commands(self, t: float, fins: Sequence[float]) -> Sequence[float]:
        """What the servos are told at `t`, rad; `fins` are the true angles."""
        patience, heard = self._params.silence, self._heard
        if t - min(heard) <= patience:
            return self._wanted
        silent = self._params.silent
        if silent is Silence.HOLD:
            return self._wanted
        idle = fins if silent is Silence.LIMP else [0.0] * len(fins)
        return [w if t - h <= patience else i for w, h, i in zip(self._wanted, heard, idle, strict=True)]

    def report(self, fins: Sequence[float]) -> None:
        """Status of every fin: angle, and speed since the last report."""
        rate, last, publish = self._params.status, self._last or fins, self.node.publish
        for i, angle in enumerate(fins):
            publish(ACTUATOR_STATUS, ActuatorStatus(i, angle, math.nan, (angle - last[i]) * rate, UNKNOWN_POWER))
        self._last = tuple(fins)


class Esc:
    """RPMCommand in (the first of its propellers), Status out."""

    def __init__(self, params: EscParams, node: Node) -> None:
        self.node = node
        self._params = params
        self._wanted = 0.0
        self._heard = -math.inf

    def obey(self, command: RpmCommand, t: float) -> None:
        """Takes the first speed; a command to no propeller is none."""
        if command.rpm:
            limit = self._params.n_max
            self._wanted = clip(command.rpm[0] / 60.0, -limit, limit)
            self._heard = t

    def command(self, t: float) -> float:
        """What the shaft is told at `t`, rev/s."""
        return self._wanted if t - self._heard <= self._params.silence else 0.0

    def report(self, n: float) -> None:
        """Status: rpm, and the share of full speed."""
        load = min(100, round(100.0 * abs(n) / self._params.n_max))
        self.node.publish(ESC_STATUS, EscStatus(0, math.nan, math.nan, math.nan, round(n * 60.0), load, 0))
