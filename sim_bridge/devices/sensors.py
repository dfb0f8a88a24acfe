"""What every instrument has in common: rate, noise, bias, latency and dropout.

`instruments` says what each instrument measures; this module adds its errors. Each draws from two random streams of its
own (noise and dropout), spawned from the run's seed and its name: to change one instrument leaves the readings of every
other one as they were.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from firmware_py.params import param

P = TypeVar("P")
V = TypeVar("V")

BLOCK = 128
"""Number of samples whose errors are drawn at once."""


class Reading(NamedTuple, Generic[V]):
    """A value and the time, s, at which it was true."""

    value: V
    t_valid: float


Corruption: TypeAlias = Callable[[Reading[Any]], Reading[Any] | None]
"""What a fault makes of a reading; None: it never arrives."""


@dataclass(frozen=True, slots=True)
class Timing:
    """When an instrument delivers a value."""

    rate: int = param(unit="Hz", low=1, high=1000, doc="Samples a second; above the base rate: one every tick.")
    latency: float = param(
        0.0, unit="s", low=0.0, high=5.0, doc="From the moment of validity to delivery; whole ticks."
    )
    dropout: float = param(0.0, low=0.0, high=1.0, doc="Probability that a sample never arrives.")


def due(k: int, rate: int, base_hz: int) -> bool:
    """Return True on `rate` ticks of each second, tick 0 among them, evenly spread; on every one if above `base_hz`."""
    return k * rate % base_hz < rate


class Sensor(Generic[P, V]):
    """One instrument of a plant of type P that gives values of type V.

    Args:
        name: names the random streams, and the instrument in errors.
        timing: rate, latency, dropout.
        read: makes the value from the plant and one error per channel (bias and noise, summed); it is called at the
            time of validity, once per sample, dropped ones too.
        noise: 1 sigma of each channel's white noise.
        bias: 1 sigma of each channel's constant error, drawn once.
        seed: of the run.
        base_hz: ticks a second.
    """

    def __init__(
        self,
        name: str,
        timing: Timing,
        read: Callable[[P, Sequence[float]], V],
        noise: Sequence[float],
        bias: Sequence[float],
        seed: int,
        base_hz: int,
    ) -> None:
        self._read = read
        self._dt = 1.0 / base_hz
        self._rate, self._base = timing.rate, base_hz
        self._delay = round(timing.latency * base_hz)
        self._dropout = timing.dropout
        streams = np.random.SeedSequence([seed, *name.encode()]).spawn(2)
        self._normals, self._uniforms = (np.random.Generator(np.random.PCG64(s)) for s in streams)
        self._noise = np.asarray(noise, dtype=np.float64)
        self.bias: tuple[float, ...] = tuple((self._normals.standard_normal(len(bias)) * np.asarray(bias)).tolist())
        self.corruptions: list[Corruption] = []
        """Faults, applied to each reading in order."""
        self.extra_delay = 0
        """A fault: so many ticks more latency. When it ends, a reading that a newer one overtakes is lost."""
        self._errors: list[list[float]] = []
        self._lost: list[bool] = []
        self._in_transit: deque[tuple[int, Reading[V]]] = deque()

    @property
    def delay(self) -> int:
        """Return the latency in ticks."""
        return self._delay

    def update(self, k: int, plant: P) -> Reading[V] | None:
        """Sample if tick `k` is one of its ticks, and return the reading that is delivered at it, if any."""
        in_transit = self._in_transit
        if due(k, self._rate, self._base):
            if not self._errors:
                self._draw()
            reading: Reading[V] | None = Reading(self._read(plant, self._errors.pop()), k * self._dt)
            if self._lost.pop():
                reading = None
            for corrupt in self.corruptions:
                reading = corrupt(reading) if reading else None
            if reading:
                due_k = k + self._delay + self.extra_delay
                while in_transit and in_transit[-1][0] >= due_k:  # once the latency has shrunk: overtaken
                    in_transit.pop()
                in_transit.append((due_k, reading))
        if in_transit and in_transit[0][0] <= k:
            return in_transit.popleft()[1]
        return None

    def _draw(self) -> None:
        errors = self._normals.standard_normal((BLOCK, len(self._noise))) * self._noise + self.bias
        self._errors = errors.tolist()
        self._lost = (self._uniforms.random(BLOCK) < self._dropout).tolist()
