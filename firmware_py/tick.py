"""Ticks and rates: tick k is at t = k dt, so that nothing in the core reads a clock."""

from __future__ import annotations

import enum
from dataclasses import dataclass

NS_PER_S = 1_000_000_000
_BASE_MIN_HZ, _BASE_MAX_HZ = 50, 1000


class Rate(enum.IntEnum):
    """Rate of a part that runs slower than the cycle, Hz; a divisor of every permitted base rate."""

    HZ_50 = 50
    HZ_25 = 25
    HZ_10 = 10
    HZ_5 = 5
    HZ_2 = 2
    HZ_1 = 1


def step_ns(base_hz: int) -> int:
    """Return the step of a base rate, ns.

    Raises:
        ValueError: unless every `Rate` divides `base_hz` and the step is a whole number of ns.
    """
    if not _BASE_MIN_HZ <= base_hz <= _BASE_MAX_HZ or base_hz % Rate.HZ_50 or NS_PER_S % base_hz:
        raise ValueError(f"base rate {base_hz} Hz is not one of 50, 100, 200, 250, 400, 500, 1000 Hz")
    return NS_PER_S // base_hz


@dataclass(frozen=True, slots=True)
class Tick:
    """One step of the fixed-rate cycle.

    Attributes:
        k: number of the tick, from 0.
        dt_ns: step, ns.
        late_ns: delay of the tick after its deadline, ns. It is recorded as an input, so that a replay sees it.
    """

    k: int
    dt_ns: int
    late_ns: int = 0

    @property
    def t_ns(self) -> int:
        """Vehicle time, ns, exact."""
        return self.k * self.dt_ns

    @property
    def t(self) -> float:
        """Vehicle time, s."""
        return self.k * self.dt_ns / NS_PER_S

    @property
    def dt(self) -> float:
        """Step, s."""
        return self.dt_ns / NS_PER_S

    def every(self, rate: Rate) -> bool:
        """Return whether a part of that rate runs at this tick. Tick 0 is such a tick for every rate."""
        return self.k * self.dt_ns % (NS_PER_S // rate) == 0
