"""What the vehicle's motion says of two models of one axis: vehicle.toml, and the one that the law is designed from.

For each model a Kalman filter with constant gains follows the rate of turn under the fins' moment and a slow
disturbance (eddies, trim, what the linear model leaves out). Its innovations are white, and their squares are twice the
negative log-likelihood (Bar-Shalom, Li and Kirubarajan 2001, ch. 11.6); the difference of both is the evidence, in
nats. It fades, so that what is long ago does not outweigh what is seen now.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.vehicle.turning import GYRO_STD, TurningAxis, follow

PERIOD = 0.04
"""Step of the filters, s."""
_RATE_STD = GYRO_STD * math.sqrt(0.01 / PERIOD)
"""Noise of the mean rate over a period, rad/s."""
_FADING_TIME = 10.0
"""Time over which evidence fades, s."""
_MOST = 50.0
"""More evidence than this, nats, in favour of a model is not kept: it must be refutable within the fading time."""
_SETTLING_TIME = 2.0
"""After a start the filters find the disturbance, s."""
_SWAY_MAX = 0.5
"""Bound of the modelled sway, of the speed."""


class Prediction(NamedTuple):
    """What one model's filter remembers: rate, rad/s; disturbance, rad/s^2; modelled sway, m/s."""

    rate: float
    disturbance: float
    sway: float


class EvidenceMemory(NamedTuple):
    """What is remembered.

    Attributes:
        nominal: of vehicle.toml's filter.
        others: of the filters of the models that are compared with it.
        variance: running mean of the least innovation squared, rad^2/s^2.
        evidence: in favour of each of the others, nats.
        running: how long the filters have run, s.
    """

    nominal: Prediction
    others: tuple[Prediction, ...]
    variance: float
    evidence: tuple[float, ...]
    running: float


_REST = Prediction(0.0, 0.0, 0.0)


def no_evidence(count: int) -> EvidenceMemory:
    """Return what is remembered before the first step, of so many models beside vehicle.toml."""
    return EvidenceMemory(_REST, (_REST,) * count, _RATE_STD**2, (0.0,) * count, 0.0)


class Motion(NamedTuple):
    """What is measured over a period: speed, m/s; rate, rad/s; pitch, rad; heave velocity, m/s; fin angle, rad."""

    u: float
    rate: float
    theta: float
    w: float
    delta: float


def pause(m: EvidenceMemory) -> EvidenceMemory:
    """Return what is remembered where the models do not hold: the evidence alone."""
    return m._replace(running=0.0) if m.running else m


def step(
    m: EvidenceMemory,
    nominal: TurningAxis,
    others: Sequence[TurningAxis],
    gains: tuple[float, float],
    motion: Motion,
) -> EvidenceMemory:
    """Return what is remembered after one more period."""
    if m.running == 0.0:
        start = Prediction(motion.rate, 0.0, 0.0)
        return m._replace(nominal=start, others=(start,) * len(others), running=PERIOD)
    first, e_first = _follow(m.nominal, nominal, gains, motion)
    followed = [_follow(p, axis, gains, motion) for p, axis in zip(m.others, others, strict=True)]
    predictions, running = tuple([p for p, _ in followed]), m.running + PERIOD
    if running < _SETTLING_TIME:
        return m._replace(nominal=first, others=predictions, running=running)
    square, squares = e_first * e_first, [e * e for _, e in followed]
    share = PERIOD / _FADING_TIME
    variance = m.variance + share * (min(square, *squares) - m.variance)
    unit = 0.5 / max(variance, _RATE_STD**2)
    evidence = tuple(
        [
            clip((1.0 - share) * before + unit * (square - own), -_MOST, _MOST)
            for before, own in zip(m.evidence, squares, strict=True)
        ]
    )
    return EvidenceMemory(first, predictions, variance, evidence, running)


def _follow(p: Prediction, axis: TurningAxis, gains: tuple[float, float], motion: Motion) -> tuple[Prediction, float]:
    """Return a filter's memory after a period, and its innovation, rad/s."""
    u, rate, theta, w, delta = motion
    a_vv, a_vr, b_v = axis.sway
    cross = p.sway if a_vv else w
    moment = axis.crosswise * u * cross + axis.restoring * math.sin(theta) + axis.control * u * u * delta
    e, follower = follow((p.rate, p.disturbance), gains, rate, axis.damping * u, moment, PERIOD)
    sway = p.sway + PERIOD * (a_vv * u * p.sway + a_vr * u * rate + b_v * u * u * delta)
    bound = _SWAY_MAX * u
    return Prediction(*follower, clip(sway, -bound, bound)), e
