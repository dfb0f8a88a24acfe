"""What a link asks of a service: parameters, missions, files, logs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from firmware_py.mavlink.base.codec import Message
from firmware_py.records.order import Change
from firmware_py.schedule import Tick

MessageHandler = Callable[[Tick, Message], None]


class Service(Protocol):
    """One conversation on one link; what it is about may be shared with other links."""

    def message_handlers(self) -> dict[int, MessageHandler]:
        """Who takes which message, by its id."""

    def due(self, tick: Tick) -> list[Message]:
        """What it says of itself now; asked in every tick in which there is room, so a few messages are enough."""


class PersistentState(Protocol):
    """What the links share of something that stations may change for good."""

    def changes(self) -> tuple[Change, ...]:
        """What has been changed since this was asked last, as `Order.changes` has it."""

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """What is to be kept since this was asked last: names of files in the state's folder, and their content."""
