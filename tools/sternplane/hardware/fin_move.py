"""One move of one fin: what it is told, and what all fins report meanwhile."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.records.sensing import Heard

TOLERANCE_RAD, TOLERANCE_SHARE = math.radians(1.0), 0.08
"""A fin is where it was told to be within this angle, or this share of it."""
_STANDS_S, _STANDS = 1.0, math.radians(0.2)
"""A fin that has gone less far for so long, s, stands; rad."""
_PATIENCE_S = 20.0
"""No move takes longer after its command has arrived."""
_REST_S = 0.3
"""And so long it must have been there."""


class Step(NamedTuple):
    """One move.

    Attributes:
        fin: which one.
        start: what it was told before, rad.
        target: what it is told then, rad.
        rate: of the command, rad/s.
        before: what each fin reported at its start, rad; NaN of one that reports nothing.
        after: the same at its end.
        lag: how long after the command the fin was there, s; NaN if it never was.
        speed: how fast it turned on the way, rad/s; NaN if that cannot be said.
        heard: how often the fin reported meanwhile.
    """

    fin: int
    start: float
    target: float
    rate: float
    before: tuple[float, ...]
    after: tuple[float, ...]
    lag: float
    speed: float
    heard: int

    def moved(self, fin: int) -> float:
        """Return how far a fin went, rad; NaN of one that reports nothing."""
        return self.after[fin] - self.before[fin]


def tolerance(angle: float) -> float:
    """Return how far from an angle a fin may be, rad."""
    return max(TOLERANCE_RAD, TOLERANCE_SHARE * abs(angle))


class Move:
    """One move as it happens: says where the fins shall be, and takes where they are.

    Attributes:
        fin: which one.
        command: the angle that it is told now, rad.
    """

    def __init__(self, fin: int, start: float, target: float, rate: float, angles: Sequence[float]) -> None:
        self.command = start
        self.fin, self._start, self._target, self._rate = fin, start, target, rate
        self._before = tuple(angles)
        self._angles = [*angles]
        self._there = self._arrived = math.nan
        self._stood, self._t_stood = math.nan, math.nan
        self._heard = 0
        self._way: list[tuple[float, float]] = []

    def update(self, t: float, dt: float, fins: Sequence[Heard[float]]) -> Step | None:
        """Take what the fins report at t, s; return the step when it is over."""
        for i, heard in enumerate(fins):
            if heard.fresh and heard.ok:
                self._angles[i] = heard.value
        own = fins[self.fin]
        if own.fresh and own.ok:
            self._heard += 1
            self._way.append((own.t_valid, own.value))
        self.command += clip(self._target - self.command, -self._rate * dt, self._rate * dt)
        if math.isnan(self._arrived) and self.command == self._target:
            self._arrived = t
        there = abs(self._angles[self.fin] - self._target) <= tolerance(self._target)
        if not there:
            self._there = math.nan
        elif math.isnan(self._there):
            self._there = t
        if not abs(self._angles[self.fin] - self._stood) < _STANDS:
            self._stood, self._t_stood = self._angles[self.fin], t
        if math.isnan(self._arrived):
            return None
        rested = t - max(self._there, self._arrived) >= _REST_S
        stands = t - max(self._t_stood, self._arrived) >= _STANDS_S and not math.isnan(self._stood)
        unheard = not self._heard and t - self._arrived >= _STANDS_S
        return self._step() if rested or stands or unheard or t - self._arrived >= _PATIENCE_S else None

    def _step(self) -> Step:
        return Step(
            self.fin,
            self._start,
            self._target,
            self._rate,
            self._before,
            tuple(self._angles),
            max(self._there - self._arrived, 0.0),  # NaN stays NaN
            self._speed(),
            self._heard,
        )

    def _speed(self) -> float:
        """Return the mean rate between a fifth and four fifths of the way."""
        way = self._target - self._start
        inner = [(t, angle) for t, angle in self._way if 0.2 <= (angle - self._start) / way <= 0.8]
        if len(inner) < 2 or inner[-1][0] <= inner[0][0]:
            return math.nan
        return abs(inner[-1][1] - inner[0][1]) / (inner[-1][0] - inner[0][0])
