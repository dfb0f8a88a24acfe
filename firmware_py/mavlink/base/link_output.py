"""What the services of a link have in common: who speaks for them, and a command as both messages say it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.schedule import Tick

ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
REJECTED: int = dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED: int = dialect.MAV_RESULT_DENIED
UNSUPPORTED: int = dialect.MAV_RESULT_UNSUPPORTED
NO_FRAME = 9
"""MAV_RESULT_COMMAND_UNSUPPORTED_MAV_FRAME, which the dialect does not name."""
WARNING: int = dialect.MAV_SEVERITY_WARNING


class CommandRefused(Exception):
    """Why something is not done, in words for people, with the MAV_RESULT that says so."""

    def __init__(self, text: str, result: int = DENIED) -> None:
        super().__init__(text)
        self.result = result


class LinkOutput(Protocol):
    """The link that a message came by."""

    def send(self, message: Message) -> None:
        """Sends a message."""

    def send_text(self, text: str, severity: int) -> None:
        """Sends a sentence, which names modes as `records.order.Mode` does."""

    def count_dropped(self) -> None:
        """Counts a message that there was no room for."""

    def send_from_cycle(self, name: int) -> None:
        """Sends a message that is made of the next cycle."""


class Command(NamedTuple):
    """COMMAND_LONG or COMMAND_INT; x and y of the latter are the fifth and sixth of `params`, in its own units.

    `frame` is COMMAND_INT's, -1 where there is none; `again` is True if the sender says that it has sent it before.
    """

    system: int
    component: int
    number: int
    again: bool
    params: tuple[float, ...]
    frame: int = -1


CommandHandler = Callable[[Tick, Command], int | None]
"""Does a command: its result, or None if the answer comes with the cycle that obeys.

It raises `CommandRefused` where it does not, so that no station is refused without a word.
"""


def ident(value: float) -> int:
    """A message id out of a parameter; -1 if it is none."""
    return int(value) if math.isfinite(value) else -1
