"""A propeller that reports nothing and turns faster than it is told, by what the vehicle's speed does.

Along the hull, u_dot = k (u_n |u_n| - u |u|), where u_n is the speed that belongs to the propeller's. Over each window
the DVL tells u_dot; what is not drag is thrust. A thrust far above the commanded one is that of a propeller that runs
away, or a following current makes it seem so, for the DVL measures over the bottom. The cumulative sum of the
log-likelihood ratio decides between a speed that is higher by the strongest current and one that is higher by half a
metre per second more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

_WINDOW = 2.0
"""s"""
_STD = 0.025
"""1 sigma of a gain of speed over a window that thrust and drag do not explain, m/s: DVL, eddies."""
_EXCESS = 0.5
"""What a propeller that runs away adds to the strongest current, m/s; more is seen sooner."""
_CLIP = 2.0
"""No window counts for more, nats."""
_STRAIGHT = math.radians(4.0)
"""In faster turns the hull brakes, rad/s."""


class RunawayMemory(NamedTuple):
    """What is remembered.

    Attributes:
        fast: whether the propeller runs away.
        u_first: speed at the beginning of the window, m/s.
        duration: of the window so far, s.
        drag: speed that drag took in it, m/s.
        thrust: speed that a sound propeller would have added, m/s.
        evidence: that it runs away, nats.
        good: evidence that it is over.
    """

    fast: bool
    u_first: float
    duration: float
    drag: float
    thrust: float
    evidence: float
    good: float


_FRESH = RunawayMemory(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class RunawayWatch:
    """Judges a propeller that reports nothing."""

    def __init__(self, k: float, evidence: float, current: float) -> None:
        """Make a watch.

        Args:
            k: acceleration that thrust and drag make, by the square of a speed, 1/m.
            evidence: the log-likelihood ratio, nats, at which it is named.
            current: how much faster than through the water a following current makes the vehicle at most, m/s.
        """
        self._k, self._evidence, self._current = k, evidence, current
        self._memory = _FRESH

    @property
    def fast(self) -> bool:
        """Whether the propeller runs away."""
        return self._memory.fast

    def pause(self, u: float) -> None:
        """Begin a window anew where the model does not hold."""
        self._memory = self._memory._replace(u_first=u, duration=0.0, drag=0.0, thrust=0.0)

    def update(self, dt: float, u: float, u_n: float, turning: float, reported: bool) -> bool:
        """Return whether the propeller runs away, after a ping.

        Args:
            dt: since the ping before, s.
            u: speed over the bottom ahead, m/s.
            u_n: speed that belongs to the commanded speed of the propeller, m/s.
            turning: rate of turn, rad/s.
            reported: whether the propeller tells its speed: then it does not run away unseen.
        """
        if turning > _STRAIGHT:
            self.pause(u)
            return self._memory.fast
        m, k = self._memory, self._k
        drag, thrust = m.drag + k * dt * u * abs(u), m.thrust + k * dt * u_n * abs(u_n)
        duration = m.duration + dt
        if duration < _WINDOW:
            self._memory = m._replace(duration=duration, drag=drag, thrust=thrust)
            return m.fast
        ratio = -_CLIP if reported else self._ratio(u - m.u_first + drag, thrust, duration)
        fast, evidence = m.fast, max(0.0, m.evidence + ratio)
        good = max(0.0, m.good - ratio)
        if not fast and evidence > self._evidence:
            fast, good = True, 0.0
        elif fast and good > self._evidence:
            fast, evidence = False, 0.0
        evidence, good = min(evidence, self._evidence), min(good, self._evidence)
        self._memory = RunawayMemory(fast, u, 0.0, 0.0, 0.0, evidence, good)
        return fast

    def _ratio(self, made: float, thrust: float, duration: float) -> float:
        """Return the log-likelihood ratio of a propeller that runs away to one in a following current, nats."""
        k = self._k * duration
        u = math.sqrt(max(thrust, 0.0) / k) + self._current
        sound, fast = k * u * u, k * (u + _EXCESS) ** 2
        ratio = (fast - sound) * (made - 0.5 * (fast + sound)) / (_STD * _STD)
        return min(max(ratio, -_CLIP), _CLIP)

    def freeze(self) -> RunawayMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: RunawayMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
