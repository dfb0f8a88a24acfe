"""How a bank begins, and how it keeps its members alive, compiled.

Begun far from the truth, an extended Kalman filter believes slopes that are not the right ones, and becomes too sure of
what follows from them: worst where two unknowns multiply, as the current and every coefficient do. So it begins in
two stages. At first coefficients are only considered, until the water is known. Then they learn, and the velocities
walk at random by what the slopes may be wrong by, which fades (Jazwinski 1970, section 8.11). Where the water wavers
they do so from the start, and the more the less of it is known: unknown water times wrong coefficients has no slope.
"""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from firmware_py.estimation.filter.consistency import COUNT, SUM
from firmware_py.estimation.model.jacobians import Array
from firmware_py.estimation.model.transition import MOVING

GROWTH, LEARNS, LOW, HIGH, STIRS = 0, 1, 2, 3, 4
"""Rows of `rules`: variance gained by the second, 1 for states that learn (else 0), least and greatest value, and
variance gained by the second and by eddies that a member reckons with times what it does not know of the water."""
FLOOR, BEGINNING, MAY, STIRRED = 5, 6, 7, 8
"""Rows that they follow from: the growth in the end, what it has more in the beginning, who may learn, and what the
last is in the beginning."""
RULES = 9
WINDOW, ENOUGH, LOST = 3.0, 20.0, 3.0
"""A mean NIS (1 expected) beyond the last, over so many s and from so many measurements, is no chance: it is lost."""
HOPELESS = 100.0
"""A member so far behind the likeliest in log-likelihood begins anew as its copy, half as far behind."""


@kernel("void(f8[:,::1],f8[::1],i8,f8,f8,f8)")
def settle(rules: Array, age: Array, first: int, h: float, wait: float, fade: float) -> None:
    """Sets growth and learning for a step of h (s).

    Args:
        rules: (RULES, n or wider).
        age: how long the filter has run, s, (1,); h more in the end; it stands while none may learn.
        first: place of the first parameter.
        h: step, s.
        wait: for so long, s, parameters do not learn.
        fade: time constant of the beginning, s.
    """
    waits = age[0] < wait
    learned = False
    for j in range(rules.shape[1]):
        may = rules[MAY, j]
        if j >= first:
            learned = learned or may != 0.0
            if waits:
                may = 0.0
        rules[LEARNS, j] = may
        rules[GROWTH, j] = rules[FLOOR, j] * may
    share = math.exp(-2.0 * max(age[0] - wait, 0.0) / fade)
    for j in range(MOVING):
        rules[STIRS, j] = share * rules[STIRRED, j]
        if not waits:
            rules[GROWTH, j] += share * rules[BEGINNING, j]
    if waits or learned:
        age[0] += h


@kernel("i8(f8[::1])")
def leader(evidence: Array) -> int:
    """The likeliest member."""
    likeliest = 0
    for b in range(1, len(evidence)):
        if evidence[b] > evidence[likeliest]:
            likeliest = b
    return likeliest


@kernel("void(f8[:,::1],f8[:,:,::1],f8[::1])")
def revive(x: Array, P: Array, evidence: Array) -> None:
    """Lets members begin anew that have no hope, before they leave the numbers; shapes as in `bank.step`."""
    likeliest = leader(evidence)
    for b in range(len(evidence)):
        if evidence[b] < evidence[likeliest] - HOPELESS:
            for i in range(x.shape[1]):
                x[b, i] = x[likeliest, i]
            for i in range(P.shape[1]):
                for j in range(P.shape[2]):
                    P[b, i, j] = P[likeliest, i, j]
            evidence[b] = evidence[likeliest] - 0.5 * HOPELESS


@kernel("b1(f8[:,::1])")
def lost(window: Array) -> bool:
    """Whether a filter believes firmly what the measurements in its window (see `innovations.hear`) contradict."""
    for sensor in range(3):
        count = window[sensor, COUNT]
        if count > ENOUGH and window[sensor, SUM] > LOST * count:
            return True
    return False
