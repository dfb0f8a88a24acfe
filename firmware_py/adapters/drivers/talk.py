"""What an instrument must be told so that it speaks: when its line was opened, and again while it is silent.

A device that lost its power has forgotten what it was told, and its line may not have broken: it is silent.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

GAP_S = 0.1
"""Time between two packets, s: devices have short buffers."""


class Talk(NamedTuple):
    """What an instrument is told.

    Attributes:
        packets: one after another.
        silence: told again after so long without a reading, s; with less than a measurement takes it is polled.
    """

    packets: tuple[bytes, ...]
    silence: float = 3.0


class Speaker:
    """Tells an instrument what it must be told."""

    def __init__(self, talk: Talk, write: Callable[[bytes], None]) -> None:
        self._packets, self._silence, self._write = talk.packets, talk.silence, write
        self._next = 0
        self._t_said = self._t_heard = -math.inf

    def step(self, t: float, opened: bool, heard: bool) -> None:
        """Say what is due at `t`, s, if anything; `opened`, `heard`: since the last time."""
        if heard:
            self._t_heard = t
        done = self._next == len(self._packets)
        if opened or (done and t - max(self._t_said, self._t_heard) >= self._silence):
            self._next, done = 0, not self._packets
        if not done and t - self._t_said >= min(GAP_S, self._silence):
            self._write(self._packets[self._next])
            self._next += 1
            self._t_said = t
