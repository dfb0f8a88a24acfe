"""One question on a half-duplex line, and the answers that are due: until they are in, or late, nobody else speaks."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from firmware_py.adapters.drivers.dynamixel.servo_link import ServoLink
from firmware_py.wire.serial.dynamixel import Status

_LATE_S = 0.2
"""So late an answer may come at most: what is asked of one servo alone has many answers of equal length."""


class Exchange:
    """A question to one servo, or to several at once, which answer in its order.

    Args:
        asked: in the order of the question.
        length: of each answer, bytes; one of another length is late, and belongs to a question of before.
        take: is given each servo with its answer, and the first one without, which is not in time.
        t: when it was asked, s.
        patience: so long the answers may take, s.
    """

    def __init__(
        self,
        asked: Sequence[ServoLink],
        length: int,
        take: Callable[[ServoLink, Status | None], None],
        t: float,
        patience: float,
    ) -> None:
        self.links, self._length, self._take = asked, length, take
        self._by_id = {link.id: link for link in asked}
        self._waiting = dict(self._by_id)
        self._end = t + patience

    def hear(self, answer: Status, t: float) -> bool:
        """Take an answer at t, s; return whether it was asked for. A second one of a servo is only counted with it."""
        link = self._by_id.get(answer.id)
        if link is None or (len(answer.parameters) != self._length and not answer.refused):
            return False
        link.hear(answer, t)
        if self._waiting.pop(answer.id, None) is not None:
            self._take(link, answer)
        return True

    def over(self, t: float) -> bool:
        """Return whether the line is free at t, s."""
        return not self._waiting or t >= self._end

    def end(self) -> None:
        """Judge the answers. Behind one that is missing others wait in vain: the first alone is to blame."""
        for link in self.links:
            link.judge_answers()
        for link in self._waiting.values():
            link.t_quiet = self._end + _LATE_S
        for link in self._waiting.values():
            self._take(link, None)
            return
