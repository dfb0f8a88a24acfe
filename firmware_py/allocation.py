"""Control allocation: delta_s and delta_r to the fins of any layout, over what is left of them.

The fin angles d minimise sum (d / delta_max)^2 under s . d = delta_s and r . d = delta_r (weighted pseudo-inverse;
Fossen 2011, ch. 12.3). A fin that would exceed its limit is held there, and the others share the remainder (cascaded
generalised inverse; Bordignon 1996). A fin that is stuck at a known angle is held there from the beginning, so that the
others oppose it. If it reports, it is still asked for what it would do sound, to show when it comes free; else it is
told to be where it is thought to be, so that all who go by commands know of it. A fin that makes less force than others
of its axis is asked for less of the axis' work; what all of an axis have lost, the laws know of.

Sound fins that cannot make both leave as much undone of one axis as of the other. Where a fin of an X is damaged, pitch
comes first (ours): what opposes a stuck fin is one-sided, and a turn would take the pitch away, or turn it about. A
wrong heading leads off the track, a wrong pitch to the bottom.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.records.command import Demand, FinCommand
from firmware_py.records.health import FinEvidence, FinHealth
from firmware_py.vehicle.vehicle import Vehicle

_REGULARISATION = 1e-9
"""Relative; the free fins may all act along one line, which still has a least-squares solution."""
_MADE = 1e-6
"""What is so little off delta_s, rad, is made."""
_Row = tuple[float, ...]


class _Layout(NamedTuple):
    """Fins to allocate to: rows of the effects, the fins that move, their gains, and what stuck ones make.

    `kept` are those that are told to stay, with their angles.
    """

    s: _Row
    r: _Row
    free: tuple[int, ...]
    gains: tuple[tuple[float, float], ...]
    stuck_s: float
    stuck_r: float
    kept: tuple[tuple[int, float], ...] = ()


class Allocator:
    """Control allocation for the fins of a vehicle. Has no memory; `size` is the number of fins."""

    def __init__(self, vehicle: Vehicle) -> None:
        effectiveness = vehicle.effectiveness
        self.size = len(vehicle.fins)
        self._s, self._r = effectiveness.s, effectiveness.r
        self._limits = tuple(fin.delta_max for fin in vehicle.fins)
        self._coupled = any(a * b != 0.0 for a, b in zip(self._s, self._r, strict=True))
        self._sound = self._layout(())
        self._last: tuple[tuple[FinHealth, ...], _Layout] = (), self._sound

    def allocate(self, demand: Demand, left: tuple[FinHealth, ...] = ()) -> FinCommand:
        """Return one angle (rad) per fin, within its limit, and the propeller speed as demanded.

        A demand that is not finite gives angles that are not finite; the gate rejects them.

        Args:
            demand: delta_s and delta_r, rad.
            left: what is left of each fin; empty: all are sound.
        """
        delta_s, delta_r = demand.delta_s, demand.delta_r
        sound = tuple([from_s * delta_s + from_r * delta_r for from_s, from_r in self._sound.gains])
        if left is not self._last[0] and left != self._last[0]:  # what is computed depends on `left` alone
            self._last = left, self._layout(left)
        layout = self._last[1]
        if layout is self._sound:
            angles = list(sound)
        else:
            angles = [clip(angle, -most, most) for angle, most in zip(sound, self._limits, strict=True)]
            for i, angle in layout.kept:
                angles[i] = clip(angle, -self._limits[i], self._limits[i])
            rest_s, rest_r = delta_s - layout.stuck_s, delta_r - layout.stuck_r
            for i, (from_s, from_r) in zip(layout.free, layout.gains, strict=True):
                angles[i] = from_s * rest_s + from_r * rest_r
        for i in layout.free:
            if not -self._limits[i] <= angles[i] <= self._limits[i]:
                angles = self._redistribute(layout, angles, delta_s, delta_r)
                break
        if self._coupled and layout is not self._sound:
            self._put_pitch_first(layout, angles, delta_s)
        return FinCommand(tuple(angles), demand.n)

    def _layout(self, left: tuple[FinHealth, ...]) -> _Layout:
        """Return the layout that is left."""
        if all(fin.effect == 1.0 and not fin.is_stuck for fin in left):
            if left:
                return self._sound
            fins = range(self.size)
            gains = _pseudo_inverse(self._s, self._r, self._limits)
            return _Layout(self._s, self._r, tuple(fins), tuple(gains), 0.0, 0.0)
        free = tuple([i for i, fin in enumerate(left) if not fin.is_stuck])
        s, r = (_weighted(row, left, free) for row in (self._s, self._r))
        stuck = [fin.stuck if fin.is_stuck else 0.0 for fin in left]
        gains = _pseudo_inverse(*([row[i] for i in free] for row in (s, r, self._limits)))
        kept = tuple(
            [(i, fin.stuck) for i, fin in enumerate(left) if fin.is_stuck and fin.source is FinEvidence.MOTION]
        )
        return _Layout(s, r, free, tuple(gains), _dot(self._s, stuck), _dot(self._r, stuck), kept)

    def _redistribute(self, layout: _Layout, unlimited: Sequence[float], delta_s: float, delta_r: float) -> list[float]:
        """Hold each fin beyond its limit there and allocate the remainder to the free fins, until none is beyond."""
        angles, free, limits = list(unlimited), layout.free, self._limits
        held = [0.0] * self.size
        while saturated := [i for i in free if not -limits[i] <= angles[i] <= limits[i]]:
            for i in saturated:
                angles[i] = held[i] = clip(angles[i], -limits[i], limits[i])
            free = tuple([i for i in free if i not in saturated])
            rest_s = delta_s - layout.stuck_s - _dot(layout.s, held)
            rest_r = delta_r - layout.stuck_r - _dot(layout.r, held)
            gains = _pseudo_inverse(*[[row[i] for i in free] for row in (layout.s, layout.r, limits)])
            for i, (from_s, from_r) in zip(free, gains, strict=True):
                angles[i] = from_s * rest_s + from_r * rest_r
        return angles

    def _put_pitch_first(self, layout: _Layout, angles: list[float], delta_s: float) -> None:
        """Move fins towards the ends of their travel until delta_s is made, each by the same share of its way there."""
        unmade = delta_s - layout.stuck_s - sum([layout.s[i] * angles[i] for i in layout.free])
        if abs(unmade) <= _MADE:
            return
        ends = [(i, math.copysign(self._limits[i], unmade * layout.s[i])) for i in layout.free if layout.s[i]]
        most = sum([layout.s[i] * (end - angles[i]) for i, end in ends])
        share = min(unmade / most, 1.0) if most else 0.0
        for i, end in ends:
            angles[i] = clip(angles[i] + share * (end - angles[i]), -self._limits[i], self._limits[i])


def _weighted(row: _Row, left: Sequence[FinHealth], free: Sequence[int]) -> _Row:
    """Return the effects of fins that are not alike; those that move have together what they would have sound."""
    whole = sum([abs(row[i]) for i in free])
    part = sum([abs(row[i]) * left[i].effect for i in free])
    if not part > 0.0:
        return row
    return tuple([a * fin.effect * (whole / part) for a, fin in zip(row, left, strict=True)])


def _pseudo_inverse(s: Sequence[float], r: Sequence[float], limits: Sequence[float]) -> list[tuple[float, float]]:
    """Return W^-1 B' (B W^-1 B')^-1, shape (number of fins, 2), for B = (s, r) and W = diag(1 / limit^2).

    Each row is one fin's gain from delta_s and from delta_r. A singular B W^-1 B' is regularised.
    """
    weights = [limit * limit for limit in limits]
    ss = sum([w * a * a for w, a in zip(weights, s, strict=True)])
    rr = sum([w * a * a for w, a in zip(weights, r, strict=True)])
    sr = sum([w * a * b for w, a, b in zip(weights, s, r, strict=True)])
    if (ss * rr - sr * sr) <= _REGULARISATION * (ss + rr) ** 2:
        shift = _REGULARISATION * (ss + rr) or 1.0
        ss, rr = ss + shift, rr + shift
    det = ss * rr - sr * sr
    return [(w * (rr * a - sr * b) / det, w * (ss * b - sr * a) / det) for w, a, b in zip(weights, s, r, strict=True)]


def _dot(row: Sequence[float], fins: Sequence[float]) -> float:
    return sum([a * angle for a, angle in zip(row, fins, strict=True)])
