"""Heading by rudders (paper Eq. 30-33), with the signs that Eq. 25 gives.

With the paper's poles at its speed that is delta_r = -0.53 v - 0.16 r - 4.3 psi_d_dot + 1.5 tanh(sigma/0.05): the
print of Eq. 33 has the first three terms with the other sign. Here they come out of the design, at each speed.
"""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.control.depth import Axis
from firmware_py.control.feed_forward import Sway, next_sway, turn
from firmware_py.marine import clip
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import steering
from firmware_py.vehicle.vehicle import Vehicle

AT_REST = Sway(0.0, 0.0)


class HeadingMemory(NamedTuple):
    """The speed the law is designed for (m/s), the model's sway, and the axis's own."""

    u: float
    sway: Sway
    axis: float


class Heading:
    """Follows psi_d; sees to the model, its schedule and its sway."""

    def __init__(self, axis: Axis, vehicle: Vehicle) -> None:
        self._axis, self._vehicle = axis, vehicle
        self._limit = vehicle.effectiveness.delta_r_max
        self._sway = AT_REST
        self.schedule(vehicle.propeller.u_trim)

    def schedule(self, u: float) -> None:
        """Designs for the speed u > 0, m/s."""
        self._u = u
        self._model = steering(self._vehicle, u)
        self._axis.schedule(self._model, u / self._vehicle.propeller.u_trim)

    def update(
        self, reference: Reference, state: StateEstimate, psi_dot: float, share: float, dt: float
    ) -> tuple[float, float]:
        """(delta_r, rad; sigma_psi, rad). The fins will be given the `share` of it, and of what a manoeuvre adds."""
        error, delta_d = turn(self._model, reference, state, psi_dot, self._sway)
        delta_r, sigma = self._axis.update(error, delta_d, self._limit, dt)
        given = share * clip(reference.grip * delta_r + reference.delta_r, -self._limit, self._limit)
        self._sway = next_sway(self._model, self._sway, reference.psi_d_dot, delta_d, psi_dot, given, self._u, dt)
        return delta_r, sigma

    def follow(self, psi_dot: float, delta_r: float, dt: float) -> None:
        """Someone else steers: keeps only the sway up to date, and forgets what the axis learned."""
        self._axis.reset()
        delta_r = clip(delta_r, -self._limit, self._limit)
        v = next_sway(self._model, self._sway, 0.0, 0.0, psi_dot, delta_r, self._u, dt).v
        self._sway = Sway(v, v)

    def reset(self) -> None:
        """Forgets what it learned."""
        self._sway = AT_REST
        self._axis.reset()

    def freeze(self) -> HeadingMemory:
        """All it remembers."""
        return HeadingMemory(self._u, self._sway, self._axis.freeze())

    def thaw(self, memory: HeadingMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.schedule(memory.u)
        self._sway = memory.sway
        self._axis.thaw(memory.axis)
