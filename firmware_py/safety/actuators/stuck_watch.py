"""Fins of one axis that report no angle: does one of them stay where it is, and where?

A fin that stays makes a constant moment in place of its own. Beside the filter of the rate of turn in which all fins
move (`vehicle.turning`) runs one with such a moment of unknown size, which begins from the first one's state whenever
nothing speaks for it, so that the sum of their log-likelihood ratios is Page's cumulative sum. A gust is a constant
moment too; what tells it from a fin that stays is that the fin's commands show on. So a third filter with a constant
moment beside fins that all move begins at the same time, and has to be worse by far. As in `share_watch` there are
these filters for each strength of eddies that there may be, and sound fins in all of these have to be as much worse.

The moment tells the angle, together with what the disturbance has become since the fin was sound: what the filters took
for eddies before anything spoke for a fault. Fins that act alike are told apart by being told different things, so the
first of them is taken for stuck, and it is the other one if that explains better what then happens.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.marine import EDDY_TIME, clip
from firmware_py.safety.actuators.hull_response import SUSPECT
from firmware_py.safety.actuators.offset_filter import PRIOR_STD, Offset, Step, begin_offset, follow_offset
from firmware_py.safety.actuators.share_watch import EDDIES, ENOUGH
from firmware_py.vehicle.turning import GYRO_STD, Follower, follow, stationary_gains

_OVER, _OTHER = 1.0, 0.5
"""Times the evidence of `safety.actuators.evidence`: that it is no gust; that another fin stays."""
_LEAST_TIME = 0.6
"""What has spoken for a change for a shorter time, s, is chance."""
_CLIP = 4.0
"""No step counts for more, nats."""
_DOUBT = 3.0
"""With so much evidence, nats, a fin may stay already."""
_SETTLING_TIME, _VARIANCE_TIME, _USUAL_TIME = 2.0, 10.0, 30.0
_REFINING = 10.0
"""So long after it was named a stuck fin's angle is still estimated, s."""
_AT_LEAST = 1.0
"""What was estimated when it was named counts like the estimates of so long a time, s."""
_STEP = math.radians(0.5)
"""Estimates that differ by less are one angle."""


class Stays(NamedTuple):
    """That a fin stays.

    Attributes:
        fin: the filter.
        evidence: against sound fins in the same eddies, nats.
        gust: the filter of a gust beside sound fins, which began at the same time.
        over: evidence since then against that, and against sound fins in each of the eddies, nats.
        lasts: since when, s.
    """

    fin: Offset
    evidence: float
    gust: Offset
    over: tuple[float, ...]
    lasts: float

    @property
    def least(self) -> float:
        """Return the evidence against the best of what else there may be, nats."""
        return min(self.evidence, *self.over)


class StuckMember(NamedTuple):
    """The filters for one strength of eddies.

    Attributes:
        follower: of sound fins alone.
        stays: by fin.
        usual: disturbance while nothing speaks for a fault, rad/s^2.
    """

    follower: Follower
    stays: tuple[Stays, ...]
    usual: float


class StuckMemory(NamedTuple):
    """What is remembered.

    Attributes:
        fin: index of the fin that stays; -1: none.
        angle: where, rad.
        mean: that angle as last estimated, the mean over the time since it was named, rad.
        members: by eddies.
        variance: running mean of the least innovation squared over what the filters expect.
        running: how long the filters have run, s.
        since: how long the fin has been known, s.
        member: index of the filters by which it is known.
    """

    fin: int
    angle: float
    mean: float
    members: tuple[StuckMember, ...]
    variance: float
    running: float
    since: float
    member: int


_FRESH = StuckMemory(-1, math.nan, math.nan, (), 1.0, 0.0, 0.0, 0)


class StuckWatch:
    """Judges the fins of one axis that report nothing; `update` once a `dt`, s."""

    def __init__(self, evidence: float, eddies: float, dt: float, members: Sequence[float] = EDDIES) -> None:
        """Design the filters; arguments as those of `ShareWatch`."""
        self._evidence, self._dt, self._shares = evidence, dt, members
        self._noise = GYRO_STD**2 * 0.01 / dt
        self._memory = _FRESH
        self.design(eddies)

    def design(self, eddies: float) -> None:
        """Design the filters for other eddies; what they know is kept."""
        walks = [share * eddies for share in self._shares]
        self._walks = tuple([walk * walk * self._dt for walk in walks])
        self._gains = tuple([stationary_gains(walk, self._dt) for walk in walks])

    @property
    def stuck(self) -> tuple[int, float]:
        """Return which fin of the axis stays, -1 if none does, and at which angle, rad."""
        return self._memory.fin, self._memory.angle

    @property
    def suspects(self) -> bool:
        """Return whether something speaks for a fault by now, or one is known."""
        return self._memory.fin >= 0 or any(
            s.evidence > SUSPECT * ENOUGH * self._evidence for m in self._memory.members for s in m.stays
        )

    @property
    def doubt(self) -> float:
        """Return for how long it has been more likely than all else that a fin stays, or known, s; 0: it is not."""
        m = self._memory
        if m.fin >= 0:
            return m.since + _LEAST_TIME
        least = SUSPECT * _OVER * self._evidence
        return max([s.lasts for member in m.members for s in member.stays if s.least > least], default=0.0)

    def pause(self) -> None:
        """Stop where nothing can be judged; what was found is kept."""
        if self._memory.running:
            self._memory = self._memory._replace(members=(), running=0.0)

    def forget(self) -> None:
        """Take back what was found: the fins report."""
        if self._memory is not _FRESH:
            self._memory = _FRESH

    def update(
        self,
        rate: float,
        damping: float,
        hull: float,
        units: Sequence[float],
        angles: Sequence[float],
        mute: Sequence[int],
    ) -> bool:
        """Return whether another fin stays, or at another angle, after one more step.

        Args:
            rate: mean of the measured rate of turn over the step, rad/s.
            damping: of the rate, 1/s, negative.
            hull: known angular acceleration but for the fins', rad/s^2.
            units: angular acceleration by the angle of each fin of the axis, 1/s^2.
            angles: of each, as it reports or as it was told, rad.
            mute: indices of those that report nothing.
        """
        m, dt = self._memory, self._dt
        fins = hull + sum([unit * angle for unit, angle in zip(units, angles, strict=True)])
        if not m.running or len(m.members[0].stays) != len(mute):
            begun = [tuple([self._begun((rate, 0.0), gains, angles[fin]) for fin in mute]) for gains in self._gains]
            members = tuple([StuckMember((rate, 0.0), stays, 0.0) for stays in begun])
            self._memory = m._replace(members=members, running=dt)
            return False
        step = Step(rate, damping, self._noise, m.variance, dt)
        settled, over, found = m.running >= _SETTLING_TIME, -_OVER * self._evidence, []
        followed, bases, squares = [], [], []
        for member, gains in zip(m.members, self._gains, strict=True):
            e, follower = follow(member.follower, gains, rate, damping, fins, dt)
            followed.append(follower)
            squares.append(e * e * (1.0 - gains[0]) / self._noise)
            bases.append(0.5 * (squares[-1] / m.variance + math.log(self._noise / (1.0 - gains[0]))))
        for i, (member, gains, walk) in enumerate(zip(m.members, self._gains, self._walks, strict=True)):
            stays = []
            for fin, was in zip(mute, member.stays, strict=True):
                unit, own = units[fin], units[fin] * angles[fin]
                gust, blown = follow_offset(was.gust, step, fins, unit, walk)
                offset, loss = follow_offset(was.fin, step, fins - own, unit, walk)
                against = zip(was.over, (blown, *bases), strict=True)
                now = Stays(
                    offset,
                    was.evidence + clip(bases[i] - loss, -_CLIP, _CLIP),
                    gust,
                    tuple([before + clip(other - loss, -_CLIP, _CLIP) for before, other in against]),
                    was.lasts + dt,
                )
                holds = settled and now.evidence > 0.0 and now.least > over
                stays.append(now if holds or m.fin >= 0 else self._begun(followed[i], gains, angles[fin]))
            found.append(StuckMember(followed[i], tuple(stays), member.usual))
        if settled and not _doubts(found):
            share = dt / min(_USUAL_TIME, m.running)
            found = [one._replace(usual=one.usual + share * (one.follower[1] - one.usual)) for one in found]
        variance = m.variance
        if settled and m.fin < 0:
            variance = max(1.0, variance + (min(squares) - variance) * (dt / _VARIANCE_TIME))
        self._memory = m = m._replace(members=tuple(found), variance=variance, running=m.running + dt)
        return self._named(m, units, mute) if m.fin < 0 else self._refined(m, units, mute)

    def freeze(self) -> StuckMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: StuckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _named(self, m: StuckMemory, units: Sequence[float], mute: Sequence[int]) -> bool:
        """Return whether a fin is found to stay, where none was."""
        enough, over = ENOUGH * self._evidence, _OVER * self._evidence
        found = [
            (stays.least, i, -k)
            for i, member in enumerate(m.members)
            for k, stays in enumerate(member.stays)
            if stays.evidence >= enough and stays.least >= over and stays.lasts >= _LEAST_TIME
        ]
        if not found:
            return False
        _, i, k = max(found)
        self._memory = m = m._replace(fin=mute[-k], since=0.0, member=i)
        angle = self._angle(m, -k, units[mute[-k]])
        self._memory = m._replace(angle=angle, mean=angle)
        return True

    def _refined(self, m: StuckMemory, units: Sequence[float], mute: Sequence[int]) -> bool:
        """Return whether the angle of the fin that stays is another one, or it is another fin."""
        since, member = m.since + self._dt, m.members[m.member]
        self._memory = m = m._replace(since=since)
        if m.fin not in mute:
            return False
        now, evidence = mute.index(m.fin), [s.evidence for s in member.stays]
        k = max(range(len(mute)), key=lambda i: evidence[i])
        if evidence[k] - evidence[now] < _OTHER * self._evidence:
            k = now
            if since > _REFINING:
                return False
        mean = m.mean + (self._angle(m, k, units[mute[k]]) - m.mean) * (self._dt / max(since, _AT_LEAST))
        self._memory = m = m._replace(mean=mean)
        if k == now and abs(mean - m.angle) < _STEP:
            return False
        self._memory = m._replace(fin=mute[k], angle=mean)
        return True

    def _angle(self, m: StuckMemory, k: int, unit: float) -> float:
        """Return the angle that explains the constant moment, and what the disturbance has become beside it.

        Of the latter eddies may be a part: as much as they are stronger than what a fin may make.
        """
        member = m.members[m.member]
        fin, eddies, makes = member.stays[k].fin, 0.5 * EDDY_TIME * self._walks[m.member] / self._dt, unit * PRIOR_STD
        share = makes * makes / (makes * makes + eddies)
        return fin.angle + share * (fin.disturbance - member.usual) / unit

    def _begun(self, follower: Follower, gains: tuple[float, float], angle: float) -> Stays:
        """Return filters that begin with what sound fins make of the motion, one of them at `angle`."""
        begin = functools.partial(begin_offset, follower, gains, self._noise, self._dt)
        fin, gust = begin(angle), begin(0.0)
        return Stays(fin, 0.0, gust, (0.0,) * (1 + len(self._gains)), 0.0)


def _doubts(members: Sequence[StuckMember]) -> bool:
    """Return whether a fin may stay by now, so that the disturbance is not the usual one."""
    return any(s.evidence > _DOUBT and s.least > -_DOUBT for m in members for s in m.stays)
