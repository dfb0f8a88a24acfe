"""One sensor as it is heard: silence, exact repeats, single outliers, and for how long it is not believed."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from firmware_py.estimation.integrity.channel_watch import ChannelsMemory, ChannelWatch
from firmware_py.records.health import GOOD, HEADING_FAULTS, SourceFault, SourceHealth, SourceState
from firmware_py.records.sensing import Heard, never

_NOISY, _NOISY_MOST, _SMOOTH, _RUN = 10.0, 40.0, 0.05, 25
"""Noise reverses two of three changes from value to value, in a steep dive one of eight, or none. Each reversal counts
1, up to _NOISY_MOST, each other change takes _SMOOTH away, up to _RUN of them in a row: a long dive says no more than a
short one. Above _NOISY the sensor has noise. One that has none repeats its value where it rests."""
_REPEAT = 3.0
"""Each repeat of a value takes so much of that away, once it has changed again: a sensor whose steps are wider than its
noise reverses its changes as well, and repeats itself by nature. One whose repeats are given longer is left out."""
_EXACT = 2.5
"""Whether it has noise or not: one that repeats itself for so long, s, while others show that it moves, is frozen."""
_OUTLIERS, _FORGOTTEN = 4.0, 5.0
"""So many outliers in about so many seconds are more than now and then."""
_MILD = (SourceFault.UNDECIDED, *HEADING_FAULTS)
_MILDEST = (SourceFault.OUTLIERS, SourceFault.UNDECIDED, SourceFault.STEERING)
_USED = (SourceFault.NONE, SourceFault.OUTLIERS, SourceFault.UNDECIDED)
_TICK = 1e-3
"""Times may be rounded by so much, s."""


def _same(value: Any, before: Any) -> bool:
    """Return whether a value repeats the one before it; what is unknown, NaN, repeats itself too.

    Python holds a NaN for equal to itself, and not to another one, as a replayed log has them.
    """
    if not isinstance(value, tuple):
        return bool(value == before or (value != value and before != before))
    return before is not None and all(map(_same, value, before))


@dataclass(slots=True)
class SourceMemory:
    """What is remembered of one sensor; times in s.

    `held` is the last measurement that was passed on, `passed` whether the newest was. `fault` is what spoke against it
    last, at `t_bad`, since `t_fault`; `lost` why it is lost, if so. `t_steady` is since when it is heard without gaps;
    `t_withheld` when it was last heard while its node was not believed, `t_back` when it was good again after it was
    lost. `motion` is what others told of the motion when its value was a new one; `refused` how many values were left
    out one by one. `channels` is what its channels' watch remembers, where there is one; only a frozen memory has it.
    """

    held: Heard[Any]
    passed: bool = True
    t_heard: float = -math.inf
    t_ok: float = -math.inf
    t_steady: float = -math.inf
    t_withheld: float = -math.inf
    t_back: float = -math.inf
    fault: SourceFault = SourceFault.NONE
    t_bad: float = -math.inf
    t_fault: float = -math.inf
    lost: SourceFault = SourceFault.NONE
    value: Any = None
    repeats: int = 0
    t_value: float = 0.0
    motion: tuple[float, ...] = ()
    change: float = 0.0
    noisy: float = 0.0
    run: int = 0
    outliers: float = 0.0
    in_row: int = 0
    refused: int = 0
    channels: ChannelsMemory | None = None


class SourceWatch:
    """Watches one sensor. `memory.fault` is NONE while it is believed."""

    def __init__(
        self,
        timeout: float,
        frozen: float,
        least_repeats: int,
        channel: int | None = None,
        out_of_reach: Callable[[Any], bool] = lambda _: False,
        steady: float = 0.0,
        gap: float = math.inf,
        late: float = math.inf,
        channels: int = 0,
    ) -> None:
        """Take the limits.

        Args:
            timeout: without a good value for longer than this, s, it is lost.
            frozen: exact repeats for so long, s, and
            least_repeats: at least so many of them, mean a frozen sensor.
            channel: which number of its value shows its noise; None: the value is a number.
            out_of_reach: whether a value that is not ok only says that there is nothing to measure.
            steady: one that was lost is heard for so long, s,
            gap: without a longer gap than this, s, before it is good again.
            late: a value that is older than this when it comes, s, is too late.
            channels: so many of the first numbers of its value are watched, each for itself.
        """
        self._timeout, self._frozen, self._repeats = timeout, frozen, least_repeats
        self._channel, self._out_of_reach = channel, out_of_reach
        self._steady, self._gap, self._late = steady, gap, late
        self._channels = ChannelWatch(channels, frozen) if channels else None
        self.memory = SourceMemory(never(None))
        self.news = False
        """Whether the health has to be told anew."""
        self.clean = True
        """Whether what was heard may be passed on as it is."""

    def hear(self, heard: Heard[Any], t: float, motion: tuple[float, ...] = ()) -> bool:
        """Take note of what has come in this tick; return whether there is a value to check.

        `motion` is what others tell of the motion, in units of a change that changes a sound one's value; empty where
        they tell nothing.
        """
        memory = self.memory
        memory.t_heard = t
        if not heard.ok:
            self.silence()  # it says itself that this is nothing
            if self._out_of_reach(heard.value):
                self._alive(t)
            return False
        if t - heard.t_valid > self._late:
            self._alive(t)
            self.accuse(SourceFault.LATE, t)
            return False
        value, channels = heard.value, self._channels
        if channels is not None and memory.value is not None and channels.hear(value, memory.value, t):
            self.accuse(SourceFault.FROZEN, t)
        if not _same(value, memory.value):
            if memory.value is not None:
                if memory.repeats and self._frozen < _EXACT:
                    memory.noisy = max(0.0, memory.noisy - _REPEAT * memory.repeats)
                channel = self._channel
                change = value - memory.value if channel is None else value[channel] - memory.value[channel]
                if change * memory.change < 0.0:
                    memory.noisy, memory.run = min(memory.noisy + 1.0, _NOISY_MOST), 0
                elif memory.noisy > 0.0 and memory.run < _RUN:
                    memory.noisy -= _SMOOTH
                    memory.run += 1
                memory.change = change
            memory.value, memory.repeats, memory.t_value, memory.motion = value, 0, t, motion
        else:
            memory.repeats += 1
            memory.motion = memory.motion or motion
            if memory.repeats >= self._repeats and self._is_frozen(t, motion):
                self.accuse(SourceFault.FROZEN, t)
        self._alive(t)
        return True

    def _is_frozen(self, t: float, motion: tuple[float, ...]) -> bool:
        """Return whether it should not repeat itself: it had noise, it was frozen before, or the vehicle has moved."""
        memory = self.memory
        if memory.noisy >= _NOISY and t - memory.t_value >= self._frozen - _TICK:
            return True
        moved = any(abs(now - then) > 1.0 for now, then in zip(motion, memory.motion, strict=False))
        return memory.fault is SourceFault.FROZEN or (moved and self.is_exact(t))

    def is_exact(self, t: float) -> bool:
        """Return whether it repeats itself for so long that it is to blame, if something contradicts it."""
        return self.memory.repeats >= self._repeats and t - self.memory.t_value >= _EXACT - _TICK

    def _alive(self, t: float) -> None:
        memory = self.memory
        if t - memory.t_ok > self._gap:
            memory.t_steady = t
        memory.t_ok = t

    def take(self, heard: Heard[Any]) -> None:
        """Pass a value on."""
        memory = self.memory
        memory.held, memory.passed, memory.in_row = heard, True, 0
        self.clean = memory.fault is SourceFault.NONE

    def substitute(self, heard: Heard[Any]) -> None:
        """Pass another value on in place of what was heard."""
        self.hold()
        self.memory.held, self.memory.in_row = heard, 0

    def refuse(self, t: float) -> int:
        """Leave a value out; return how many were left out in a row."""
        memory = self.memory
        self.clean = memory.passed = False
        memory.in_row += 1
        memory.refused += 1
        if memory.in_row == 1:
            memory.outliers += 1.0
            if memory.outliers > _OUTLIERS:
                self.accuse(SourceFault.OUTLIERS, t)
        return memory.in_row

    def silence(self) -> None:
        """Note that there is nothing to take or to leave out."""
        self.memory.passed = True
        self.clean = self.memory.fault is SourceFault.NONE

    def excuse(self, t: float) -> None:
        """Note that there is nothing to be heard where the vehicle is."""
        self._alive(t)

    def hold(self) -> None:
        """Leave a value out that waits for the next one to confirm it."""
        self.clean = self.memory.passed = False

    def accuse(self, fault: SourceFault, t: float) -> None:
        """Say what speaks against it now. The first accusation names the fault, until it is believed again.

        Outliers, a wrong heading and what is not decided, which stop nothing, give way to a later accusation.
        """
        memory, first = self.memory, self.memory.fault
        mild = first in _MILD and fault not in _MILDEST
        gives_way = first in (SourceFault.NONE, SourceFault.OUTLIERS) or mild or fault is SourceFault.FROZEN
        if gives_way and first is not fault:
            memory.fault, memory.t_fault, self.news = fault, t, True
        memory.t_bad = t
        self.clean = False

    def acquit(self) -> None:
        """Take back what is not decided, for another sensor is to blame."""
        if self.memory.fault is SourceFault.UNDECIDED:
            self.memory.fault, self.news = SourceFault.NONE, True
            self.clean = self.memory.passed

    def lose(self, fault: SourceFault) -> None:
        """Call it lost, until `judge` finds otherwise."""
        memory = self.memory
        self.news = self.news or memory.lost is not fault
        memory.lost, memory.t_withheld = fault, memory.t_heard

    def judge(self, t: float, dt: float, recovery: float, start: float) -> None:
        """Look at silence and recovery; called now and then, every dt, s."""
        memory = self.memory
        memory.outliers *= max(0.0, 1.0 - dt / _FORGOTTEN)
        if memory.fault is not SourceFault.NONE and t - memory.t_bad >= recovery:
            memory.fault = SourceFault.NONE
            self.clean = memory.passed
        since = memory.t_ok if memory.t_ok > -math.inf else max(0.0, start - self._timeout)
        if t - since <= self._timeout + _TICK:
            if memory.lost is not SourceFault.NONE and not t - memory.t_steady < self._steady - _TICK:
                memory.lost, memory.t_back = SourceFault.NONE, t
        elif t - memory.t_heard > self._timeout:
            memory.lost = SourceFault.SILENT
        elif memory.lost is SourceFault.NONE or memory.t_heard - memory.t_withheld > self._timeout:
            memory.lost = SourceFault.UNHEALTHY  # else it was not ok because it was withheld

    @property
    def believed(self) -> bool:
        """Return whether its values are used; outliers, and what is less safe, are left out one by one."""
        return self.memory.fault in _USED

    @property
    def health(self) -> SourceHealth:
        """Return state and fault."""
        memory = self.memory
        if memory.lost is not SourceFault.NONE:
            return SourceHealth(SourceState.LOST, memory.lost)
        if memory.fault is not SourceFault.NONE:
            return SourceHealth(SourceState.SUSPECT, memory.fault)
        return GOOD

    def screen(self, heard: Heard[Any]) -> Heard[Any]:
        """Return what the vehicle may use in place of what was heard."""
        memory = self.memory
        if not self.believed:
            return Heard(
                memory.held.value if memory.held.value is not None else heard.value, memory.held.t_valid, False, False
            )
        if memory.passed:
            return heard
        return (
            Heard(memory.held.value, memory.held.t_valid, False, memory.held.ok)
            if memory.held.value is not None
            else Heard(heard.value, -math.inf, False, False)
        )

    def freeze(self) -> SourceMemory:
        """Return the whole memory."""
        memory = copy.copy(self.memory)
        if self._channels is not None:
            memory.channels = self._channels.freeze()
        return memory

    def thaw(self, memory: SourceMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
        if self._channels is not None and memory.channels is not None:
            self._channels.thaw(memory.channels)
        self.clean = memory.passed and memory.fault is SourceFault.NONE
