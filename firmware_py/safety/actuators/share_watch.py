"""How much of their effect the fins of one axis have left: all, half of it, none.

What sound fins do is known: by coefficients that held in flight. For each strength of eddies that there may be, two
filters of the rate of turn run side by side (`vehicle.turning`): one with the share that fins are believed to have, one
with another share, which begins from the first one's state whenever nothing speaks for it. So the sum of their
log-likelihood ratios is Page's cumulative sum for a change at an unknown time. That of the eddies which explain the
last 20 s best decides, if no other eddies that have just begun explain the motion better: where the water moves the
vehicle, nothing is laid to the fins.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.records.health import ActuatorFault
from firmware_py.safety.actuators.hull_response import GUST_TIME, HEALED, SUSPECT
from firmware_py.vehicle.turning import GYRO_STD, Follower, follow, stationary_gains

SHARES = (1.0, 0.5, 0.0)
"""What may be left; one of two fins that act alike is a half."""
LEFT = {ActuatorFault.NONE: 1.0, ActuatorFault.WEAK: 0.5, ActuatorFault.LOST: 0.0}
"""What each fault leaves."""
_OTHERS = ((1,), (0, 2), (0, 1))
"""Of each of these, which may follow: nothing is left only where half has been lost before."""
EDDIES = (0.1, 0.33, 0.67, 1.33)
"""Strengths of eddies, of those that the actuator watch is told to expect."""
ENOUGH = 4.0 / 3.0
"""Times the evidence of `safety.actuators.evidence`."""
_OVER = 3.0
"""So much, nats, must speak for a change and against eddies of any strength that have just begun."""
_PLAIN = 1.5
"""With so many times the evidence against eddies of any strength a loss counts whichever were the likeliest before."""
_HEALED_TIME = 10.0
"""Fins seldom heal: that more is left again needs such a time, s, too."""
_CLIP = 4.0
"""No step counts for more, nats."""
_SETTLING_TIME = 2.0
"""After a start the filters find the disturbance, s."""
_SCORE_TIME = 20.0
"""Over so long eddies are judged, s."""
_STALE_TIME = 5.0
"""What speaks for a change under eddies that are not the likeliest fades in this time, s."""
_VARIANCE_TIME = 10.0


class Change(NamedTuple):
    """A filter with another share; what speaks for it, and against each of the eddies instead, nats; how long, s."""

    follower: Follower
    evidence: float
    over: tuple[float, ...] = ()
    lasts: float = 0.0


class Member(NamedTuple):
    """The filters for one strength of eddies; `score` is their log-likelihood over the last time, nats."""

    follower: Follower
    score: float
    changes: tuple[Change, ...]


class ShareMemory(NamedTuple):
    """What is remembered.

    Attributes:
        left: index of the share that the fins have, in `SHARES`.
        members: by eddies.
        variance: running mean of the least innovation squared, rad^2/s^2.
        running: how long the filters have run, s.
    """

    left: int
    members: tuple[Member, ...]
    variance: float
    running: float


class ShareWatch:
    """Judges the fins of one axis; `update` once a `dt`, s."""

    gust_time = GUST_TIME
    """What has spoken for a change for a shorter time, s, may be a gust."""

    def __init__(self, evidence: float, eddies: float, dt: float, members: Sequence[float] = EDDIES) -> None:
        """Design the filters.

        Args:
            evidence: log-likelihood ratio, nats, on which a fault rests.
            eddies: angular acceleration of the strongest eddies as a random walk, rad/s^2/sqrt(s).
            dt: step, s.
            members: shares of these eddies for which filters run.
        """
        self._enough, self._dt, self._shares = ENOUGH * evidence, dt, members
        self.design(eddies)
        self._least = 0.4 * GYRO_STD**2 * 0.01 / dt
        self._memory = ShareMemory(0, (), self._least, 0.0)

    def design(self, eddies: float) -> None:
        """Design the filters for other eddies; what they know is kept."""
        self._gains = tuple([stationary_gains(share * eddies, self._dt) for share in self._shares])

    @property
    def left(self) -> float:
        """Return the share that the fins have left."""
        return SHARES[self._memory.left]

    @property
    def suspects(self) -> bool:
        """Return whether something speaks for a change by now."""
        return any(change.evidence > SUSPECT * self._enough for m in self._memory.members for change in m.changes)

    def pause(self) -> None:
        """Stop where nothing can be judged; what was found is kept."""
        if self._memory.running:
            self._memory = self._memory._replace(members=(), running=0.0)

    def begin(self, left: float) -> None:
        """Begin anew with a share that somebody else found."""
        self._memory = ShareMemory(SHARES.index(left), (), self._memory.variance, 0.0)

    def update(
        self, rate: float, damping: float, hull: float, fins: float, steady: bool = True, heals: bool = True
    ) -> bool:
        """Return whether the share is another one after one more step.

        Args:
            rate: mean of the measured rate of turn over the step, rad/s.
            damping: of the rate, 1/s, negative.
            hull: known angular acceleration but for the fins', rad/s^2.
            fins: angular acceleration that sound fins would make, rad/s^2.
            steady: whether the water is; while it changes nothing is laid to the fins.
            heals: whether `fins` is what they would make, and not the least of it, so that more may be left again.
        """
        m, dt = self._memory, self._dt
        others = _OTHERS[m.left]
        if not m.running:
            start = (rate, 0.0)
            members = tuple([Member(start, 0.0, (Change(start, 0.0),) * len(others)) for _ in self._gains])
            self._memory = m._replace(members=members, running=dt)
            return False
        settled, keep, stale = m.running >= _SETTLING_TIME, 1.0 - dt / _SCORE_TIME, 1.0 - dt / _STALE_TIME
        unit, known = 0.5 / max(m.variance, self._least), hull + SHARES[m.left] * fins
        best, top, found = 0, -float("inf"), []
        followed = [
            follow(member.follower, gains, rate, damping, known, dt)
            for gains, member in zip(self._gains, m.members, strict=True)
        ]
        squares = [e * e for e, _ in followed]
        least = min(squares)
        for i, (gains, member) in enumerate(zip(self._gains, m.members, strict=True)):
            now, square = followed[i][1], squares[i]
            score, changes = keep * member.score - unit * square, []
            if score > top:
                best, top = i, score
            for share, change in zip(others, member.changes, strict=True):
                e, after = follow(change.follower, gains, rate, damping, hull + SHARES[share] * fins, dt)
                evidence = change.evidence + clip(unit * (square - e * e), -_CLIP, _CLIP)
                if evidence > 0.0 and settled and steady and (heals or share > m.left):
                    before = change.over or (0.0,) * len(squares)
                    over = tuple([o + unit * (other - e * e) for o, other in zip(before, squares, strict=True)])
                    lasts = change.lasts + dt if evidence > SUSPECT * self._enough else 0.0
                    changes.append(Change(after, evidence, over, lasts))
                else:
                    changes.append(Change(now, 0.0))
            found.append((now, score, changes))
        members = tuple(
            [
                Member(now, score, tuple(changes if i == best else [_faded(c, stale) for c in changes]))
                for i, (now, score, changes) in enumerate(found)
            ]
        )
        variance = m.variance + (least - m.variance) * (dt / _VARIANCE_TIME) if settled else m.variance
        self._memory = ShareMemory(m.left, members, variance, m.running + dt)
        change, share = max(zip(found[best][2], others, strict=True), key=lambda one: one[0].evidence)
        better = share < m.left
        enough, time = (HEALED * self._enough, _HEALED_TIME) if better else (self._enough, self.gust_time)
        if change.evidence < enough or change.lasts < time or min(change.over) < _OVER:
            # a loss in still water makes strong eddies the likeliest, though they explain it worse
            plain = [
                (one.evidence, other)
                for _, _, changes in found
                for one, other in zip(changes, others, strict=True)
                if one.evidence >= self._enough
                and one.lasts >= self.gust_time
                and min(one.over) >= _PLAIN * self._enough
                if other > m.left
            ]
            if not plain:
                return False
            share = max(plain)[1]
        self.begin(SHARES[share])
        return True

    def freeze(self) -> ShareMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: ShareMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory


def _faded(change: Change, stale: float) -> Change:
    return Change(change.follower, stale * change.evidence, change.over, change.lasts)
