"""Heading control by rudders (paper Eq. 30-33), with the signs that follow from Eq. 25.

With the paper's poles, at the paper's speed, Eq. 25 gives
delta_r = -0.53 v - 0.16 r - 4.3 psi_d_dot + 1.5 tanh(sigma / 0.05).
Eq. 33 is printed with the opposite sign in its first three terms. Here the coefficients come out of the design, anew at
each speed.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.control.axis_law import AxisLaw
from firmware_py.control.feed_forward import SwayInput, SwayState, propagate_sway, track_heading
from firmware_py.control.fin_demand import fin_demand
from firmware_py.marine import clip
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import SteeringCoefficients, steering_coefficients, steering_model
from firmware_py.vehicle.vehicle import Vehicle

NO_SWAY = SwayState(0.0, 0.0)


class HeadingControlMemory(NamedTuple):
    """What heading control remembers.

    Attributes:
        u: speed that the law is designed for, m/s.
        coefficients: those that it is designed from, and
        caution: how little is known of them.
        sway: sway of the steering model.
        law: memory of the axis law.
    """

    u: float
    coefficients: SteeringCoefficients
    caution: float
    sway: SwayState
    law: float


class HeadingControl:
    """Heading control: makes the rudders follow psi_d.

    It keeps the steering model up to date with the speed, propagates that model's sway, and leaves the rest to an
    `AxisLaw`.
    """

    def __init__(self, law: AxisLaw, vehicle: Vehicle) -> None:
        self._law, self._vehicle = law, vehicle
        self._limit = vehicle.effectiveness.delta_r_max
        self._sway = NO_SWAY
        self._coefficients, self._caution = steering_coefficients(vehicle), 0.0
        self.schedule(vehicle.propeller.u_trim)

    def adopt(self, coefficients: SteeringCoefficients, caution: float) -> None:
        """Take other coefficients, and how little is known of them; the next `schedule` designs from them."""
        self._coefficients, self._caution = coefficients, caution

    def schedule(self, u: float) -> None:
        """Redesign the law for the speed u, m/s, > 0."""
        self._u = u
        self._model = steering_model(self._vehicle, u, self._coefficients)
        self._law.schedule(self._model, u / self._vehicle.propeller.u_trim, self._caution)

    def update(
        self, reference: Reference, state: StateEstimate, psi_dot: float, fade: float, dt: float
    ) -> tuple[float, float]:
        """Return the demand delta_r (rad) and sigma_psi (rad).

        Args:
            psi_dot: rate of the heading angle, rad/s.
            fade: factor in [0, 1] by which fins are reduced at low speed.
        """
        error, delta_ff = track_heading(self._model, reference, state, psi_dot, self._sway)
        delta_r, sigma = self._law.update(error, delta_ff, self._limit, dt)
        delta_r = fin_demand(delta_r, reference.delta_r, reference.grip, self._limit, fade)
        desired, actual = SwayInput(reference.psi_d_dot, delta_ff), SwayInput(psi_dot, delta_r)
        self._sway = propagate_sway(self._model, self._sway, desired, actual, self._u, dt)
        return delta_r, sigma

    def follow(self, psi_dot: float, delta_r: float, dt: float) -> None:
        """Propagate the sway under a rudder (rad) that somebody else commands, and clear the law's integral."""
        self._law.reset()
        actual = SwayInput(psi_dot, clip(delta_r, -self._limit, self._limit))
        v = propagate_sway(self._model, self._sway, SwayInput(0.0, 0.0), actual, self._u, dt).v
        self._sway = SwayState(v, v)

    def reset(self) -> None:
        """Clear the sway and the law's integral."""
        self._sway = NO_SWAY
        self._law.reset()

    def freeze(self) -> HeadingControlMemory:
        """Return the whole memory."""
        return HeadingControlMemory(self._u, self._coefficients, self._caution, self._sway, self._law.freeze())

    def thaw(self, memory: HeadingControlMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._coefficients, self._caution = memory.coefficients, memory.caution
        self.schedule(memory.u)
        self._sway = memory.sway
        self._law.thaw(memory.law)
