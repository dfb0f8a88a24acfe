"""Time is a count: tick k happens at t = k dt, and nothing in the core asks a clock."""

from __future__ import annotations

import enum
from dataclasses import dataclass

NS_PER_S = 1_000_000_000


class Rate(enum.IntEnum):
    """The rates a slower part may run at, in Hz: divisors of every permitted base rate."""

    HZ_50 = 50
    HZ_25 = 25
    HZ_10 = 10
    HZ_5 = 5
    HZ_2 = 2
    HZ_1 = 1


def step_ns(base_hz: int) -> int:
    """The step of a base rate in ns.

    Raises:
        ValueError: unless every `Rate` divides `base_hz` and the step is a whole number of ns.
    """
    if not 50 <= base_hz <= 1000 or base_hz % Rate.HZ_50 or NS_PER_S % base_hz:
        raise ValueError(f"base rate {base_hz} Hz is not one of 50, 100, 200, 250, 400, 500, 1000 Hz")
    return NS_PER_S // base_hz


@dataclass(frozen=True, slots=True)
class Tick:
    """One step of the fixed-rate loop.

    `late_ns` is how long after its deadline the tick began: an input like any other, so that a replay sees it.
    """

    k: int
    dt_ns: int
    late_ns: int = 0

    @property
    def t_ns(self) -> int:
        """Vehicle time in ns, exact."""
        return self.k * self.dt_ns

    @property
    def t(self) -> float:
        """Vehicle time in s."""
        return self.k * self.dt_ns / NS_PER_S

    @property
    def dt(self) -> float:
        """The step in s."""
        return self.dt_ns / NS_PER_S

    def every(self, rate: Rate) -> bool:
        """True on the ticks at which a part of that rate runs; tick 0 is one of them."""
        return self.k * self.dt_ns % (NS_PER_S // rate) == 0
