"""Speed control by propeller: n is proportional to u in trim, and a PI controller corrects the rest."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.vehicle.vehicle import Propeller


@dataclass(frozen=True, slots=True)
class SpeedParams:
    """Gains of the PI controller. All chosen here."""

    k_p: float = param(
        1200.0,
        unit="rpm",
        low=0.0,
        high=1e5,
        doc="Propeller speed per m/s of speed error. Larger: faster, with more propeller activity.",
        mav="KP",
    )
    k_i: float = param(
        8.0,
        unit="rpm/s",
        low=0.0,
        high=1e5,
        doc="Propeller speed per m/s of speed error and second. Larger: faster trim, more overshoot. 0: off.",
        mav="KI",
    )


class SpeedControl:
    """Speed control. Its memory is the integral, rev/s."""

    def __init__(self, params: SpeedParams, propeller: Propeller) -> None:
        self._params = params
        self._n_per_u = propeller.n_trim / propeller.u_trim
        self._n_max = propeller.n_max
        self._integral = 0.0

    def update(self, u_d: float, u: float, u_valid: bool, dt: float) -> float:
        """Return the propeller speed n, rev/s, in [0, n_max]: n = n_trim / u_trim u_d + k_p (u_d - u) + integral.

        Never turns the propeller astern; u_d <= 0 stops it and clears the integral. Anti-windup: the integral is held
        while n is at a bound and the error drives it further out.

        Args:
            u_d: desired surge speed, m/s.
            u: measured surge speed, m/s.
            u_valid: false leaves u out: feed-forward and the held integral only.
            dt: step, s.
        """
        if not u_d > 0.0:
            self._integral = 0.0
            return 0.0
        n = self._n_per_u * u_d + self._integral
        if not u_valid:
            return clip(n, 0.0, self._n_max)
        error = u_d - u
        n += self._params.k_p * error
        if (n < self._n_max or error < 0.0) and (n > 0.0 or error > 0.0):
            self._integral = clip(self._integral + dt * self._params.k_i * error, -self._n_max, self._n_max)
        return clip(n, 0.0, self._n_max)

    def reset(self) -> None:
        """Clear the integral."""
        self._integral = 0.0

    def freeze(self) -> float:
        """Return the whole memory."""
        return self._integral

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
        self._integral = memory
