"""The interfaces of a link's services: parameters, plans, files, logs, time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from firmware_py.mavlink.base.codec import Message
from firmware_py.records.order import Change
from firmware_py.tick import Tick

MessageHandler = Callable[[Tick, Message], None]


class Service(Protocol):
    """One protocol on one link; the data behind it may be shared with other links."""

    def message_handlers(self) -> dict[int, MessageHandler]:
        """Return the handler of each message id that the service receives."""

    def due(self, tick: Tick) -> list[Message]:
        """Return the next messages to send; called in every tick that has room, so a few messages are enough."""


class PersistentState(Protocol):
    """State shared by all links that stations may change permanently."""

    def changes(self) -> tuple[Change, ...]:
        """Return the changes since the last call, as `Order.changes` has them."""

    def files_to_save(self) -> list[tuple[str, bytes]]:
        """Return the files to save since the last call: name in the state folder, and content."""
