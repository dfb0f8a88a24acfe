"""Fins whose angle, or effect, is in doubt: what the filter takes for them is not known exactly, or is no longer so.

Where the gyros contradict the filter, fins were damaged a moment ago: what they make becomes uncertain
(`filter.boost`). What was learned since is wrong in everything, which no boost makes uncertain: half a rudder that
nobody knew of made the added mass 5 sigma wrong, and all of yaw with it. So the filter begins with what was known
before, and its motion anew.

The motion says also of fins that they are weak where strong eddies, which the filter holds for likely then, explain it
all to the filter, and much later. Since when nobody can tell, so nothing of the axis counts as known, nor of what the
flight told by the way: added mass, drag. The fins of both axes are uncertain by a boost besides: planes that were taken
for sound spoilt what was learned anew of the rudders.

A fin that reports no angle and obeys is off by its servo's lag and play (`vehicle.servo`). One that stays somewhere is
off by as much as it can turn, and what it makes then looks as if the others of its axis had lost their effect, or
turned it round: within two seconds M_ds was 80 % off. So the angle of an axis whose fins report nothing has a variance,
which is process noise along what they drive. While something speaks for a fin that stays
(`safety.actuators.stuck_watch`; or the gyros contradict the filter, and who could tell whether by the fin's effect or
its angle?) that of an unknown angle counts, the coefficients of the axis are held, and they are what they were before
it began to.

So it is where fins act on both axes, as those of an X tail, and some are weak: if one is lost, the others pitch the
vehicle when they turn it, which no coefficient says, and all that is learned is wrong then (N_v by 59 sigma).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.estimation.coefficient_ekf import CoefficientEkf
from firmware_py.estimation.filter.bank_arrays import Constants
from firmware_py.estimation.filter.boost import FINS
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
_FRUITLESS = 3
"""Contradicted so many times more, and confirmed never between, what is known is not what was damaged."""
_EVERY, _MOST = 1.0, 20
"""What is known is kept so often, s, and so many times."""


class Known(NamedTuple):
    """What was known at t, s, and which coefficients a pass had confirmed."""

    t: float
    constants: Constants
    iterated: tuple[bool, ...]


class DoubtedMemory(NamedTuple):
    """What is remembered, by axis: planes, rudders.

    Attributes:
        std: 1 sigma of the axis' fin angle, rad, beside what reports leave.
        held: whether its coefficients are held.
        until: when what the gyros contradicted is over, s.
        known: what was known, the oldest first.
        bursts: how often the gyros had contradicted the filter then.
        turning: by fin, mean square of how fast it turns, (rad/s)^2; empty: not known yet.
        last: when that was updated, s.
        weak: whether the filter was told that the axis' fins are weak.
        fruitless: how often the filter has gone back, one time after another, without a pass that took over between.
        accepted: how many passes had taken over when it last went back.
    """

    std: tuple[float, ...]
    held: tuple[bool, ...]
    until: tuple[float, ...]
    known: tuple[Known, ...]
    bursts: int
    turning: tuple[float, ...]
    last: float
    weak: tuple[bool, ...] = (False, False)
    fruitless: int = 0
    accepted: int = 0


_NEVER = (-math.inf, -math.inf)
_FRESH = DoubtedMemory((0.0, 0.0), (False, False), _NEVER, (), 0, (), -math.inf)


class DoubtedFins:
    """Tells a filter how well the angles of fins are known; `update` at a steady rate."""

    def __init__(self, ekf: CoefficientEkf, vehicle: Vehicle) -> None:
        self._ekf, self._rows, self._memory = ekf, vehicle.deflection_rows[:2], _FRESH
        self._anywhere = [
            max(abs(share) * fin.delta_max for share, fin in zip(row, vehicle.fins, strict=True)) / math.sqrt(3.0)
            for row in self._rows
        ]
        """1 sigma of an axis' fin angle where one of its fins may be anywhere, rad."""
        self._crossed = vehicle.fins_crossed

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
            Whether what was valid before bounds nothing any longer: other coefficients are held now, or fins are no
            longer what they were.
        """
        self._keep(t)
        m, ekf = self._memory, self._ekf
        silent = [any(share and off for share, off in zip(row, mute, strict=True)) for row in self._rows]
        changed, burst = False, ekf.bursts != m.bursts
        lame = self._crossed and any(doubt.weak for doubt in doubts)
        if any(silent) or lame or m.std != _FRESH.std:
            changed = self._follow_angles(t, silent, mute, rates, doubts, lame)
        elif burst:
            self._contradicted(t)
            changed = True
        return changed | self._follow_effect(t, doubts)

    def _contradicted(self, t: float) -> None:
        """Go back to what was known before the gyros contradicted the filter, or begin anew where that is in vain."""
        ekf, accepted = self._ekf, self._ekf.iteration.accepted
        fruitless = self._memory.fruitless + 1 if accepted == self._memory.accepted else 0
        self._memory = self._memory._replace(bursts=ekf.bursts, fruitless=fruitless, accepted=accepted)
        if fruitless < _FRUITLESS:
            self._go_back(t, 0.0)
            ekf.boost()
        else:
            self._memory = self._memory._replace(fruitless=0, known=())
            ekf.begin_anew()

    def _follow_angles(
        self,
        t: float,
        silent: Sequence[bool],
        mute: Sequence[bool],
        rates: Sequence[float],
        doubts: Sequence[AxisDoubt],
        lame: bool,
    ) -> bool:
        """Do what `update` does for fins that report nothing, on the axes that are `silent`, and for `lame` ones."""
        m, ekf = self._memory, self._ekf
        until = m.until
        if ekf.bursts != m.bursts:
            until = tuple([t + _CONTRADICTED if one else was for one, was in zip(silent, until, strict=True)])
        held = tuple(
            [
                lame or (one and (doubt.stays > 0.0 or t < end))
                for one, doubt, end in zip(silent, doubts, until, strict=True)
            ]
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
            return False
        begins = [now and not was for now, was in zip(held, m.held, strict=True)]
        if any(begins):
            stays = math.inf if lame else max(doubt.stays for doubt, b in zip(doubts, begins, strict=True) if b)
            self._go_back(t, stays, water=False)
            if ekf.bursts != m.bursts and not all(silent):
                ekf.boost(ekf.withheld)  # of those that report, which it took back
        return True

    def _follow_effect(self, t: float, doubts: Sequence[AxisDoubt]) -> bool:
        """Know nothing of an axis any longer whose fins are weak, once; while they are held, as soon as they are not.

        Returns:
            Whether that was done now.
        """
        m = self._memory
        weak = tuple([doubt.weak and (was or not h) for doubt, was, h in zip(doubts, m.weak, m.held, strict=True)])
        found = [letters for letters, now, was in zip(AXES, weak, m.weak, strict=True) if now and not was]
        if found:
            self._go_back(t, math.inf)
            self._ekf.forget("".join(found))
            self._ekf.boost(self._ekf.withheld)
        self._memory = self._memory._replace(weak=weak)
        return bool(found)

    def unlearn(self, t: float) -> None:
        """Know nothing of any axis: what was learned is of a sensor that lies."""
        self._go_back(t, math.inf)
        self._ekf.forget("".join(AXES))

    def forget(self) -> None:
        """Keep nothing of what was known: the filter begins anew."""
        self._memory = self._memory._replace(known=())

    def freeze(self) -> DoubtedMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: DoubtedMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
        self._tell()

    def _tell(self) -> None:
        std = self._memory.std
        self._ekf.withheld = tuple([fins for fins, off in zip(FINS, std, strict=False) if off > 0.0])
        for filters in self._ekf.banks:
            filters.doubt_fins(*std)

    def _keep(self, t: float) -> None:
        """Keep what is known, but while something is held; of what was known before the last confirmation, nothing."""
        m, iterated = self._memory, tuple(self._ekf.iterated.tolist())
        known = m.known if not m.known or m.known[-1].iterated == iterated else ()
        if not any(m.held) and (not known or t - known[-1].t >= _EVERY):
            known = (*known[1 - _MOST :], Known(t, self._ekf.bank.constants(), iterated))
        self._memory = m._replace(known=known)

    def _go_back(self, t: float, doubted: float, *, water: bool = True) -> None:
        """Know what was known before something spoke for a fault, for so long, s; `water` as in `CoefficientEkf`."""
        known = self._memory.known
        if known:
            before = [one for one in known if one.t <= t - doubted - _MARGIN]
            last = before[-1] if before else known[0]
            self._ekf.go_back(last.constants, water=water)
            self._memory = self._memory._replace(known=(last,))
