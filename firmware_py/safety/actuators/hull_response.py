"""How the vehicle turns, against its model: do the fins of an axis make the moment that they should?

A Kalman filter with constant gains follows the rate of turn under the fins' moment and a slow disturbance (eddies,
trim, errors of the model); its innovations are white. If the fins' effectiveness changes from 1 to s, these change by
(s - 1) times the signature, which is what the same filter makes of the fins alone. The matched filter is then a product
and a sum, and two cumulative sums of the log-likelihood ratio (Page's CUSUM) decide: no effectiveness against what
sound fins have at least, and half of it against the whole.

What sound fins have is learned in flight, so that a vehicle file that is wrong by half is no fault. What was learned in
the last 40 to 60 s does not count, for it may have been learned from a fault.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.health import ActuatorFault
from firmware_py.vehicle.turning import GYRO_STD, follow, stationary_gains

PERIOD = 0.04
"""Step of the filter, s."""
_LEARNING_TIME, _PRIOR_STD = 200.0, 0.3
_SNAPSHOT, _SNAPSHOTS = 20.0, 3
"""What was learned is noted so often, s; the oldest of so many notes counts."""
_VARIANCE_TIME = 10.0
_LEAST_VARIANCE = 0.4 * GYRO_STD**2 * 0.01 / PERIOD
"""Gyros may be quieter than this (rad^2/s^2, over a step); the model is not. When a fin begins to move, the vehicle
answers a little after its report, and against no noise at all that would be evidence."""
_PUSHED = 4.0
"""An innovation greater than the whole signature by so many sigma is none that fins make, whatever is left of them:
something else pushed the vehicle, as where a current begins. It tells nothing of them."""
_SETTLING_TIME = 2.0
"""After a start the filter finds the disturbance, s."""
_LEAST, _MOST = 0.3, 0.8
"""Bounds of the effectiveness that sound fins have at least."""
_SWIFTER, _SWIFTEST = 0.25, 4.0
"""Gains are designed for eddies that turn the vehicle up to so much more than at cruise, in such steps."""
_HALF = 0.5
_KNOWN = 0.75
"""WEAK is tested where sound fins have more than this share of what was learned, by 1 sigma."""
_WEAK = 2.0
"""WEAK needs so many times the evidence: errors of the model look like weak fins sooner than like none."""
HEALED = 2.0
"""So does the end of a fault: fins seldom heal."""
SUSPECT = 0.25
"""With this share of the evidence a fault is likely enough for nothing to be learned from it."""
GUST_TIME = 1.2
"""What has spoken for a fault for a shorter time, s, may be a gust."""
_FADING_TIME = 1.0
"""While the water changes it fades in this time, s."""
_PLAIN = 2.0
"""A fault that begins in a turn is a step, greater than its signature at first, and half of the fins look like none.
Where fins make more than so many sigma of an innovation in a step, what the filter takes for a disturbance tells."""
_FULL = 0.75
"""Fins beyond this share of their travel hold against something."""
_INERTIA_TIME, _TURNED = 3.0, math.radians(3.0)
"""They do so in vain if, so many seconds later, the vehicle turns the other way by so much."""


class AxisMemory(NamedTuple):
    """What is remembered of an axis.

    Attributes:
        fault: NONE, WEAK or LOST.
        rate: predicted rate of turn, rad/s.
        disturbance: angular acceleration that the model does not explain, rad/s^2.
        signature: what of `rate` is due to the fins, as the filter sees it, rad/s.
        explained: what of `disturbance` is.
        variance: running mean of the innovations squared, rad^2/s^2.
        product: forgetting sum of innovation times signature over variance.
        energy: forgetting sum of signature squared over variance.
        learned: (product, energy) of some time ago, the oldest first.
        lost: evidence for LOST, nats.
        weak: evidence for WEAK.
        good: evidence that a fault is over.
        running: how long the filter has run, s.
        held: how long the fins have been held over, s; its sign is the side.
        turned: how far the vehicle turned the other way, rad.
        prior: 1 sigma of what sound fins do, of what the model says, before anything is learned.
        suspected: how long a fault has been suspected, s.
    """

    fault: ActuatorFault
    rate: float
    disturbance: float
    signature: float
    explained: float
    variance: float
    product: float
    energy: float
    learned: tuple[tuple[float, float], ...]
    lost: float
    weak: float
    good: float
    running: float
    held: float
    turned: float
    prior: float
    suspected: float = 0.0


_FRESH = AxisMemory(
    ActuatorFault.NONE,
    0.0,
    0.0,
    0.0,
    0.0,
    GYRO_STD**2 * 0.01 / PERIOD,
    0.0,
    0.0,
    ((0.0, 0.0),),
    0.0,
    0.0,
    0.0,
    0.0,
    0.0,
    0.0,
    _PRIOR_STD,
)


class AxisWatch:
    """Judges the fins that act on one axis; `update` once a `dt`, s."""

    def __init__(self, evidence: float, eddies: float, dt: float) -> None:
        """Design the filter.

        Args:
            evidence: log-likelihood ratio at which a fault is named, nats.
            eddies: angular acceleration of the water at cruise as a random walk, rad/s^2/sqrt(s).
            dt: step, s.
        """
        self._evidence, self._dt = evidence, dt
        self._eddies, self._swell = eddies, 1.0
        self._gains = [
            stationary_gains((1.0 + i * _SWIFTER) * eddies, dt) for i in range(round((_SWIFTEST - 1.0) / _SWIFTER) + 1)
        ]
        self._snapshot = max(1.0, round(_SNAPSHOT / dt)) * dt
        self._memory = _FRESH

    def design(self, eddies: float) -> None:
        """Take the filter that is designed for other eddies; what it knows is kept."""
        self._swell = eddies / self._eddies if self._eddies else 1.0

    @property
    def fault(self) -> ActuatorFault:
        """What is wrong with the fins of the axis together: NONE, WEAK or LOST."""
        return self._memory.fault

    @property
    def suspects(self) -> bool:
        """Return whether something speaks for a fault by now."""
        return max(self._memory.lost, self._memory.weak / _WEAK) > SUSPECT * self._evidence

    def begin(self, prior: float, fault: ActuatorFault | None = None) -> None:
        """Begin anew with another model, which says what sound fins do with 1 sigma `prior` of it.

        `fault` is what is known of the fins; None: what was found.
        """
        m = self._memory
        self._memory = _FRESH._replace(fault=m.fault if fault is None else fault, variance=m.variance, prior=prior)

    def give_up(self) -> None:
        """Take the fins for LOST, as something else shows that they are."""
        self._memory = self._memory._replace(fault=ActuatorFault.LOST)

    def pause(self) -> None:
        """Stop where the model does not hold or nothing is measured; what was learned, and a fault, are kept."""
        m = self._memory
        if m.running or m.held:
            self._memory = _FRESH._replace(
                fault=m.fault,
                variance=m.variance,
                product=m.product,
                energy=m.energy,
                learned=m.learned,
                prior=m.prior,
            )

    def hold(self, rate: float, hull: float, fins: float, over: float) -> None:
        """Judge only whether the fins hold in vain, for the model is refuted: how much they do it does not tell.

        The arguments are those of `update`.
        """
        held, turned = self._held_in_vain(self._memory, rate, fins, over, fins + hull)
        self.pause()
        self._memory = self._memory._replace(held=held, turned=turned)
        if turned > _TURNED:
            self.give_up()

    def update(
        self,
        rate: float,
        damping: float,
        hull: float,
        fins: float,
        over: float,
        swift: float = 1.0,
        steady: bool = True,
        heals: bool = True,
    ) -> ActuatorFault:
        """Return the fault of the axis after one more step.

        Args:
            rate: mean of the measured rate of turn over the step, rad/s.
            damping: of the rate, 1/s, negative.
            hull: known angular acceleration but for the fins', rad/s^2.
            fins: angular acceleration that the fins should make, rad/s^2.
            over: share of what all fins could make at the ends of their travel.
            swift: how fast the vehicle is, of cruise: so much more do eddies turn it.
            steady: whether the water is; while it changes nothing is laid to the fins.
            heals: whether `fins` is what they should make, and not the least of it, so that a fault may be over.
        """
        m, dt, table = self._memory, self._dt, self._gains
        gains = table[min(max(0, math.ceil((swift * self._swell - 1.0) / _SWIFTER)), len(table) - 1)]
        if m.running == 0.0:
            self._memory = m._replace(rate=rate, running=dt)
            return m.fault
        e, after = follow((m.rate, m.disturbance), gains, rate, damping, hull + fins, dt)
        unseen, share = follow((m.signature, m.explained), gains, 0.0, damping, fins, dt)
        g = -unseen
        running = m.running + dt
        if running < _SETTLING_TIME:
            (rate, disturbance), (signature, explained) = after, share
            self._memory = m._replace(
                rate=rate, disturbance=disturbance, signature=signature, explained=explained, running=running
            )
            return m.fault

        variance = m.variance + (e * e - m.variance) * (dt / _VARIANCE_TIME)
        counted = max(variance, _LEAST_VARIANCE)
        eg, gg = e * g / counted, g * g / counted
        if not steady or abs(e) > abs(g) + _PUSHED * math.sqrt(counted):
            eg = gg = 0.0
        keep = 1.0 if steady else 1.0 - dt / _FADING_TIME
        fault, enough = m.fault, self._evidence
        weight = m.learned[0][1] + m.prior**-2
        usual, usual_std = 1.0 + m.learned[0][0] / weight, 1.0 / math.sqrt(weight)
        least = min(max(usual - usual_std, _LEAST), _MOST)
        lost, weak, good = m.lost, 0.0, 0.0
        if fault is not ActuatorFault.LOST:
            lost = max(0.0, keep * lost + _ratio(0.0, least if fault is ActuatorFault.NONE else _HALF * usual, eg, gg))
        if fault is not ActuatorFault.NONE:
            left = 0.0 if fault is ActuatorFault.LOST else _HALF * usual
            good = max(0.0, m.good + _ratio(usual, left, eg, gg)) if heals else m.good
        elif usual - usual_std > _KNOWN * usual:
            weak = max(0.0, keep * m.weak + _ratio(_HALF * usual, usual - usual_std, eg, gg))
        held, turned = self._held_in_vain(m, rate, fins, over, fins + hull)
        suspected = m.suspected + dt if max(lost, weak / _WEAK) > SUSPECT * enough else 0.0
        vain = turned > _TURNED and fault is not ActuatorFault.LOST
        if vain:
            lost, suspected = enough, GUST_TIME
        half = abs(after[1] - _HALF * usual * share[1]) < abs(after[1] - usual * share[1])
        halved = half and abs(share[1]) > _PLAIN * math.sqrt(counted) / dt
        sure = suspected >= GUST_TIME
        if (sure and (lost >= enough or weak >= _WEAK * enough)) or good >= HEALED * enough:
            fault = ActuatorFault.NONE if good >= HEALED * enough else ActuatorFault.WEAK
            if vain or (sure and lost >= enough and not (m.fault is ActuatorFault.NONE and halved)):
                fault = ActuatorFault.LOST
            suspected = lost = weak = good = held = turned = 0.0

        product, energy, learned = m.product, m.energy, m.learned
        if fault is ActuatorFault.NONE:
            keep = 1.0 - dt / _LEARNING_TIME
            product, energy = keep * product + eg, keep * energy + gg
            if running % self._snapshot < dt:
                learned = (*learned, (product, energy))[-_SNAPSHOTS:]
        seen = fault, *after, *share, variance, product, energy, learned
        self._memory = AxisMemory(*seen, lost, weak, good, running, held, turned, m.prior, suspected)
        return fault

    def freeze(self) -> AxisMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: AxisMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _held_in_vain(self, m: AxisMemory, rate: float, fins: float, over: float, known: float) -> tuple[float, float]:
        """Return how long the fins have been held over, and how far the vehicle turned the other way since.

        `known` is all of the angular acceleration that the model knows: if the hull takes half of what the fins should
        make, it may turn back.
        """
        side = math.copysign(1.0, fins)
        if over < _FULL or side * known < _HALF * abs(fins):
            return 0.0, 0.0
        held = m.held * side
        if held < 0.0:  # the other side
            return side * self._dt, 0.0
        turned = max(0.0, m.turned - rate * side * self._dt) if held > _INERTIA_TIME else 0.0
        return side * (held + self._dt), turned


def _ratio(one: float, other: float, eg: float, gg: float) -> float:
    """Return the log-likelihood ratio of an effectiveness of `one` against `other`."""
    return (one - other) * eg + 0.5 * ((other - 1.0) ** 2 - (one - 1.0) ** 2) * gg
