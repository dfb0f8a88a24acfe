"""A reference with its derivatives: a command of bounded rate through three equal lags (Fossen 2011, ch. 12.1).

    d(s)/c(s) = omega^3 / (s + omega)^3

The lags' impulse response is never negative and its area is 1, so the reference never overshoots the command, never
exceeds its rate v, and its acceleration stays within 4 e^-2 omega v < 0.55 omega v. The steps are exact for a command
that is constant over each, so the derivatives are the reference's own, at any rate of the loop.
"""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from firmware_py.marine import clip, wrap


class Shape(enum.Enum):
    """How references follow a command that jumps."""

    SMOOTH = enum.auto()
    STEP = enum.auto()
    """At once, with derivatives of zero, as in the paper."""


class Lags(NamedTuple):
    """The rate-limited command and the three lags behind it."""

    command: float
    first: float
    second: float
    third: float


class Shaped(NamedTuple):
    """The reference and its first three derivatives."""

    d: float
    d_dot: float
    d_ddot: float
    d_dddot: float


class ReferenceModel:
    """A reference model; it remembers `Lags`. An `angle` turns the shorter way and stays in [-pi, pi)."""

    def __init__(self, shape: Shape, angle: bool = False) -> None:
        self._shape, self._angle = shape, angle
        self._memory = Lags(0.0, 0.0, 0.0, 0.0)

    @property
    def command(self) -> float:
        """The rate-limited command, at which the reference would come to rest."""
        return self._wrapped(self._memory.command)

    def reset(self, value: float) -> Shaped:
        """Set the reference to rest at `value`."""
        value = self._wrapped(value)
        self._memory = Lags(value, value, value, value)
        return Shaped(value, 0.0, 0.0, 0.0)

    def update(self, target: float, rate: float, omega: float, dt: float) -> Shaped:
        """Move the command towards `target` by at most rate dt, and the reference after it, with omega, 1/s."""
        if self._shape is Shape.STEP:
            return self.reset(target)
        command, first, second, third = self._memory
        way = wrap(target - command) if self._angle else target - command
        command += clip(way, -rate * dt, rate * dt)
        a = omega * dt
        e = math.exp(-a)
        x1, x2, x3 = first - command, second - command, third - command
        x3 = e * (x3 + a * (x2 + 0.5 * a * x1))
        x2 = e * (x2 + a * x1)
        x1 = e * x1
        self._memory = Lags(command, command + x1, command + x2, command + x3)
        return Shaped(
            self._wrapped(command + x3),
            omega * (x2 - x3),
            omega * omega * (x1 - 2.0 * x2 + x3),
            omega * omega * omega * (3.0 * x2 - 3.0 * x1 - x3),
        )

    def _wrapped(self, value: float) -> float:
        return wrap(value) if self._angle else value

    def freeze(self) -> Lags:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: Lags) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
