"""The channels of one sensor: one that had noise, and repeats itself exactly while others still have noise.

A gyro's axis that is dead, or a velocity that stays, does not make a sensor repeat its whole value.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

_NOISY, _NOISY_MOST, _SMOOTH, _RUN = 10.0, 40.0, 0.05, 25
"""As in `source_watch.py`, of each channel: reversals are noise, beyond _NOISY of them it has noise."""
_REPEAT = 5.0
"""Each repeat takes so much of that away, once the channel has changed again. Coarse steps make repeats: a channel
whose steps are wider than 0.4 of its noise's sigma is one without noise, and is never called stuck."""
_ROUNDING = 1e-6
"""Smaller changes, rad, rad/s, m/s, are those of arithmetic."""
_LEAST = 15
"""So many repeats, and it is stuck: one that passes as noisy repeats its value less often than one time in nine."""
_WITNESS = 0.25
"""So much noise of other channels in each repeat, and the sensor has noise still: reversals, of which each makes
0.7, less what repeats take. Where all become quiet together, as a DVL does at rest, none is stuck."""
_TICK = 1e-3
"""Times may be rounded by so much, s."""


@dataclass(slots=True)
class Channel:
    """What is remembered of one channel.

    Attributes:
        noisy: how much noise it had,
        rising: whether its last change was upwards,
        run: changes since the last reversal, up to _RUN.
        repeats: how often it has repeated its value now,
        since: since when, s,
        mark: the noise of all channels then.
    """

    noisy: float = 0.0
    rising: bool = False
    run: int = 0
    repeats: int = 0
    since: float = 0.0
    mark: float = 0.0


class ChannelsMemory(NamedTuple):
    """What is remembered of all of them, and their noise together: reversals less what repeats took."""

    channels: tuple[Channel, ...]
    noise: float


class ChannelWatch:
    """Watches the first channels of a sensor's value."""

    def __init__(self, channels: int, frozen: float) -> None:
        """Take how many channels are watched; exact repeats for longer than `frozen`, s, mean that one is stuck."""
        self._frozen = frozen
        self._channels = tuple([Channel() for _ in range(channels)])
        self._noise = 0.0

    def hear(self, value: Iterable[float], before: Iterable[float], t: float) -> bool:
        """Take note of a value and the one before it; return whether a channel is stuck."""
        stuck, noise = False, self._noise
        for channel, now, then in zip(self._channels, value, before, strict=False):
            if now == then:
                channel.repeats += 1
                if channel.repeats == 1:
                    channel.since, channel.mark = t, noise
                elif channel.repeats >= _LEAST and channel.noisy >= _NOISY:
                    stuck = stuck or self._is_stuck(channel, t)
                continue
            if channel.repeats:
                lost = min(channel.noisy, _REPEAT * channel.repeats)
                channel.noisy -= lost
                noise -= lost
                channel.repeats = 0
            rising = now > then
            if rising is not channel.rising:
                channel.rising = rising
                if not -_ROUNDING < now - then < _ROUNDING:
                    channel.run = 0
                    noise += 1.0
                    if channel.noisy < _NOISY_MOST:
                        channel.noisy += 1.0
            elif channel.noisy > 0.0 and channel.run < _RUN:
                channel.noisy -= _SMOOTH
                channel.run += 1
        self._noise = noise
        return stuck

    def _is_stuck(self, channel: Channel, t: float) -> bool:
        """Return whether it repeats itself for long enough, and others had noise meanwhile."""
        heard = self._noise - channel.mark
        return t - channel.since >= self._frozen - _TICK and heard >= _WITNESS * channel.repeats

    def freeze(self) -> ChannelsMemory:
        """Return the whole memory."""
        return ChannelsMemory(tuple([copy.copy(channel) for channel in self._channels]), self._noise)

    def thaw(self, memory: ChannelsMemory) -> None:
        """Restore the memory that `freeze` returned."""
        channels, self._noise = memory
        self._channels = tuple([copy.copy(channel) for channel in channels])
