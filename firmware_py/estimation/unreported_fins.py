"""Fins that report no angle: what the filter takes for their angle is not known exactly, and at times not at all.

A fin that obeys is off by its servo's lag and play (`vehicle.servo`). One that stays somewhere is off by as much as it
can turn, and what it makes then looks as if the others of its axis had lost their effect, or turned it round: within
two seconds M_ds was 80 % off. So the angle of an axis whose fins report nothing has a variance, which is process noise
along what they drive. While something speaks for a fin that stays (`safety.actuators.stuck_watch`; or the gyros
contradict the filter, and who could tell whether by the fin's effect or its angle?) that of an unknown angle counts,
the coefficients of the axis are held, and they are what they were before it began to. Where the fins turn out to be
weak, it was their effect, which becomes uncertain then, as that of fins does that report (`filter.boost`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.filter.boost import FINS
from firmware_py.estimation.model.jacobians import Array
from firmware_py.records.health import AxisDoubt
from firmware_py.vehicle.servo import LAG_STD, PLAY_STD
from firmware_py.vehicle.vehicle import Vehicle

AXES = ("MZ", "NY")
"""First letters of the coefficients of planes and rudders."""
_CONTRADICTED = 10.0
"""So long after the gyros contradicted the filter a fin may stay, s: the next change of depth, or turn, names it."""
_MARGIN = 5.0
"""What was learned in so many s before something spoke for a fault is not believed either."""
_RATE_TIME = 10.0
"""How fast fins turn is a mean over so long, s."""
_EVERY, _MOST = 1.0, 20
"""What is known of the parameters is kept so often, s, and so many times."""


class Known(NamedTuple):
    """What was known of the parameters at t, s; see `BankArrays.parameters`."""

    t: float
    values: Array
    covariance: Array


class UnreportedMemory(NamedTuple):
    """What is remembered, by axis: planes, rudders.

    Attributes:
        std: 1 sigma of the axis' fin angle, rad, beside what reports leave.
        held: whether its coefficients are held.
        until: when what the gyros contradicted is over, s.
        known: what was known of the parameters, the oldest first.
        bursts: how often the gyros had contradicted the filter then.
        turning: by fin, mean square of how fast it turns, (rad/s)^2; empty: not known yet.
        last: when that was updated, s.
    """

    std: tuple[float, ...]
    held: tuple[bool, ...]
    until: tuple[float, ...]
    known: tuple[Known, ...]
    bursts: int
    turning: tuple[float, ...]
    last: float


_NEVER = (-math.inf, -math.inf)
_FRESH = UnreportedMemory((0.0, 0.0), (False, False), _NEVER, (), 0, (), -math.inf)


class UnreportedFins:
    """Tells a filter how well the angles of fins are known; `update` at a steady rate."""

    def __init__(self, ekf: CoefficientEkf, vehicle: Vehicle) -> None:
        self._ekf, self._rows, self._memory = ekf, vehicle.deflection_rows[:2], _FRESH
        self._anywhere = [
            max(abs(share) * fin.delta_max for share, fin in zip(row, vehicle.fins, strict=True)) / math.sqrt(3.0)
            for row in self._rows
        ]
        """1 sigma of an axis' fin angle where one of its fins may be anywhere, rad."""

    @property
    def held(self) -> tuple[bool, ...]:
        """Return whether what planes and rudders do is held, for one of them may stay somewhere."""
        return self._memory.held

    def holds(self, name: str) -> bool:
        """Return whether a coefficient is held."""
        return any(held and name[0] in letters for held, letters in zip(self._memory.held, AXES, strict=True))

    def update(self, t: float, mute: Sequence[bool], rates: Sequence[float], doubts: Sequence[AxisDoubt]) -> bool:
        """Tell the filter what has changed.

        Args:
            t: now, s.
            mute: by fin, whether it reports nothing.
            rates: by fin, how fast it turns if it obeys, rad/s.
            doubts: what the motion says of planes and rudders.

        Returns:
            Whether other coefficients are held now.
        """
        m, ekf = self._memory, self._ekf
        silent = [any(share and off for share, off in zip(row, mute, strict=True)) for row in self._rows]
        if not any(silent) and m.std == _FRESH.std:
            if ekf.bursts != m.bursts:
                self._memory = m._replace(bursts=ekf.bursts)
            return False
        until = m.until
        if ekf.bursts != m.bursts:
            until = tuple([t + _CONTRADICTED if one else was for one, was in zip(silent, until, strict=True)])
        held = tuple(
            [one and (doubt.stays > 0.0 or t < end) for one, doubt, end in zip(silent, doubts, until, strict=True)]
        )
        past = min(1.0, (t - m.last) / _RATE_TIME)
        turning = tuple([w + (r * r - w) * past for w, r in zip(m.turning or (0.0,) * len(rates), rates, strict=True)])
        variances = [off * (PLAY_STD**2 + LAG_STD**2 * w) for off, w in zip(mute, turning, strict=True)]
        std = tuple(
            [
                math.sqrt(sum(share * share * v for share, v in zip(row, variances, strict=True)) + far * far * unknown)
                for row, far, unknown in zip(self._rows, self._anywhere, held, strict=True)
            ]
        )
        self._memory = m._replace(std=std, held=held, until=until, bursts=ekf.bursts, turning=turning, last=t)
        self._tell()
        if held == m.held:
            self._keep(t)
            return False
        begins = [now and not was for now, was in zip(held, m.held, strict=True)]
        if any(begins):
            self._go_back(t, max(doubt.stays for doubt, begun in zip(doubts, begins, strict=True) if begun))
            if ekf.bursts != m.bursts and not all(silent):
                ekf.boost(ekf.withheld)  # of those that report, which it took back
        weak = [was and not now and doubt.weak for now, was, doubt in zip(held, m.held, doubts, strict=True)]
        if any(weak):
            ekf.boost([fins for fins, one in zip(FINS, (*weak, False), strict=True) if not one])
        return True

    def forget(self) -> None:
        """Keep nothing of what was known: the filter begins anew."""
        self._memory = self._memory._replace(known=())

    def freeze(self) -> UnreportedMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: UnreportedMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
        self._tell()

    def _tell(self) -> None:
        std = self._memory.std
        self._ekf.withheld = tuple([fins for fins, off in zip(FINS, std, strict=False) if off > 0.0])
        for filters in self._ekf.banks:
            filters.doubt_fins(*std)

    def _keep(self, t: float) -> None:
        m = self._memory
        if not any(m.held) and (not m.known or t - m.known[-1].t >= _EVERY):
            self._memory = m._replace(known=(*m.known[1 - _MOST :], Known(t, *self._ekf.bank.parameters())))

    def _go_back(self, t: float, doubted: float) -> None:
        """Know what was known before something spoke for a fault."""
        known = self._memory.known
        if known:
            before = [one for one in known if one.t <= t - doubted - _MARGIN]
            last = before[-1] if before else known[0]
            self._ekf.go_back(last.values, last.covariance)
            self._memory = self._memory._replace(known=(last,))
