"""The master of GlobalTimeSync: the time that the network keeps is the vehicle's, t = k dt.

Each message says when the one before it was sent, so that whoever heard both knows how far its clock is off. Times are
those of the ticks and their lateness: they begin at 0 with the program, and no clock that is set can make them jump.
"""

from __future__ import annotations

from firmware_py.tick import Tick
from firmware_py.wire.dronecan.node_messages import GlobalTimeSync

PERIOD = 1.0
"""Between two messages, s; 0.04 to 1.1 is permitted."""
SHORTEST_US = 40_000
SILENCE = 2.2
"""A master that was not heard for so long is gone, s."""


class TimeMaster:
    """Says the time, unless a node with a lower id does.

    A message leaves at the very beginning of a tick, before anything that takes a while: `message` is asked first, and
    `begun` then tells when that was.
    """

    def __init__(self, own_id: int) -> None:
        self._own_id = own_id
        self._quiet_until = 0.0
        self._due = 0.0
        self._sent_us = 0
        """When the last message was sent, us; 0 is unknown."""
        self._pending = False
        self._now_us = 0

    def hear(self, source: int, t: float) -> None:
        """Take note of another master's message."""
        if source < self._own_id:
            self._quiet_until = t + SILENCE
            self._sent_us = 0  # a message says the time of one by the same master, not of one long ago

    def message(self, t: float) -> GlobalTimeSync | None:
        """Return the message to be sent at once in the tick at t, s; None if none is due.

        After ticks that came late and are caught up on, one that would follow too closely is left out.
        """
        if t < self._due or t < self._quiet_until:
            return None
        self._due = t + PERIOD
        if self._sent_us and self._now_us - self._sent_us < SHORTEST_US:
            return None
        self._pending = True
        return GlobalTimeSync(self._sent_us)

    def begun(self, tick: Tick) -> None:
        """Take when the tick really began: its time and its lateness."""
        self._now_us = (tick.k * tick.dt_ns + tick.late_ns) // 1000
        if self._pending:
            self._pending = False
            self._sent_us = max(self._now_us, 1)
