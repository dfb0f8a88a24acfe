"""What an instrument must be told so that it speaks: when its line was opened, and again when it has forgotten.

A device that lost its power has forgotten what it was told, and its line may not have broken. It is silent; or, with
settings of its own, it is heard again after a pause, in which it started; or it says what one that was told does not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

GAP_S = 0.1
"""Time between two packets, s: devices have short buffers."""
PAUSE_S = 1.5
"""Who is heard again after so long may have been without power, s: more than between two messages of any."""


def _never(_message: Any) -> bool:
    return False


class Talk(NamedTuple):
    """What an instrument is told.

    Attributes:
        packets: one after another.
        silence: told again after so long without a reading, s; with less than a measurement takes it is polled.
        forgotten: whether a message is one that a device does not send when it was told. Such a device is told again
            every `silence`, also one that refuses: only for those that go on measuring while they are told.
    """

    packets: tuple[bytes, ...]
    silence: float = 3.0
    forgotten: Callable[[Any], bool] = _never


class Speaker:
    """Tells an instrument what it must be told."""

    def __init__(self, talk: Talk, write: Callable[[bytes], None]) -> None:
        self._packets, self._silence, self._write = talk.packets, talk.silence, write
        self._next = 0
        self._t_said = self._t_heard = -math.inf

    def step(self, t: float, opened: bool, heard: bool, forgotten: bool = False) -> None:
        """Say what is due at `t`, s, if anything; `opened`, `heard`, `forgotten`: since the last time."""
        again = heard and t - self._t_heard >= PAUSE_S  # even if told meanwhile: it may not have had power yet
        again |= forgotten and t - self._t_said >= self._silence
        if heard or opened:
            self._t_heard = t
        again |= t - max(self._t_said, self._t_heard) >= self._silence
        done = self._next == len(self._packets)
        if opened or (done and again):
            self._next, done = 0, not self._packets
        if not done and t - self._t_said >= min(GAP_S, self._silence):
            self._write(self._packets[self._next])
            self._next += 1
            self._t_said = t
