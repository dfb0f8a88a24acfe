"""Stern plane and rudder to the fins of any layout, and back.

The fins d are the smallest that give what is asked, each measured against its travel: they minimise
sum (d / delta_max)^2 under s . d = delta_s, r . d = delta_r (Fossen 2011, ch. 12.3). Where that asks a fin for more
than its travel, it stays at its limit and the others share what is left (cascaded generalised inverse, Bordignon 1996).
"""

from __future__ import annotations

from collections.abc import Sequence

from firmware_py.marine import clip
from firmware_py.records.command import Demand, FinCommand
from firmware_py.vehicle.vehicle import Vehicle

_REGULAR = 1e-9
"""Relative regularisation: fins that are left and pull along one line only still have a least-squares answer."""


class Allocator:
    """Has no memory. `size` is the number of fins."""

    def __init__(self, vehicle: Vehicle) -> None:
        effect = vehicle.effectiveness
        self.size = len(vehicle.fins)
        self._s, self._r = effect.s, effect.r
        self._limits = tuple(fin.delta_max for fin in vehicle.fins)
        self._inverse = _inverse(self._s, self._r, self._limits)
        self._rows = tuple((*pair, limit) for pair, limit in zip(self._inverse, self._limits, strict=True))

    def allocate(self, demand: Demand) -> FinCommand:
        """One angle (rad) per fin, never beyond its travel; a demand that is not finite gives angles that are not."""
        delta_s, delta_r = demand.delta_s, demand.delta_r
        fins = tuple([from_s * delta_s + from_r * delta_r for from_s, from_r, _ in self._rows])
        for angle, limit in zip(fins, self._limits, strict=True):
            if angle > limit or angle < -limit:
                return FinCommand(self._redistribute(fins, delta_s, delta_r), demand.n)
        return FinCommand(fins, demand.n)

    def effective(self, fins: Sequence[float]) -> tuple[float, float]:
        """The way back: (delta_s, delta_r), rad, that fin angles (rad, one per fin) are worth."""
        return _dot(self._s, fins), _dot(self._r, fins)

    def _redistribute(self, asked: tuple[float, ...], delta_s: float, delta_r: float) -> tuple[float, ...]:
        angles = list(asked)
        free = set(range(self.size))
        while over := {i for i in free if not -self._limits[i] <= angles[i] <= self._limits[i]}:
            for i in over:
                angles[i] = clip(angles[i], -self._limits[i], self._limits[i])
            free -= over
            held = [0.0 if i in free else angle for i, angle in enumerate(angles)]
            left_s, left_r = delta_s - _dot(self._s, held), delta_r - _dot(self._r, held)
            order = sorted(free)
            inverse = _inverse(*([row[i] for i in order] for row in (self._s, self._r, self._limits)))
            for i, (from_s, from_r) in zip(order, inverse, strict=True):
                angles[i] = from_s * left_s + from_r * left_r
        return tuple(angles)


def _inverse(s: Sequence[float], r: Sequence[float], limits: Sequence[float]) -> list[tuple[float, float]]:
    """W^-1 B' (B W^-1 B')^-1 for the rows B = (s, r): one (from delta_s, from delta_r) per fin."""
    weights = [limit * limit for limit in limits]
    ss = sum(w * a * a for w, a in zip(weights, s, strict=True))
    rr = sum(w * a * a for w, a in zip(weights, r, strict=True))
    sr = sum(w * a * b for w, a, b in zip(weights, s, r, strict=True))
    if (ss * rr - sr * sr) <= _REGULAR * (ss + rr) ** 2:
        slack = _REGULAR * (ss + rr) or 1.0
        ss, rr = ss + slack, rr + slack
    det = ss * rr - sr * sr
    return [(w * (rr * a - sr * b) / det, w * (ss * b - sr * a) / det) for w, a, b in zip(weights, s, r, strict=True)]


def _dot(row: Sequence[float], fins: Sequence[float]) -> float:
    return sum([a * angle for a, angle in zip(row, fins, strict=True)])
