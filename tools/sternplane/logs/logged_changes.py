"""What stations have changed, as a log has it: decoded, and checked."""

from __future__ import annotations

from firmware_py.records.order import Change
from firmware_py.wire.log import changes
from firmware_py.wire.log.changes import LoggedChange


def decode_change(logged: LoggedChange) -> Change:
    """Decode a change, and refuse one that is not logged in the same way again: a code out of range may pass for one.

    Raises:
        ValueError, LookupError or TypeError: it is not what `changes.encode` makes.
    """
    change = changes.decode(logged)
    again = changes.encode(change)
    if again.text != logged.text or list(map(repr, map(float, again.numbers))) != list(map(repr, logged.numbers)):
        raise ValueError(again)
    return change
