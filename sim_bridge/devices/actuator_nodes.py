"""The actuator nodes: the servo hub of the fins, the speed controller of the propeller, what holds the drop weight."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.wire.dronecan.equipment_messages import (
    ActuatorStatus,
    ArmingStatus,
    ArrayCommand,
    EscStatus,
    HardpointCommand,
    HardpointStatus,
    RawCommand,
    RpmCommand,
)
from firmware_py.wire.dronecan.fin_servo import FinServo
from firmware_py.wire.dronecan.message_table import ACTUATOR_STATUS, ESC_STATUS, HARDPOINT_STATUS
from firmware_py.wire.dronecan.propeller_drive import PropellerDrive
from sim_bridge.devices.node import NodeFunction

UNKNOWN_POWER = 127
DROP_WEIGHT = 0
"""Hardpoint id of the drop weight."""
RELEASE, HOLD = 0, 1
"""Commands and states of a hardpoint."""
ARMED = 255
"""Of ArmingStatus."""


class TimeoutAction(enum.Enum):
    """What fins do when commands stop."""

    HOLD = enum.auto()
    """They keep the last command."""
    CENTRE = enum.auto()
    LIMP = enum.auto()
    """The servos are switched off; friction holds the fins where they are."""


@dataclass(frozen=True, slots=True)
class ServoHubParams:
    """A hub that drives every fin."""

    silent: TimeoutAction
    travel: float = param(unit="deg", low=1, high=90, doc="Where commands saturate; full scale of a unitless one.")
    silence: float = param(unit="s", low=0.02, high=3600, doc="Without a command for longer, `silent` applies.")
    status: int = param(unit="Hz", low=1, high=200, doc="Feedback of each fin; above the base rate: every tick.")


@dataclass(frozen=True, slots=True)
class EscParams:
    """The propeller's speed controller."""

    n_max: float = param(unit="rpm", low=1, high=1e5, doc="Where commands saturate, ahead and astern.")
    silence: float = param(unit="s", low=0.02, high=3600, doc="Without a command for longer, the propeller stops.")
    status: int = param(unit="Hz", low=1, high=200, doc="Feedback; above the base rate: every tick.")


@dataclass(frozen=True, slots=True)
class HardpointParams:
    """What holds the drop weight."""

    status: int = param(5, unit="Hz", low=1, high=200, doc="Reports; above the base rate: every tick.")
    release_on_silence: float = param(
        0.0,
        unit="s",
        low=0,
        high=3600,
        doc="Without a command for longer, it lets go, if it was last told that the vehicle is armed; 0: never.",
    )


class FinServos:
    """The servos of all fins, on a hub or each with its node: they receive ArrayCommand, and send a Status each.

    Each fin has its own timeout: a command that omits a fin, or has NaN for it, does not count for it.

    Args:
        params: what they do.
        nodes: the node of each fin's servo.
        servos: which actuator each is, and what it obeys.
    """

    def __init__(self, params: ServoHubParams, nodes: Sequence[NodeFunction], servos: Sequence[FinServo]) -> None:
        fins = len(servos)
        self._nodes, self._servos, self._params = nodes, servos, params
        self._by_id = {servo.params.id: fin for fin, servo in enumerate(servos)}
        self._commanded = [0.0] * fins
        self._t_command = [-math.inf] * fins
        self._last: tuple[float, ...] = ()
        self.silent_fins: set[int] = set()
        """Faults: fins without a Status."""
        self.by_servo: set[int] = set()
        """Faults: fins whose Status has the angle of the servo, not of the fin."""

    def accept_command(self, command: ArrayCommand, t: float) -> None:
        """Take what a command says to known servos in what they obey; saturate at the travel of the fins."""
        travel = self._params.travel
        for one in command.commands:
            fin = self._by_id.get(one.actuator_id)
            angle = self._servos[fin].obeyed(one) if fin is not None else math.nan
            if fin is not None and angle == angle:
                self._commanded[fin] = clip(angle, -travel, travel)
                self._t_command[fin] = t

    def commands(self, t: float, fins: Sequence[float]) -> Sequence[float]:
        """Return the commands that act at `t`, rad; `fins` are the true angles, where they stay without power."""
        return [
            self._command(i, t, angle) if node.powered else angle
            for i, (angle, node) in enumerate(zip(fins, self._nodes, strict=True))
        ]

    def _command(self, i: int, t: float, angle: float) -> float:
        """Return the command that acts on one fin with power, rad; `angle` is the true one."""
        action = self._params.silent
        if t - self._t_command[i] <= self._params.silence or action is TimeoutAction.HOLD:
            return self._commanded[i]
        return angle if action is TimeoutAction.LIMP else 0.0

    def publish_status(self, fins: Sequence[float], servos: Sequence[float] = ()) -> None:
        """Send the Status of every fin: angle, and speed since the last one; see `by_servo` for `servos`."""
        fins = [servos[i] if i in self.by_servo else angle for i, angle in enumerate(fins)] if self.by_servo else fins
        rate, last = self._params.status, self._last or fins
        for i, (angle, servo, node) in enumerate(zip(fins, self._servos, self._nodes, strict=True)):
            if i not in self.silent_fins:
                position = servo.position(angle)
                speed = (position - servo.position(last[i])) * rate
                node.publish(ACTUATOR_STATUS, ActuatorStatus(servo.status_id, position, math.nan, speed, UNKNOWN_POWER))
        self._last = tuple(fins)


class Esc:
    """Receives RPMCommand or RawCommand, sends Status."""

    def __init__(self, params: EscParams, node: NodeFunction, drive: PropellerDrive) -> None:
        self.node = node
        self._drive = drive
        self._params = params
        self._commanded = 0.0
        self._t_command = -math.inf

    def accept_command(self, command: RpmCommand | RawCommand, t: float) -> None:
        """Take its speed; ignore a command without one, or of the kind that it does not obey."""
        n = self._drive.obeyed(command)
        if n is not None:
            limit = self._params.n_max
            self._commanded = clip(n, -limit, limit)
            self._t_command = t

    def command(self, t: float) -> float:
        """Return the command that acts at `t`, rev/s; none without power."""
        heard = t - self._t_command <= self._params.silence
        return self._commanded if heard and self.node.powered else 0.0

    def publish_status(self, n: float) -> None:
        """Send Status: rpm, and the share of full speed."""
        load = min(100, round(100.0 * abs(n) / self._params.n_max))
        index, rpm = self._drive.report(n)
        self.node.publish(ESC_STATUS, EscStatus(0, math.nan, math.nan, math.nan, rpm, load, index))


class Hardpoint:
    """Holds the drop weight. Receives Command and ArmingStatus, sends Status; what is released stays so.

    One that lets go on silence needs to have heard a command, and that the vehicle is armed: neither on deck with the
    autopilot off nor before a flight anything falls.
    """

    def __init__(self, params: HardpointParams, node: NodeFunction) -> None:
        self.node = node
        self.released = False
        self._silence = params.release_on_silence or math.inf
        self._t_command = math.inf
        self._armed = False

    def accept_command(self, command: HardpointCommand, t: float) -> None:
        """Open when told so, with power."""
        if command.hardpoint_id != DROP_WEIGHT or not self.node.powered:
            return
        self._t_command = t
        if command.command == RELEASE:
            self.released = True

    def accept_arming(self, status: ArmingStatus) -> None:
        """Take what the vehicle says of its arming."""
        self._armed = status.status == ARMED

    def watch(self, t: float) -> None:
        """Let go if no command came for too long."""
        if self._armed and t - self._t_command > self._silence and self.node.powered:
            self.released = True

    def publish_status(self, weight: float) -> None:
        """Send Status; `weight` is what hangs on it, N."""
        state = HOLD if weight > 0.0 else RELEASE
        self.node.publish(HARDPOINT_STATUS, HardpointStatus(DROP_WEIGHT, weight, 0.0, state))
