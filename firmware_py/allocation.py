"""Control allocation: delta_s and delta_r to the fins of any layout.

The fin angles d minimise sum (d / delta_max)^2 under s . d = delta_s and r . d = delta_r (weighted pseudo-inverse;
Fossen 2011, ch. 12.3). A fin that would exceed its limit is held there, and the others share the remainder (cascaded
generalised inverse; Bordignon 1996).
"""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.marine import clip
from firmware_py.records.command import Demand, FinCommand
from firmware_py.vehicle.vehicle import Vehicle

_REGULARISATION = 1e-9
"""Relative; the free fins may all act along one line, which still has a least-squares solution."""


class Allocator:
    """Control allocation for the fins of a vehicle. Has no memory; `size` is the number of fins."""

    def __init__(self, vehicle: Vehicle) -> None:
        effectiveness = vehicle.effectiveness
        self.size = len(vehicle.fins)
        self._s, self._r = effectiveness.s, effectiveness.r
        self._limits = tuple(fin.delta_max for fin in vehicle.fins)
        self._gains = _pseudo_inverse(self._s, self._r, self._limits)

    def allocate(self, demand: Demand) -> FinCommand:
        """Return one angle (rad) per fin, within its limit, and the propeller speed as demanded.

        A demand that is not finite gives angles that are not finite; the gate rejects them.
        """
        delta_s, delta_r = demand.delta_s, demand.delta_r
        angles = tuple([from_s * delta_s + from_r * delta_r for from_s, from_r in self._gains])
        for angle, limit in zip(angles, self._limits, strict=True):
            if angle > limit or angle < -limit:
                return FinCommand(self._redistribute(angles, delta_s, delta_r), demand.n)
        return FinCommand(angles, demand.n)

    def _redistribute(self, unlimited: tuple[float, ...], delta_s: float, delta_r: float) -> tuple[float, ...]:
        """Hold each fin beyond its limit there and allocate the remainder to the free fins, until none is beyond."""
        angles = list(unlimited)
        free = set(range(self.size))
        while saturated := {i for i in free if not -self._limits[i] <= angles[i] <= self._limits[i]}:
            for i in saturated:
                angles[i] = clip(angles[i], -self._limits[i], self._limits[i])
            free -= saturated
            held = [0.0 if i in free else angle for i, angle in enumerate(angles)]
            rest_s, rest_r = delta_s - _dot(self._s, held), delta_r - _dot(self._r, held)
            fins = sorted(free)
            gains = _pseudo_inverse(*([row[i] for i in fins] for row in (self._s, self._r, self._limits)))
            for i, (from_s, from_r) in zip(fins, gains, strict=True):
                angles[i] = from_s * rest_s + from_r * rest_r
        return tuple(angles)


def _pseudo_inverse(s: Sequence[float], r: Sequence[float], limits: Sequence[float]) -> list[tuple[float, float]]:
    """Return W^-1 B' (B W^-1 B')^-1, shape (number of fins, 2), for B = (s, r) and W = diag(1 / limit^2).

    Each row is one fin's gain from delta_s and from delta_r. A singular B W^-1 B' is regularised.
    """
    weights = [limit * limit for limit in limits]
    ss = sum(w * a * a for w, a in zip(weights, s, strict=True))
    rr = sum(w * a * a for w, a in zip(weights, r, strict=True))
    sr = sum(w * a * b for w, a, b in zip(weights, s, r, strict=True))
    if (ss * rr - sr * sr) <= _REGULARISATION * (ss + rr) ** 2:
        shift = _REGULARISATION * (ss + rr) or 1.0
        ss, rr = ss + shift, rr + shift
    det = ss * rr - sr * sr
    return [(w * (rr * a - sr * b) / det, w * (ss * b - sr * a) / det) for w, a, b in zip(weights, s, r, strict=True)]


def _dot(row: Sequence[float], fins: Sequence[float]) -> float:
    return sum([a * angle for a, angle in zip(row, fins, strict=True)])
