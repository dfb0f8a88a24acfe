"""Speed by propeller: n is proportional to u in trim, and a PI answers what that leaves."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.vehicle.vehicle import Propeller


@dataclass(frozen=True, slots=True)
class SpeedParams:
    """All ours. Gains are rpm per m/s, and per m/s and second."""

    k_p: float = param(1200.0, unit="rpm", low=0.0, high=1e5, doc="Propeller speed per m/s of speed error.", mav="KP")
    k_i: float = param(
        8.0, unit="rpm/s", low=0.0, high=1e5, doc="Propeller speed per second and m/s of speed error.", mav="KI"
    )


class Speed:
    """Remembers the integral, rev/s."""

    def __init__(self, params: SpeedParams, propeller: Propeller) -> None:
        self._params = params
        self._n_per_u = propeller.n_trim / propeller.u_trim
        self._n_max = propeller.n_max
        self._memory = 0.0

    def update(self, u_d: float, u: float, known: bool, dt: float) -> float:
        """n, rev/s in [0, n_max], for the speed u_d, m/s; u is fed back while it is `known`. Never turns astern.

        Asked to stand still it stops the propeller and forgets.
        """
        if not u_d > 0.0:
            self._memory = 0.0
            return 0.0
        n = self._n_per_u * u_d + self._memory
        if not known:
            return clip(n, 0.0, self._n_max)
        error = u_d - u
        n += self._params.k_p * error
        if (n < self._n_max or error < 0.0) and (n > 0.0 or error > 0.0):
            self._memory = clip(self._memory + dt * self._params.k_i * error, -self._n_max, self._n_max)
        return clip(n, 0.0, self._n_max)

    def reset(self) -> None:
        """Forgets the integral."""
        self._memory = 0.0

    def freeze(self) -> float:
        """All it remembers."""
        return self._memory

    def thaw(self, memory: float) -> None:
        """Takes up again what `freeze` gave."""
        self._memory = memory
