"""Two altitudes against each other and against the motion: altimeter and DVL.

Altitude + carried depth is the depth of the bottom. A reading in which it jumps is left out until the next ones confirm
it; if the other sensor does not, the one that jumped is suspect. If both wander apart while the vehicle rises or dives,
and the bottom of one stays, the other is suspect: what is stuck has a bottom that goes along. Where both wander, or the
vehicle keeps its depth, the bottom may rise as well as a sensor fail: then it is not decided, and the nearer one holds.

Over a rough bottom two sensors that look at different places, or at different times, may differ by what the bottom
rises and falls by: as much as it did for both of them in the last ten seconds is no contradiction, nor is a jump to a
bottom that the other saw in that time. A jump is judged when the other has had the time to see it too.

An altitude that stays while the vehicle dives, and no other sensor sees the bottom, is in doubt (`still_altitude`): the
bottom of before holds, until the altitude reacts to the motion or another sensor tells.

A bottom that leaps away while no other sensor sees it is a cliff, or a lie: the nearer bottom holds for
`altitude_hold`. If the farther one stays all that time, it is taken on; the altitude follows it slowly.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.estimation.integrity.still_altitude import LENGTH, REACTS, Sounding, bottom_before
from firmware_py.records.health import SourceFault

_REAL = 3
"""So many readings in a row that jump alike are the bottom, if the other sensor does not object."""
_SEEN = 0.4
"""The other sensor has seen what a jump is by then, s: two pings of 5 Hz, 0.1 s late."""
_SLOPE = 1.5
"""What the bottom may rise by on the way, m/s."""
_RECENT = 1.0
"""An older altitude is no witness, s."""
_MEAN_TIME, _MEAN_NOW = 0.8, 0.5
"""Time constant of the running mean that is held against the other sensor's, s, the same for both: over a slope means
that lag differently part. Share of a reading in that for the pressure."""
_UNHEARD = 5.0
"""After a longer silence, s, a sensor begins anew."""
_JUST = 2.0
"""For so long, s, a jump that one sensor saw explains one of the other, and running means may differ after it."""
_ROUGH_TIME = 10.0
"""For about so long it counts how far the bottom rose and fell, s."""
_HISTORY, _STEP = 10, 1.0
"""Entries of the history, and their interval, s."""
_CLEAR, _MOVED = 0.5, 2.0
"""The bottom of a sound sensor stays, to this share of the other's and of the depth, while that changes by so many
thresholds; that of the other one has changed by more than this share of a threshold."""
_AWAY = 2.0
"""Leaps away by so many steps are no rough bottom."""
_FOLLOWS = 0.2
"""So fast the bottom that held goes down to one that was farther all the time, m/s."""


@dataclass(slots=True)
class EchoMemory:
    """One sensor: its bottom (m, below the carried depth's zero) at t, running means, the last outlier.

    `low` and `high` are how far its bottom went up and down lately, `t_jump` since when readings jump, `t_outlier` when
    one did last; `t_begun` when a new bottom was taken on. `history` has the bottom and the carried depth, m, second by
    second; `held` is the nearer bottom that holds, NaN if none does, since `t_held`, and `t_last` when the last reading
    came. The carried depth was deeper than the depth that is believed by `off`, m. `track` are soundings, second by
    second, beyond any jump; `still` is the altitude, m, that stays, NaN if it is not in doubt.
    """

    t: float = -math.inf
    bottom: float = math.nan
    mean: float = math.nan
    now: float = math.nan
    outlier: float = math.nan
    low: float = math.nan
    high: float = math.nan
    t_jump: float = -math.inf
    t_outlier: float = -math.inf
    t_begun: float = -math.inf
    t_entry: float = -math.inf
    history: tuple[tuple[float, float], ...] = ()
    held: float = math.nan
    t_held: float = -math.inf
    t_last: float = -math.inf
    off: float = 0.0
    track: tuple[Sounding, ...] = ()
    still: float = math.nan


class AltitudeCheck:
    """Checks the readings of two altitude sensors: 0 the altimeter, 1 the DVL."""

    def __init__(self, params: IntegrityParams) -> None:
        self._params = params
        self.memory = (EchoMemory(), EchoMemory())

    def held(self, which: int) -> float:
        """Return the nearer bottom that holds instead of what a sensor measures, m; NaN: none does."""
        return self.memory[which].held

    def check(
        self,
        which: int,
        t: float,
        altitude: float,
        carried: float,
        depth: float,
        watch: SourceWatch,
        other: SourceWatch,
    ) -> bool:
        """Return whether a reading may be used; what speaks against it is noted.

        `carried` is the carried depth, `depth` the one that is believed, m; NaN if none is. A bottom that is held for
        long goes by this one.
        """
        echo, off = self.memory[which], carried - depth
        if off == off:
            if echo.held == echo.held:
                echo.held += off - echo.off
            echo.off = off
        used = self._judge(which, t, altitude, carried, watch, other)
        if watch.believed:
            self._doubt(which, t, carried, watch, other)
        if echo.held == echo.held and watch.believed:
            if echo.still != echo.still:
                echo.held += _FOLLOWS * min(t - echo.t_last, _RECENT)
            if not altitude + carried > echo.held:
                echo.held = echo.still = math.nan
            elif used:
                watch.hold()
                used = False
        echo.t_last = t
        return used

    def _doubt(self, which: int, t: float, carried: float, watch: SourceWatch, other: SourceWatch) -> None:
        """Doubt a sensor whose altitude stays while the vehicle dives, and no longer one whose altitude reacts."""
        echo, witness = self.memory[which], self.memory[1 - which]
        alone = not (other.believed and t - witness.t <= _RECENT)
        if echo.still == echo.still:
            if alone and abs(echo.now - carried - echo.still) < REACTS:
                watch.accuse(SourceFault.UNDECIDED, t)
            else:
                echo.held, echo.still, echo.track = math.nan, math.nan, ()
        elif alone and echo.held != echo.held and echo.t_entry == t:
            echo.held = bottom_before(echo.track)
            if echo.held == echo.held:
                echo.still = echo.now - carried
                watch.accuse(SourceFault.UNDECIDED, t)

    def _judge(
        self, which: int, t: float, altitude: float, carried: float, watch: SourceWatch, other: SourceWatch
    ) -> bool:
        """Judge a reading by the other sensor and by those before."""
        params = self._params
        echo, witness = self.memory[which], self.memory[1 - which]
        if not 0.0 <= altitude < math.inf:
            return True  # navigation takes no such value
        bottom = altitude + carried
        gap, heard_witness = t - echo.t, other.believed and t - witness.t <= _RECENT
        seen = witness.outlier if other.memory.in_row else witness.mean  # one that jumps alike bears it out
        against = _nearest(t, bottom, seen, witness) if heard_witness else math.nan
        limit = max(params.altitude, _rough(echo, witness))
        if not watch.believed:
            if echo.held == echo.held:
                self._judge_held(echo, t, bottom, against, watch)
            elif not abs(against) <= limit and not self._agrees(echo, bottom, gap, against):
                watch.accuse(SourceFault.CONTRADICTED, t)
            echo.outlier = bottom
            return False
        if echo.bottom != echo.bottom or gap > _UNHEARD:
            alike = t - echo.t_outlier <= _UNHEARD and abs(bottom - echo.outlier) <= params.altitude_step
            if not (alike or abs(bottom - echo.bottom) <= params.altitude_step or echo.t == -math.inf):
                echo.outlier, echo.t_outlier = bottom, t  # after a silence one reading alone may be false
                watch.hold()
                return False
            self._begin(echo, t, bottom, carried)
            return True
        if abs(bottom - echo.bottom) > params.altitude_step + _SLOPE * gap:
            alike = abs(bottom - echo.outlier) <= params.altitude_step
            echo.outlier, echo.t_outlier = bottom, t
            in_row = watch.refuse(t)
            if in_row == 1:
                echo.t_jump = t
            if in_row < _REAL or not alike or (heard_witness and t - echo.t_jump < _SEEN - 1e-6):
                return False
            if abs(against) > limit:  # it jumped, the other did not
                watch.accuse(SourceFault.STEP, t)
                return False
            if against != against and bottom - echo.bottom > _AWAY * params.altitude_step:
                echo.held, echo.t_held = echo.bottom, t
                watch.accuse(SourceFault.STEP, t)
                return False
            self._begin(echo, t, bottom, carried)
            return True
        echo.t, echo.bottom = t, bottom
        echo.mean += gap / (_MEAN_TIME + gap) * (bottom - echo.mean)
        self._fade(echo, gap / (_ROUGH_TIME + gap))
        echo.now += _MEAN_NOW * (bottom - echo.now)
        if t - echo.t_entry >= _STEP - 1e-6:
            echo.t_entry, echo.history = t, (*echo.history[-_HISTORY + 1 :], (echo.now, carried))
            echo.track = (*echo.track[-LENGTH + 1 :], Sounding(echo.now, carried, echo.off))
        settled = t - max(echo.t_begun, witness.t_begun) > _JUST
        if settled and abs(echo.mean - witness.mean) > limit and heard_witness and not other.memory.in_row:
            return self._arbitrate(echo, witness, t, carried, watch, other)
        return True

    def _judge_held(self, echo: EchoMemory, t: float, bottom: float, against: float, watch: SourceWatch) -> None:
        """Say whether a bottom that leapt away is back, or seen by the other sensor, or has stayed for long enough."""
        params = self._params
        if bottom <= echo.held + params.altitude_step or abs(against) <= params.altitude:
            return
        if abs(bottom - echo.outlier) > params.altitude_step:
            echo.t_held = t
        if against == against or t - echo.t_held < params.altitude_hold:
            watch.accuse(SourceFault.STEP, t)

    @staticmethod
    def _agrees(echo: EchoMemory, bottom: float, gap: float, against: float) -> bool:
        """Return whether, without the other sensor, a suspect one is back where it was."""
        return against != against and abs(bottom - echo.bottom) <= 1.0 + _SLOPE * min(gap, 10.0)

    def _arbitrate(
        self, echo: EchoMemory, witness: EchoMemory, t: float, carried: float, watch: SourceWatch, other: SourceWatch
    ) -> bool:
        """Accuse who is wrong, or both; return whether a reading of the first may be used."""
        size = min(len(echo.history), len(witness.history))
        if size:
            then, before = echo.history[-size]
            own, its = abs(echo.now - then), abs(witness.now - witness.history[-size][0])
            moved, parted = abs(carried - before), _CLEAR * self._params.altitude
            if moved > _MOVED * self._params.altitude:
                if own < _CLEAR * min(its, moved) and its > parted:
                    other.accuse(SourceFault.CONTRADICTED, t)
                    watch.acquit()
                    return True
                if its < _CLEAR * min(own, moved) and own > parted:
                    watch.accuse(SourceFault.CONTRADICTED, t)
                    other.acquit()
                    return False
        watch.accuse(SourceFault.UNDECIDED, t)
        other.accuse(SourceFault.UNDECIDED, t)
        if echo.mean > witness.mean:
            watch.hold()
            return False
        return True

    @staticmethod
    def _begin(echo: EchoMemory, t: float, bottom: float, carried: float) -> None:
        jumped = bottom - echo.bottom if t - echo.t <= _UNHEARD else math.nan
        echo.track = tuple([at.leap(jumped) for at in echo.track]) if jumped == jumped else ()
        echo.t, echo.bottom, echo.mean, echo.now = t, bottom, bottom, bottom
        echo.history, echo.t_entry = ((bottom, carried),), t
        echo.t_begun = t
        AltitudeCheck._fade(echo, 0.0)

    @staticmethod
    def _fade(echo: EchoMemory, share: float) -> None:
        """Take the bottom into how far it went up and down, and let a share of what is beyond it fade."""
        now = echo.bottom
        echo.low = now if not echo.low < now else echo.low + share * (now - echo.low)
        echo.high = now if not echo.high > now else echo.high + share * (now - echo.high)

    def forget(self, which: int) -> None:
        """Begin anew with the next reading of a sensor; called when it is believed again."""
        echo = self.memory[which]
        echo.bottom = echo.low = echo.high = math.nan
        if echo.still == echo.still:
            echo.held = echo.still = math.nan

    def altitude(self, t: float, carried: float, believed: tuple[bool, bool]) -> float:
        """Return the altitude by a sensor that is believed, and not in doubt alone, m; NaN if there is none."""
        for echo, good in zip(self.memory, believed, strict=True):
            if good and echo.still != echo.still and t - echo.t <= _RECENT:
                return echo.now - carried
        return math.nan

    def freeze(self) -> tuple[EchoMemory, EchoMemory]:
        """Return the whole memory."""
        return copy.copy(self.memory[0]), copy.copy(self.memory[1])

    def thaw(self, memory: tuple[EchoMemory, EchoMemory]) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory[0]), copy.copy(memory[1])


def _nearest(t: float, bottom: float, seen: float, witness: EchoMemory) -> float:
    """Return what a bottom is off by, m: from what the other sensor sees, or from all that it saw lately."""
    low, high = min(witness.low, seen), max(witness.high, seen)
    if t - witness.t_outlier <= _JUST:
        low, high = min(low, witness.outlier), max(high, witness.outlier)
    if low <= bottom <= high:
        return 0.0
    return bottom - low if bottom < low else bottom - high


def _rough(one: EchoMemory, other: EchoMemory) -> float:
    """Return by how much the bottom of both sensors rose and fell lately, m: that of the one for which it did less."""
    rough = min(one.high - one.low, other.high - other.low)
    return rough if rough > 0.0 else 0.0
