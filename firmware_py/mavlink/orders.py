"""What stations wish and what becomes of it: one order a tick, and an answer that tells what the supervisor made of it.

A wish that is repeated while it waits is one wish. If it is repeated after its answer was lost, and was its sender's
last, it gets the same answer again and is not done again: a vehicle that has disarmed itself in between must not be
armed by an old command. Disarming is done each time that it is asked for.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from firmware_py.mavlink.codec import dialect
from firmware_py.records.order import NO_ORDER, Arming, Mode, Order, Sticks
from firmware_py.schedule import NS_PER_S

ACCEPTED, REJECTED = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
MOST_WAITING = 8
_MOST_SENDERS = 32
_ANSWER_STANDS_NS = 10 * NS_PER_S


class Wish(NamedTuple):
    """Who wishes (link, system, component), by which command, and what: a word on arming, or a mode."""

    link: int
    system: int
    component: int
    command: int
    arming: Arming
    mode: Mode | None

    @property
    def sender(self) -> tuple[int, int, int]:
        """Who wishes."""
        return self.link, self.system, self.component


class Answer(NamedTuple):
    """What became of a sender's last wish, and when it was told."""

    wish: Wish
    result: int
    t_ns: int


class Orders:
    """The wishes of all links in the order in which they came; disarming goes first, and ends what waits."""

    def __init__(self) -> None:
        self._waiting: deque[Wish] = deque()
        self._under_way: Wish | None = None
        self._answers: list[tuple[Wish, int]] = []
        self._last: dict[tuple[int, int, int], Answer] = {}
        self._mode = Mode.DISARMED
        self._held = NO_ORDER

    def steer(self, sticks: Sticks, t: float) -> None:
        """The sticks from now on; their age is judged where they are used."""
        self._held = Order(sticks=sticks, t_sticks=t)

    def ask(self, wish: Wish, again: bool, t_ns: int) -> None:
        """Takes a wish; `again` if its sender says that it has sent it before."""
        if wish == self._under_way or wish in self._waiting:
            return
        last = self._last.get(wish.sender)
        if wish.arming is Arming.DISARM:
            self._answers += [(waiting, REJECTED) for waiting in self._waiting if waiting.arming is not Arming.DISARM]
            self._waiting = deque([waiting for waiting in self._waiting if waiting.arming is Arming.DISARM])
            self._queue(wish)
        elif again and last is not None and last.wish == wish and t_ns - last.t_ns <= _ANSWER_STANDS_NS:
            self._answers.append((wish, last.result))
        else:
            self._queue(wish)

    def next(self) -> Order:
        """The order of this tick."""
        if not self._waiting or self._under_way is not None:
            return self._held
        wish = self._waiting.popleft()
        if wish.mode is Mode.MANUAL and self._mode is Mode.DISARMED:
            self._answers.append((wish, ACCEPTED))  # so it stands in the heartbeat already
            return self._held
        self._under_way = wish
        return Order(wish.arming, wish.mode, sticks=self._held.sticks, t_sticks=self._held.t_sticks)

    def judge(self, mode: Mode, t_ns: int) -> list[tuple[Wish, int]]:
        """The answers that are due, now that the cycle that obeyed came out in `mode`."""
        self._mode = mode
        wish = self._under_way
        if wish is not None:
            self._under_way = None
            self._answers.append((wish, ACCEPTED if _granted(wish, mode) else REJECTED))
        if not self._answers:
            return []
        answers, self._answers = self._answers, []
        for wish, result in answers:
            self._last.pop(wish.sender, None)
            self._last[wish.sender] = Answer(wish, result, t_ns)
        while len(self._last) > _MOST_SENDERS:
            del self._last[next(iter(self._last))]
        return answers

    def _queue(self, wish: Wish) -> None:
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append(wish)
        else:
            self._answers.append((wish, REJECTED))


def _granted(wish: Wish, mode: Mode) -> bool:
    if wish.mode is not None:
        return mode is wish.mode
    return (mode is Mode.DISARMED) == (wish.arming is Arming.DISARM)
