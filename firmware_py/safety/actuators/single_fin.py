"""A fin that acts on both axes, as those of an X tail: is it the one of all that makes no force, or half of it?

A fin of an X that is lost takes its share of both moments: a quarter of what planes and rudders do, and from then on
planes turn the hull and rudders pitch it. No share of a whole axis does that. So each fin has a hypothesis that holds
for both axes: of an angle that makes the acceleration f of own = sum f, its axes keep a (own - kappa f), with kappa 1
(none left) or 1/2, against a own. How much all fins do, a, is known to 30 % only (`_SCALE_STD`), by axis and by either
hypothesis: so a vehicle file that errs is no fault of a fin, and what tells is that the axes are coupled.

With the innovations e of the filter for sound fins, and g_o, g_f of what it makes of own and f alone, e = (a - 1) g_o -
a kappa g_f + noise: sums of their products are all that a hypothesis needs, whatever a and kappa. Filter and sums of a
hypothesis begin anew whenever nothing speaks for it (Page); filters run for eddies of several strengths, as in
`share_watch`, and those that explain the last 20 s best decide.

Beside these one holds for all fins together, of which the same share of both axes is left: a fault of a whole axis is
none where fins are crossed, unless the other axis can agree (`whole`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.safety.actuators.hull_response import GUST_TIME, SUSPECT
from firmware_py.safety.actuators.share_watch import EDDIES, ENOUGH
from firmware_py.vehicle.turning import GYRO_STD, Follower, follow, stationary_gains

AXES = (0, 1)
"""Pitch and yaw."""
LOSSES = (0.5, 1.0)
"""What may be lost of a fin."""
_SCALE_STD = 0.3
"""1 sigma of what all fins of an axis do, of what the model says."""
_OVER = 3.0
"""So much, nats, must speak for a loss and against eddies of any strength that began just then."""
_PUSHED = 4.0
"""An innovation beyond both signatures by so many sigma is none that fins make."""
_MODEL_STD = 0.1
"""1 sigma of what the model is off by in a step, of what the fins do in it: flow across the hull, roll, lag, speed."""
_SETTLING_TIME, _SCORE_TIME, _VARIANCE_TIME = 2.0, 20.0, 10.0
"""As in `share_watch`, s."""
_LEAST = 0.4 * GYRO_STD**2 * 0.01

Sums = tuple[float, float, float, float, float]
"""Of e g_o, e g_f, g_o g_o, g_o g_f and g_f g_f, over the variance."""


class Step(NamedTuple):
    """One step of an axis.

    Attributes:
        rate: mean of the measured rate of turn, rad/s.
        damping: of the rate, 1/s, negative.
        restoring: angular acceleration by weight, and by turning in pitch, rad/s^2.
        hull: this with that of the crosswise flow.
        fins: what each fin would make if it were sound, rad/s^2; 0 where it is known lost.
    """

    rate: float
    damping: float
    restoring: float
    hull: float
    fins: Sequence[float]

    def at(self, faster: float) -> Step:
        """Return the step at so many times the speed."""
        hull = self.restoring + faster * (self.hull - self.restoring)
        fins = [faster * faster * one for one in self.fins]
        return Step(self.rate, faster * self.damping, self.restoring, hull, fins)


class Side(NamedTuple):
    """One axis of a hypothesis: what the filter makes of all fins and of this one, sums, and the costs at the start."""

    own: Follower = (0.0, 0.0)
    fin: Follower = (0.0, 0.0)
    sums: Sums = (0.0, 0.0, 0.0, 0.0, 0.0)
    costs: tuple[float, ...] = (0.0,) * len(EDDIES)


class Case(NamedTuple):
    """A hypothesis: both axes, the evidence for either loss, nats, and for how long some was there, s."""

    sides: tuple[Side, ...]
    evidence: tuple[float, ...] = (0.0,) * len(LOSSES)
    lasts: float = 0.0


class AxisFilters(NamedTuple):
    """The filters of sound fins of one axis, by eddies.

    Attributes:
        followers: their memory.
        scores: their log-likelihood over the last time, nats.
        costs: the same, over all time.
        variance: running mean of the least innovation squared, rad^2/s^2.
        running: how long they have run, s.
    """

    followers: tuple[Follower, ...] = ()
    scores: tuple[float, ...] = (0.0,) * len(EDDIES)
    costs: tuple[float, ...] = (0.0,) * len(EDDIES)
    variance: float = 0.0
    running: float = 0.0


class SingleMemory(NamedTuple):
    """What is remembered: the filters, by axis; the hypotheses, by eddies, of each fin and of all of them."""

    filters: tuple[AxisFilters, ...]
    cases: tuple[tuple[Case, ...], ...]


class Likeliest(NamedTuple):
    """What the motion says of single fins: the evidence for a loss of each, nats, and which loss.

    `sure` is whether it has lasted, for the best of them, and no eddies explain it.
    """

    evidence: tuple[float, ...]
    losses: tuple[float, ...]
    sure: bool


class SingleFin:
    """Lays steps of both axes before all hypotheses; `update` once a `dt`, s, for either axis."""

    def __init__(self, evidence: float, eddies: Sequence[float], fins: int, dt: float) -> None:
        """Design the filters.

        Args:
            evidence: log-likelihood ratio, nats, on which a fault rests.
            eddies: by axis, angular acceleration of the strongest eddies as a random walk, rad/s^2/sqrt(s).
            fins: how many there are.
            dt: step, s.
        """
        self.enough, self._dt, self._count = ENOUGH * evidence, dt, fins
        self._gains = [self._designed(one) for one in eddies]
        self._least = _LEAST / dt
        self.begin()

    def design(self, axis: int, eddies: float) -> None:
        """Design the filters of an axis for other eddies; what they know is kept."""
        self._gains[axis] = self._designed(eddies)

    def _designed(self, eddies: float) -> tuple[tuple[float, float], ...]:
        return tuple([stationary_gains(share * eddies, self._dt) for share in EDDIES])

    def begin(self) -> None:
        """Begin anew: nothing speaks for anything."""
        fresh = Case((Side(), Side()))
        self._filters = [AxisFilters(variance=self._least) for _ in AXES]
        self._cases = [[fresh] * (self._count + 1) for _ in EDDIES]

    def pause(self, axis: int) -> bool:
        """Stop where an axis cannot be judged; what it has told is forgotten. Return whether it told anything."""
        filters = self._filters[axis]
        if not filters.running:
            return False
        self._filters[axis] = filters._replace(running=0.0)
        for cases in self._cases:
            for i, case in enumerate(cases):
                cases[i] = self._weighed(i, case, self._restarted(case.sides, axis))
        return True

    def _restarted(self, sides: tuple[Side, ...], axis: int) -> tuple[Side, ...]:
        side = Side(costs=self._filters[axis].costs)
        return (side, sides[1]) if axis == 0 else (sides[0], side)

    def update(self, axis: int, step: Step, steady: bool) -> None:
        """Take one step of an axis, 0: pitch, 1: yaw; while the water is not `steady` nothing is laid to the fins."""
        rate, damping, _, hull, fins = step
        m, dt, table = self._filters[axis], self._dt, self._gains[axis]
        if not m.running:
            self._filters[axis] = m._replace(followers=((rate, 0.0),) * len(EDDIES), running=dt)
            return
        own, unit = sum(fins), 1.0 / max(m.variance, self._least)
        steps = [
            follow(one, gains, rate, damping, hull + own, dt) for one, gains in zip(m.followers, table, strict=True)
        ]
        spent = [0.5 * unit * e * e for e, _ in steps]
        running, variance, keep = m.running + dt, m.variance, 1.0 - dt / _SCORE_TIME
        settled = running >= _SETTLING_TIME
        if settled:
            variance += (min([e * e for e, _ in steps]) - variance) * (dt / _VARIANCE_TIME)
        self._filters[axis] = AxisFilters(
            tuple([after for _, after in steps]),
            tuple([keep * score - cost for score, cost in zip(m.scores, spent, strict=True)]),
            tuple([before + cost for before, cost in zip(m.costs, spent, strict=True)]),
            variance,
            running,
        )
        if not settled or self._filters[1 - axis].running < _SETTLING_TIME:  # one axis alone tells of no coupling
            return
        pushed = _PUSHED / math.sqrt(unit)
        for (e, _), gains, cases in zip(steps, table, self._cases, strict=True):
            for i, case in enumerate(cases):
                one = own if i == self._count else fins[i]
                side = case.sides[axis]
                unseen, after = follow(side.own, gains, 0.0, damping, own, dt)
                hidden, behind = follow(side.fin, gains, 0.0, damping, one, dt) if i < self._count else (unseen, after)
                sums = side.sums
                if steady and abs(e) <= abs(unseen) + abs(hidden) + pushed:
                    off = _MODEL_STD * (abs(unseen) + self._count * abs(hidden))
                    sums = _added(sums, e, -unseen, -hidden, unit / (1.0 + unit * off * off))
                now = Side(after, behind, sums, side.costs)
                cases[i] = self._weighed(i, case, (now, case.sides[1]) if axis == 0 else (case.sides[0], now))

    def _weighed(self, i: int, case: Case, sides: tuple[Side, ...]) -> Case:
        """Return a case with the evidence of its sums, or begun anew where nothing speaks for it."""
        weigh = _whole if i == self._count else _one_of_all
        evidence = tuple([sum([weigh(side.sums, loss) for side in sides]) for loss in LOSSES])
        most = max(evidence)
        if most <= 0.0:
            return Case(tuple([Side(costs=filters.costs) for filters in self._filters]))
        return Case(sides, evidence, case.lasts + 0.5 * self._dt if most > SUSPECT * self.enough else 0.0)

    @property
    def likeliest(self) -> Likeliest:
        """Return what is said of single fins in the likeliest eddies."""
        pitch, yaw = self._filters
        scores = [one + other for one, other in zip(pitch.scores, yaw.scores, strict=True)]
        best = scores.index(max(scores))
        cases = self._cases[best][: self._count]
        evidence = tuple([max(case.evidence) for case in cases])
        losses = tuple([LOSSES[case.evidence.index(max(case.evidence))] for case in cases])
        case = cases[evidence.index(max(evidence))]
        over = min([self._over(case, best, other) for other in range(len(EDDIES))])
        return Likeliest(evidence, losses, case.lasts >= GUST_TIME and over >= _OVER)

    @property
    def whole(self) -> float:
        """Return the evidence, nats, for a loss of all fins in both axes together; the greatest by any eddies."""
        return max([max(cases[-1].evidence) for cases in self._cases])

    def _over(self, case: Case, best: int, other: int) -> float:
        """Return what speaks for a case and against sound fins in other eddies since it began, nats."""
        more = [
            (filters.costs[other] - side.costs[other]) - (filters.costs[best] - side.costs[best])
            for filters, side in zip(self._filters, case.sides, strict=True)
        ]
        return max(case.evidence) + sum(more)

    def freeze(self) -> SingleMemory:
        """Return the whole memory."""
        return SingleMemory(tuple(self._filters), tuple([tuple(cases) for cases in self._cases]))

    def thaw(self, memory: SingleMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._filters, self._cases = list(memory.filters), [list(cases) for cases in memory.cases]


def _added(sums: Sums, e: float, own: float, fin: float, unit: float) -> Sums:
    a, b, c, d, f = sums
    return (
        a + unit * e * own,
        b + unit * e * fin,
        c + unit * own * own,
        d + unit * own * fin,
        f + unit * fin * fin,
    )


def _one_of_all(sums: Sums, loss: float) -> float:
    """Return the log-likelihood ratio of the loss of one fin against none, either with the best a, nats."""
    e_own, e_fin, own, both, fin = sums
    prior = _SCALE_STD**-2
    e_left = e_own - loss * e_fin + loss * (both - loss * fin)
    left = own - 2.0 * loss * both + loss * loss * fin
    return (
        0.5 * e_left * e_left / (left + prior) - 0.5 * e_own * e_own / (own + prior) - loss * (e_fin + 0.5 * loss * fin)
    )


def _whole(sums: Sums, loss: float) -> float:
    """Return that of the loss of so much of all fins against none, nats."""
    return -loss * (sums[0] + 0.5 * loss * sums[2])
