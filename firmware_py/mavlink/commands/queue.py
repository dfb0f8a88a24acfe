"""What stations wish and what becomes of it: one order a tick, and an answer that tells what the supervisor made of it.

A wish that is repeated while it waits is one wish. If it is repeated after its answer was lost, and was its sender's
last, it gets the same answer again and is not done again: a vehicle that has disarmed itself in between must not be
armed by an old command. Disarming is done each time that it is asked for.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import NamedTuple

from firmware_py.mavlink.base.codec import dialect
from firmware_py.records.cycle import Cycle
from firmware_py.records.event import EventKind
from firmware_py.records.order import KEEP_SETPOINT, NO_ORDER, Arming, Asker, Mode, Order, Setpoint, Sticks
from firmware_py.schedule import NS_PER_S

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
MAX_WAITING = 8
_MAX_SENDERS = 32
_ANSWER_STANDS_NS = 10 * NS_PER_S
_SAID = (EventKind.MODE_CHANGED, EventKind.MODE_REFUSED, EventKind.ARMING_REFUSED)
"""Events that say why a mode or arming was not granted."""


class PendingCommand(NamedTuple):
    """Who wishes, by which command, and what: a word on arming, a mode, a setpoint, an item of the mission."""

    link: int
    system: int
    component: int
    command: int
    arming: Arming
    mode: Mode | None
    setpoint: Setpoint = KEEP_SETPOINT
    jump: int = NO_ORDER.jump

    @property
    def sender(self) -> tuple[int, int, int]:
        """Who wishes."""
        return self.link, self.system, self.component

    @property
    def order(self) -> Order:
        """As the core is told."""
        asker = Asker(self.link, self.system, self.component, self.command)
        return Order(self.arming, self.mode, self.setpoint, jump=self.jump, asker=asker)


class CommandResult(NamedTuple):
    """What became of a wish: the MAV_RESULT, and why it was refused, unless an event has said so."""

    pending: PendingCommand
    result: int = ACCEPTED
    why: str = ""


class CommandQueue:
    """The wishes of all links in the order in which they came; disarming goes first, and ends what waits.

    `cycle` is the last one, None before the first.
    """

    def __init__(self) -> None:
        self._waiting: deque[PendingCommand] = deque()
        self._under_way: PendingCommand | None = None
        self._answers: list[CommandResult] = []
        self._last: dict[tuple[int, int, int], tuple[CommandResult, int]] = {}
        """Of each sender, and when it was told, ns."""
        self._guide: tuple[Setpoint, Asker] | None = None
        self._held = NO_ORDER
        self.cycle: Cycle | None = None
        self.end_allowed = False
        """Whether there is somebody who ends the flight, and starts the vehicle again, if a station asks for it."""
        self.end_request = ""
        """What a station has asked for and may: "reboot" or "shutdown"."""
        self.end_requester = ""
        """Which station that was, by system and component."""

    @property
    def mode(self) -> Mode:
        """The mode in force."""
        return Mode.DISARMED if self.cycle is None else self.cycle.mode.mode

    def set_sticks(self, sticks: Sticks, t: float) -> None:
        """The sticks from now on; their age is judged where they are used."""
        self._held = Order(sticks=sticks, t_sticks=t)

    def set_setpoint(self, setpoint: Setpoint, asker: Asker) -> None:
        """A setpoint that gets no answer; the last one before a tick holds."""
        self._guide = setpoint, asker

    def put(self, wish: PendingCommand, again: bool, t_ns: int) -> None:
        """Takes a wish; `again` if its sender says that it has sent it before."""
        if wish == self._under_way or wish in self._waiting:
            return
        last = self._last.get(wish.sender)
        if wish.arming is Arming.DISARM:
            ended = [waiting for waiting in self._waiting if waiting.arming is not Arming.DISARM]
            self._answers += [CommandResult(waiting, REJECTED, "disarming goes first") for waiting in ended]
            self._waiting = deque([waiting for waiting in self._waiting if waiting.arming is Arming.DISARM])
            self._queue(wish)
        elif again and last is not None and last[0].pending == wish and t_ns - last[1] <= _ANSWER_STANDS_NS:
            self._answers.append(last[0])
        else:
            self._queue(wish)

    def next_order(self) -> Order:
        """The order of this tick."""
        held, guide, self._guide = self._held, self._guide, None
        if not self._waiting or self._under_way is not None:
            return held if guide is None else replace(held, setpoint=guide[0], asker=guide[1])
        wish = self._waiting.popleft()
        if wish.mode is Mode.MANUAL and self.mode is Mode.DISARMED:
            self._answers.append(CommandResult(wish))  # so it stands in the heartbeat already
            return held
        self._under_way = wish
        return replace(wish.order, sticks=held.sticks, t_sticks=held.t_sticks)

    def results(self, cycle: Cycle) -> list[CommandResult]:
        """The answers that are due, now that the cycle that obeyed came out."""
        self.cycle = cycle
        wish = self._under_way
        if wish is not None:
            self._under_way = None
            self._answers.append(_answer(wish, cycle))
        if not self._answers:
            return []
        answers, self._answers = self._answers, []
        for answer in answers:
            self._last.pop(answer.pending.sender, None)
            self._last[answer.pending.sender] = answer, cycle.tick.t_ns
        while len(self._last) > _MAX_SENDERS:
            del self._last[next(iter(self._last))]
        return answers

    def _queue(self, wish: PendingCommand) -> None:
        if len(self._waiting) < MAX_WAITING:
            self._waiting.append(wish)
        else:
            self._answers.append(CommandResult(wish, REJECTED, f"{MAX_WAITING} orders wait already; try once more"))


def _answer(wish: PendingCommand, cycle: Cycle) -> CommandResult:
    mode = cycle.mode.mode
    if wish.arming is Arming.CHECK:
        why = "" if mode is Mode.DISARMED else "the vehicle is armed: there is nothing to check"
        return CommandResult(wish, REJECTED if why else ACCEPTED, why)
    if wish.mode is None and wish.arming is Arming.KEEP:
        why = "" if wish.setpoint is KEEP_SETPOINT else setpoint_refusal(mode, wish.setpoint)
        return CommandResult(wish, REJECTED if why else ACCEPTED, why)
    disarmed = mode is Mode.DISARMED
    granted = mode is wish.mode if wish.mode is not None else disarmed == (wish.arming is Arming.DISARM)
    if granted or any(event.kind in _SAID for event in cycle.events):
        return CommandResult(wish, ACCEPTED if granted else REJECTED)
    return CommandResult(wish, REJECTED, f"another order was obeyed, and the mode is {mode.name}")


def setpoint_refusal(mode: Mode, setpoint: Setpoint) -> str:
    """Why a mode does not go by a setpoint, in words for people that name modes as `Mode` does; empty if it does."""
    if mode is Mode.GUIDED:
        return ""
    if mode is Mode.HOLD:
        return "" if math.isnan(setpoint.x) else "HOLD goes to no place; set GUIDED"
    if mode is Mode.LOITER:
        free = math.isnan(setpoint.x) and math.isnan(setpoint.psi_d)
        return "" if free else "LOITER takes depth and speed only; set GUIDED"
    if mode is Mode.MISSION:
        alone = math.isnan(setpoint.z_d) and math.isnan(setpoint.psi_d) and math.isnan(setpoint.x)
        return "" if alone else "MISSION takes a speed only; set HOLD or GUIDED"
    arm = "disarmed; arm first, then" if mode is Mode.DISARMED else f"{mode.name} takes no setpoint;"
    return f"{arm} set HOLD, LOITER or GUIDED"
