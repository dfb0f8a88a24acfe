"""Commands of all stations in one queue: one order a tick, and for each command the result of the cycle that obeyed it.

A command that is repeated while it waits counts once. If it is repeated because its result was lost, and was its
sender's last, it gets the same result again and is not executed again: a vehicle that has disarmed itself in between
must not be armed by an old command. A command to disarm is executed each time. It cancels those that wait, but for the
end of the flight and the release of the drop weight, which bring up a vehicle that is disarmed too.

A command to release the drop weight is in progress until its hardpoint says that it is done, or that it is not.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from firmware_py.mavlink.base.codec import dialect
from firmware_py.mavlink.base.refusal import ModeReason, ModeRefusal, Refusal
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.health import WeightState
from firmware_py.records.order import KEEP_SETPOINT, NO_ORDER, Arming, Asker, Mode, Order, Setpoint, Sticks
from firmware_py.tick import NS_PER_S

ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
REJECTED: int = dialect.MAV_RESULT_TEMPORARILY_REJECTED
FAILED: int = dialect.MAV_RESULT_FAILED
IN_PROGRESS: int = dialect.MAV_RESULT_IN_PROGRESS
MAX_WAITING = 8
_MAX_SENDERS = 32
_RESULT_VALID_NS = 10 * NS_PER_S
"""A repeated command gets its old result for so long."""
_DISARM = (Arming.DISARM, Arming.FORCE_DISARM)
_REFUSALS = (EventKind.MODE_CHANGED, EventKind.MODE_REFUSED, EventKind.ARMING_REFUSED)
"""Events that tell stations why a mode or arming was not granted."""


class PendingCommand(NamedTuple):
    """A command that waits for its tick: sender, command number, and what it asks for.

    `chooses` says that a disarmed vehicle takes the mode as the one that arming leads to; `terminate` asks for the end
    of the flight, `release` for the drop weight. `params` are frame and parameters as they came: what is relative to
    the vehicle is another setpoint when it is repeated.
    """

    link: int
    system: int
    component: int
    command: int
    arming: Arming
    mode: Mode | None
    setpoint: Setpoint = KEEP_SETPOINT
    jump: int = NO_ORDER.jump
    chooses: bool = False
    terminate: bool = False
    release: bool = False
    params: bytes = b""

    def repeats(self, other: PendingCommand | None) -> bool:
        """Return whether its sender asked for the same with the other one."""
        return other is not None and self._replace(setpoint=other.setpoint) == other

    @property
    def sender(self) -> tuple[int, int, int]:
        """The station that sent it: link, system and component."""
        return self.link, self.system, self.component

    @property
    def stands(self) -> bool:
        """Whether a command to disarm that comes behind it does not cancel it."""
        return self.arming in _DISARM or self.terminate or self.release

    @property
    def order(self) -> Order:
        """The order that executes it."""
        asker = Asker(self.link, self.system, self.component, self.command)
        order = Order(self.arming, self.mode, self.setpoint, jump=self.jump, asker=asker)
        return replace(order, terminate=self.terminate, release=self.release, chooses=self.chooses)


class CommandResult(NamedTuple):
    """The result of a command: the MAV_RESULT, and why it was refused, unless an event says so."""

    pending: PendingCommand
    result: int = ACCEPTED
    why: Refusal = ""


class PendingSetpoint(NamedTuple):
    """A setpoint that waits for its tick and gets no result; `refuse` tells its sender why it is not followed."""

    setpoint: Setpoint
    asker: Asker
    refuse: Callable[[Refusal], None]


class CommandQueue:
    """The commands of all links, in the order received; a command to disarm cancels most of those that wait.

    `cycle` is the last one, None before the first.
    """

    def __init__(self) -> None:
        self._waiting: deque[PendingCommand] = deque()
        self._executing: PendingCommand | None = None
        self._releasing: list[PendingCommand] = []
        """Commands to release the drop weight that are in progress."""
        self._results: list[CommandResult] = []
        self._last: dict[tuple[int, int, int], tuple[CommandResult, int]] = {}
        """The last result of each sender, and when it was sent, ns."""
        self._setpoint: PendingSetpoint | None = None
        self._before = 0
        """Commands that wait and came before the setpoint."""
        self._standing = NO_ORDER
        """What holds without a command: sticks, and when a station was heard."""
        self.cycle: Cycle | None = None
        self.end_allowed = False
        """Whether stations may end the program: true where a service manager restarts it."""
        self.end_request = ""
        """What a station has asked for: "reboot" or "shutdown"; empty until then."""
        self.end_requester = ""
        """The station that asked, by system and component."""

    @property
    def mode(self) -> Mode:
        """The mode in force."""
        return Mode.DISARMED if self.cycle is None else self.cycle.mode.mode

    @property
    def chosen(self) -> Mode:
        """The mode that arming leads to, with the commands that wait; MANUAL before the first cycle."""
        known = (self._executing, *self._waiting)
        asked = [command.mode for command in known if command is not None and command.chooses and command.mode]
        return asked[-1] if asked else Mode.MANUAL if self.cycle is None else self.cycle.mode.chosen

    def set_sticks(self, sticks: Sticks, t: float) -> None:
        """Set the sticks, received at `t`, s; control judges their age."""
        self._standing = replace(self._standing, sticks=sticks, t_sticks=t)

    def hear_station(self, t: float) -> None:
        """Note that a ground station was heard at `t`, s."""
        self._standing = replace(self._standing, t_station=t)

    def set_setpoint(self, setpoint: PendingSetpoint) -> None:
        """Set a setpoint that gets no result; the last one before its tick holds."""
        self._setpoint, self._before = setpoint, len(self._waiting)

    def put(self, command: PendingCommand, again: bool, t_ns: int) -> None:
        """Put a command into the queue; `again` if its sender marks it as a retransmission."""
        if any(command.repeats(known) for known in (self._executing, *self._waiting)):
            return
        if command in self._releasing:
            self._results.append(CommandResult(command, IN_PROGRESS))
            return
        last = self._last.get(command.sender)
        if command.arming in _DISARM:
            cancelled = [waiting for waiting in self._waiting if not waiting.stands]
            self._results += [CommandResult(waiting, REJECTED, "disarming goes first") for waiting in cancelled]
            self._waiting = deque([waiting for waiting in self._waiting if waiting.stands])
            self._append(command)
            self._before = len(self._waiting)
        elif again and last is not None and command.repeats(last[0].pending) and t_ns - last[1] <= _RESULT_VALID_NS:
            self._results.append(last[0])
        else:
            self._append(command)

    def next_order(self) -> Order:
        """Return the order of this tick: the next command, or a setpoint whose turn it is."""
        standing, setpoint = self._standing, self._setpoint
        if setpoint is not None and not self._before:
            self._setpoint = None
            if (why := setpoint_refusal(self.mode, setpoint.setpoint)) is None:
                return replace(standing, setpoint=setpoint.setpoint, asker=setpoint.asker)
            setpoint.refuse(why)
        if not self._waiting or self._executing is not None:
            return standing
        self._before = max(self._before - 1, 0)
        command = self._waiting.popleft()
        self._executing = command
        order = command.order
        return replace(order, sticks=standing.sticks, t_sticks=standing.t_sticks, t_station=standing.t_station)

    def results(self, cycle: Cycle) -> list[CommandResult]:
        """Return the results that are due, given the cycle that executed the last order."""
        self.cycle = cycle
        command = self._executing
        if command is not None:
            self._executing = None
            result = _result(command, cycle)
            self._results.append(result)
            if result.result == IN_PROGRESS:
                self._releasing.append(command)
        elif self._releasing and (done := _release_result(cycle)) != IN_PROGRESS:
            self._results += [CommandResult(released, done) for released in self._releasing]
            self._releasing = []
        if not self._results:
            return []
        results, self._results = self._results, []
        for result in results:
            self._last.pop(result.pending.sender, None)
            self._last[result.pending.sender] = result, cycle.tick.t_ns
        while len(self._last) > _MAX_SENDERS:
            del self._last[next(iter(self._last))]
        return results

    def _append(self, command: PendingCommand) -> None:
        if len(self._waiting) < MAX_WAITING:
            self._waiting.append(command)
        else:
            self._results.append(
                CommandResult(command, REJECTED, f"{MAX_WAITING} commands are waiting already; try once more")
            )


def setpoint_refusal(mode: Mode, setpoint: Setpoint) -> ModeRefusal | None:
    """Return why a mode does not take a setpoint; None if it does."""
    positioned = not math.isnan(setpoint.x)
    if mode is Mode.GUIDED:
        return None
    if mode is Mode.HOLD:
        return ModeRefusal(ModeReason.NO_POSITION, mode, (Mode.GUIDED,)) if positioned else None
    if mode is Mode.LOITER:
        taken = not positioned and math.isnan(setpoint.psi_d)
        return None if taken else ModeRefusal(ModeReason.DEPTH_AND_SPEED_ONLY, mode, (Mode.GUIDED,))
    if mode is Mode.MISSION:
        taken = not positioned and math.isnan(setpoint.z_d) and math.isnan(setpoint.psi_d)
        return None if taken else ModeRefusal(ModeReason.SPEED_ONLY, mode, (Mode.HOLD, Mode.GUIDED))
    reason = ModeReason.DISARMED if mode is Mode.DISARMED else ModeReason.NO_SETPOINT
    return ModeRefusal(reason, mode, (Mode.HOLD, Mode.LOITER, Mode.GUIDED))


def _release_result(cycle: Cycle) -> int:
    """Return what has become of a release of the drop weight; an event says why it failed."""
    weight = cycle.actuators.drop_weight
    if not cycle.mode.drop:
        return REJECTED
    if weight in (WeightState.UNREPORTED, WeightState.RELEASED, WeightState.GONE):
        return ACCEPTED
    return FAILED if weight in (WeightState.STUCK, WeightState.NOT_CONFIRMED) else IN_PROGRESS


def _result(command: PendingCommand, cycle: Cycle) -> CommandResult:
    mode = cycle.mode.mode
    if command.arming is Arming.CHECK:
        why = "" if mode is Mode.DISARMED else "the vehicle is armed: there is nothing to check"
        return CommandResult(command, REJECTED if why else ACCEPTED, why)
    if command.release:
        result = _release_result(cycle)
        return CommandResult(command, result, "nothing was released" if result == REJECTED else "")
    if command.mode is None and command.arming is Arming.KEEP and not command.terminate:
        refusal = None if command.setpoint is KEEP_SETPOINT else setpoint_refusal(mode, command.setpoint)
        return CommandResult(command) if refusal is None else CommandResult(command, REJECTED, refusal)
    disarmed = mode is Mode.DISARMED
    if command.terminate:
        granted = cycle.mode.drop or mode is Mode.SURFACE  # without a drop weight it comes up all the same
    elif command.mode is not None:
        granted = (cycle.mode.chosen if disarmed and command.chooses else mode) is command.mode
    else:
        granted = disarmed == (command.arming in _DISARM)
    if any(event.kind is EventKind.MODE_REFUSED and event.after is Mode.DISARMED for event in cycle.events):
        granted = False  # also where it is disarmed already, and is to come up by itself
    if granted or any(event.kind in _REFUSALS for event in cycle.events):
        return CommandResult(command, ACCEPTED if granted else REJECTED)
    return CommandResult(command, REJECTED, ModeRefusal(ModeReason.OTHER_ORDER, mode))
