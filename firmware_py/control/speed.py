"""Speed control by propeller: n is proportional to u in trim, and a PI controller corrects the rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.records.estimate import StateEstimate
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

    def drive(self, u_d: float, state: StateEstimate, dt: float, least: float, floor: float = 0.0) -> float:
        """Return `update` for an estimated state."""
        return self.update(u_d, state.nu.u, state.velocity_ok, dt, state.through_water_sure, least, floor)

    def update(
        self,
        u_d: float,
        u: float,
        u_valid: bool,
        dt: float,
        through: float = math.inf,
        least: float = 0.0,
        floor: float = 0.0,
    ) -> float:
        """Return the propeller speed n, rev/s, in [0, n_max]: n = n_trim / u_trim u_d + k_p (u_d - u) + integral.

        Never turns the propeller astern; u_d <= 0 stops it and clears the integral. Anti-windup: the integral is held
        while n is at a bound and the error drives it further out.

        Fins act by the speed through the water alone, so a share of u_d is made through it at least, in a current from
        astern too.

        Args:
            u_d: desired surge speed over the ground, m/s.
            u: measured surge speed, m/s.
            u_valid: false leaves u out: feed-forward and the held integral only.
            dt: step, s.
            through: speed through the water, m/s.
            least: the share.
            floor: share of the propeller speed in trim that it turns with at least, whatever u and `through` say.
        """
        if not u_d > 0.0:
            self._integral = 0.0
            return 0.0
        trim = self._n_per_u * u_d
        n, n_least = trim + self._integral, min(floor * trim, self._n_max)
        if not u_valid:
            return clip(n, n_least, self._n_max)
        error = u_d - min(u, through + (1.0 - least) * u_d)
        n += self._params.k_p * error
        if (n < self._n_max or error < 0.0) and (n > n_least or error > 0.0):
            self._integral = clip(self._integral + dt * self._params.k_i * error, -self._n_max, self._n_max)
        return clip(n, n_least, self._n_max)

    def reset(self) -> None:
        """Clear the integral."""
        self._integral = 0.0

    def freeze(self) -> float:
        """Return the whole memory."""
        return self._integral

    def thaw(self, memory: float) -> None:
        """Restore the memory that `freeze` returned."""
        self._integral = memory
