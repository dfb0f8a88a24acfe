"""What adoption remembers of one axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.control.lost_effect import Effect, beyond, halved, surest, whole_again, with_share
from firmware_py.control.model_evidence import EvidenceMemory
from firmware_py.records.adoption import Refusal, Source

Values = tuple[float, ...]
_PROVEN = 0.1
"""Good values are proven by valid ones that differ by no more than this share,"""
_TURNS = slice(-2, None)
"""of damping and fins, which come last."""


class AxisMemory(NamedTuple):
    """What is remembered.

    Attributes:
        values: the coefficients in force.
        candidate: what would be in force if nothing were refused.
        sure: which of these are certain enough.
        source: where the values in force come from.
        refusal: what is against the candidate.
        good: values that held for a while: the last good ones come first, then those that may follow them.
        held: for how long the values in force have held, s.
        evidence: of the candidate, and of what is in force, against vehicle.toml.
        delta: the fin angle of the last period, rad.
        earlier: which coefficients are known from an earlier flight, and were not learned anew since.
        refuted: whether the motion has refuted vehicle.toml.
        valid: whether all moments of the axis were valid.
        share: what is left of the fins' effect; `good` is that of sound fins.
        since: for how long that has been so, s.
        unknown: whether a fin is where nobody knows.
        proven: the latest good values with which damping and fins agreed that were valid.
        least: the least that the fins did, by values that were proven since the fins were whole: fins do not grow.
        whole: the most that the fins did while all were taken for sound, by valid values.
        halved: whether they do no more than half of it now, and nobody has said so yet.
    """

    values: Values
    candidate: Values
    sure: tuple[bool, ...]
    source: Source
    refusal: Refusal
    good: tuple[Values, ...]
    held: float
    evidence: EvidenceMemory
    delta: float
    earlier: tuple[bool, ...]
    refuted: bool
    valid: bool
    share: float
    since: float
    unknown: bool
    proven: Values = ()
    least: float = math.inf
    whole: Effect = Effect(0.0, 0.0)
    halved: bool = False


def with_left(m: AxisMemory, share: float) -> AxisMemory:
    """Return what is remembered once another share of the fins' effect is left: what they did is over."""
    since = 0.0 if share < m.share else math.inf
    return m._replace(share=share, since=since, whole=Effect(0.0, 0.0), halved=False, least=math.inf)


def proven(m: AxisMemory, learned: Sequence[float], valid: Sequence[bool]) -> AxisMemory:
    """Return what is remembered once good values are compared with valid ones, as long as all fins are sound.

    What is beyond all that was proven proves nothing: the filter errs. In a climb of three minutes with planes that
    stood still it came to twice what they do, step by step, each of which proved the next.
    """
    if m.good and m.proven != m.good[0] and m.share == 1.0 and all(valid[_TURNS]):
        turns = zip(learned[_TURNS], m.good[0][_TURNS], strict=True)
        does, agree = abs(m.good[0][-1]), all(abs(now - good) <= _PROVEN * abs(good) for now, good in turns)
        if agree and not beyond(m.least, Effect(does, 0.0)):
            return m._replace(proven=m.good[0], least=min(m.least, does))
    return m


def compared(m: AxisMemory, names: Sequence[str], file: Values, now: Effect) -> AxisMemory:
    """Return what is remembered once what fins do by valid values is compared with the most that they did.

    Where half of it is gone, the good values become those of before. It may have been a sensor that lied, which teaches
    the filter the same: where the fins do as much as ever nothing is gone. Nor is it where they seemed to do twice as
    much as what was proven, as a filter has it for seconds that begins anew because fins of the other axis were lost.
    """
    if beyond(m.least / abs(file[-1]), now):
        return m
    if m.good and not m.halved and halved(m.whole, now):
        sound = with_share(names, m.good[0], m.whole.share * file[-1] / m.good[0][-1])
        m = m._replace(good=(sound,), halved=True)
    elif m.halved and whole_again(m.whole, now):
        m = m._replace(halved=False)
    return m._replace(whole=surest(m.whole, now))
