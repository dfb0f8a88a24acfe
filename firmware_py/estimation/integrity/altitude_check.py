"""Two altitudes against each other and against the motion: altimeter and DVL.

Altitude + carried depth is the depth of the bottom. A reading in which it jumps is left out until the next ones confirm
it; if the other sensor does not, the one that jumped is suspect. If both wander apart while the vehicle rises or dives,
the one whose bottom went along is suspect. At one depth the bottom may rise as well as a sensor fail: then it is not
decided, and the nearer one holds.

A bottom that leaps away while no other sensor sees it is a cliff, or a lie: the nearer bottom holds for
`altitude_hold`. If the farther one stays all that time, it is taken on; the altitude follows it slowly.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.source_watch import SourceWatch
from firmware_py.records.health import SourceFault

_REAL = 3
"""So many readings in a row that jump alike are the bottom, if the other sensor does not object."""
_SLOPE = 1.5
"""What the bottom may rise by on the way, m/s."""
_RECENT = 1.0
"""An older altitude is no witness, s."""
_MEAN, _MEAN_NOW = 0.2, 0.5
"""Shares of a reading in the running means: that for the other sensor, and that for the pressure."""
_HISTORY, _STEP = 10, 1.0
"""Entries of the history, and their interval, s."""
_CLEAR, _MOVED = 0.5, 2.0
"""The bottom of a sound sensor stays, to this share of the other's, while the depth changes by so many thresholds."""


_AWAY = 2.0
"""Leaps away by so many steps are no rough bottom."""
_FOLLOWS = 0.2
"""So fast the bottom that held goes down to one that was farther all the time, m/s."""


@dataclass(slots=True)
class EchoMemory:
    """One sensor: its bottom (m, below the carried depth's zero) at t, running means, the last outlier.

    `history` has the mean and the carried depth, m, second by second; `held` is the nearer bottom that holds, NaN if
    none does, since `t_held`, and `t_last` when the last reading came.
    """

    t: float = -math.inf
    bottom: float = math.nan
    mean: float = math.nan
    now: float = math.nan
    outlier: float = math.nan
    t_entry: float = -math.inf
    history: tuple[tuple[float, float], ...] = ()
    held: float = math.nan
    t_held: float = -math.inf
    t_last: float = -math.inf


class AltitudeCheck:
    """Checks the readings of two altitude sensors: 0 the altimeter, 1 the DVL."""

    def __init__(self, params: IntegrityParams) -> None:
        self._params = params
        self.memory = (EchoMemory(), EchoMemory())

    @property
    def held(self) -> bool:
        """Return whether a nearer bottom holds than the altimeter measures."""
        return self.memory[0].held == self.memory[0].held

    def check(
        self, which: int, t: float, altitude: float, carried: float, watch: SourceWatch, other: SourceWatch
    ) -> bool:
        """Return whether a reading may be used; `carried` is the carried depth, m. What speaks against it is noted."""
        echo = self.memory[which]
        used = self._judge(which, t, altitude, carried, watch, other)
        if echo.held == echo.held and watch.believed:
            echo.held += _FOLLOWS * min(t - echo.t_last, _RECENT)
            if not altitude + carried > echo.held:
                echo.held = math.nan
            elif used:
                watch.hold()
                used = False
        echo.t_last = t
        return used

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
        against = bottom - seen if heard_witness else math.nan
        if not watch.believed:
            if echo.held == echo.held:
                self._judge_held(echo, t, bottom, against, watch)
            elif not abs(against) <= params.altitude and not self._agrees(echo, bottom, gap, against):
                watch.accuse(SourceFault.CONTRADICTED, t)
            echo.outlier = bottom
            return False
        if echo.bottom != echo.bottom or gap > 5.0:
            self._begin(echo, t, bottom, carried)
            return True
        if abs(bottom - echo.bottom) > params.altitude_step + _SLOPE * gap:
            alike = abs(bottom - echo.outlier) <= params.altitude_step
            echo.outlier = bottom
            if watch.refuse(t) < _REAL or not alike:
                return False
            if abs(against) > params.altitude:  # it jumped, the other did not
                watch.accuse(SourceFault.STEP, t)
                return False
            if against != against and bottom - echo.bottom > _AWAY * params.altitude_step:
                echo.held, echo.t_held = echo.bottom, t
                watch.accuse(SourceFault.STEP, t)
                return False
            self._begin(echo, t, bottom, carried)
            return True
        echo.t, echo.bottom = t, bottom
        echo.mean += _MEAN * (bottom - echo.mean)
        echo.now += _MEAN_NOW * (bottom - echo.now)
        if t - echo.t_entry >= _STEP - 1e-6:
            echo.t_entry, echo.history = t, (*echo.history[-_HISTORY + 1 :], (echo.mean, carried))
        if abs(echo.mean - witness.mean) > params.altitude and heard_witness and not other.memory.in_row:
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
            mean, before = echo.history[-size]
            own, its = abs(echo.mean - mean), abs(witness.mean - witness.history[-size][0])
            if abs(carried - before) > _MOVED * self._params.altitude:
                if own < _CLEAR * its:
                    other.accuse(SourceFault.CONTRADICTED, t)
                    watch.acquit()
                    return True
                if its < _CLEAR * own:
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
        echo.t, echo.bottom, echo.mean, echo.now = t, bottom, bottom, bottom
        echo.history, echo.t_entry = ((bottom, carried),), t

    def forget(self, which: int) -> None:
        """Begin anew with the next reading of a sensor; called when it is believed again."""
        self.memory[which].bottom = math.nan

    def altitude(self, t: float, carried: float, believed: tuple[bool, bool]) -> float:
        """Return the altitude by a sensor that is believed, m; NaN if there is none."""
        for echo, good in zip(self.memory, believed, strict=True):
            if good and t - echo.t <= _RECENT:
                return echo.now - carried
        return math.nan

    def freeze(self) -> tuple[EchoMemory, EchoMemory]:
        """Return the whole memory."""
        return copy.copy(self.memory[0]), copy.copy(self.memory[1])

    def thaw(self, memory: tuple[EchoMemory, EchoMemory]) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory[0]), copy.copy(memory[1])
