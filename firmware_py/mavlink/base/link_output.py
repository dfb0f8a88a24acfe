"""What a service of a link uses: the link's output, and a command as COMMAND_LONG and COMMAND_INT both give it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

from firmware_py.mavlink.base.codec import Message, dialect
from firmware_py.mavlink.base.refusal import Refusal
from firmware_py.tick import Tick

ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
REJECTED: int = dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED: int = dialect.MAV_RESULT_DENIED
UNSUPPORTED: int = dialect.MAV_RESULT_UNSUPPORTED
NO_FRAME = 9
"""MAV_RESULT_COMMAND_UNSUPPORTED_MAV_FRAME, which pymavlink's dialect does not name."""
WARNING: int = dialect.MAV_SEVERITY_WARNING


class CommandRefused(Exception):
    """Why a command is refused, for the operator, and the MAV_RESULT."""

    def __init__(self, why: Refusal, result: int = DENIED) -> None:
        super().__init__(why)
        self.why = why
        self.result = result


class LinkOutput(Protocol):
    """The link that a message came by, as the services answer through it."""

    def send(self, message: Message) -> None:
        """Send a message when its turn comes."""

    def send_text(self, text: str, severity: int) -> None:
        """Send a sentence as STATUSTEXT."""

    def send_refusal(self, what: str, why: Refusal) -> None:
        """Send as STATUSTEXT that a command or message is refused, and why."""

    def count_dropped(self) -> None:
        """Count a received message that a service had no room for."""

    def send_from_cycle(self, message_id: int) -> None:
        """Send the message of that id, encoded from the next cycle."""


class Command(NamedTuple):
    """A COMMAND_LONG or COMMAND_INT; x and y of the latter are `params` five and six, in its own units.

    `frame` is COMMAND_INT's frame, -1 for COMMAND_LONG; `again` is True if the sender marks it as a retransmission.
    """

    system: int
    component: int
    number: int
    again: bool
    params: tuple[float, ...]
    frame: int = -1


CommandHandler = Callable[[Tick, Command], int | None]
"""Executes a command. Returns its MAV_RESULT, or None if the result comes with the cycle that executes it.

A handler that refuses raises `CommandRefused`, so that every refusal comes with a sentence.
"""


def message_id_of(value: float) -> int:
    """Return the message id that a command parameter holds; -1 if it holds none."""
    return int(value) if math.isfinite(value) else -1
