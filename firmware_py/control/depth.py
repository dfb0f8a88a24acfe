"""Depth control by stern planes (paper Eq. 26-29), with the signs that follow from Eq. 25.

With the paper's poles, at the paper's speed, Eq. 25 gives
delta_s = -2.35 q - 0.006 theta + 0.170 z_d_dot + 2.3 tanh(sigma / 4).
Eq. 29 is printed with the opposite sign in its first three terms. Here the coefficients come out of the design, anew at
each speed.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.control.axis_law import AxisLaw
from firmware_py.control.feed_forward import track_depth, unmodelled_climb
from firmware_py.control.fin_demand import fin_demand
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import DivingCoefficients, diving_coefficients, diving_model
from firmware_py.vehicle.vehicle import Vehicle


class DepthControlMemory(NamedTuple):
    """What depth control remembers.

    Attributes:
        u: speed that the law is designed for, m/s.
        coefficients: those that it is designed from, and
        caution: how little is known of them.
        climb_bias: low-passed vertical velocity that the diving model leaves out, m/s, down positive.
        law: memory of the axis law.
    """

    u: float
    coefficients: DivingCoefficients
    caution: float
    climb_bias: float
    law: float


class DepthControl:
    """Depth control: makes the stern planes follow z_d.

    It keeps the diving model up to date with the speed, estimates the vertical velocity that this model leaves out, and
    leaves the rest to an `AxisLaw`.
    """

    def __init__(self, law: AxisLaw, vehicle: Vehicle, climb_bias_time: float) -> None:
        self._law, self._vehicle, self._climb_bias_time = law, vehicle, climb_bias_time
        self._limit = vehicle.effectiveness.delta_s_max
        self._climb_bias = 0.0
        self._coefficients, self._caution = diving_coefficients(vehicle), 0.0
        self.schedule(vehicle.propeller.u_trim)

    def adopt(self, coefficients: DivingCoefficients, caution: float) -> None:
        """Take other coefficients, and how little is known of them; the next `schedule` designs from them."""
        self._coefficients, self._caution = coefficients, caution

    def schedule(self, u: float) -> None:
        """Redesign the law for the speed u, m/s, > 0."""
        self._u = u
        self._model = diving_model(self._vehicle, u, self._coefficients)
        self._law.schedule(self._model, u / self._vehicle.propeller.u_trim, self._caution)

    def update(
        self, reference: Reference, state: StateEstimate, theta_dot: float, fade: float, dt: float
    ) -> tuple[float, float]:
        """Return the demand delta_s (rad) and sigma_z (m).

        Args:
            theta_dot: rate of the pitch angle, rad/s.
            fade: factor in [0, 1] by which fins are reduced at low speed.
        """
        error, delta_ff = track_depth(self._model, reference, state, theta_dot, self._climb_bias)
        if self._climb_bias_time > 0.0:
            measured = unmodelled_climb(self._model, state) if state.velocity_ok else 0.0
            self._climb_bias += min(dt / self._climb_bias_time, 1.0) * (measured - self._climb_bias)
        delta_s, sigma = self._law.update(error, delta_ff, self._limit, dt)
        return fin_demand(delta_s, reference.delta_s, reference.grip, self._limit, fade), sigma

    def reset(self) -> None:
        """Clear the climb bias and the law's integral."""
        self._climb_bias = 0.0
        self._law.reset()

    def freeze(self) -> DepthControlMemory:
        """Return the whole memory."""
        return DepthControlMemory(self._u, self._coefficients, self._caution, self._climb_bias, self._law.freeze())

    def thaw(self, memory: DepthControlMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._coefficients, self._caution = memory.coefficients, memory.caution
        self.schedule(memory.u)
        self._climb_bias = memory.climb_bias
        self._law.thaw(memory.law)
