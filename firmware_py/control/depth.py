"""Depth by stern planes (paper Eq. 26-29), with the signs that Eq. 25 gives.

With the paper's poles at its speed that is delta_s = -2.35 q - 0.006 theta + 0.170 z_d_dot + 2.3 tanh(sigma/4): the
print of Eq. 29 has the first three terms with the other sign. Here they come out of the design, at each speed.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from firmware_py.control.feed_forward import dive, unexplained_climb
from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.vehicle.linear_models import Linear, Row, diving
from firmware_py.vehicle.vehicle import Vehicle


class Axis(Protocol):
    """A law of one input: sliding mode or PID."""

    def schedule(self, model: Linear, pace: float) -> None:
        """Takes the model at another speed, `pace` times the trim speed."""

    def update(self, error: Row, delta_d: float, limit: float, dt: float) -> tuple[float, float]:
        """(fin angle, sigma) for the error of the model's states and its feed-forward."""

    def reset(self) -> None:
        """Forgets everything."""

    def freeze(self) -> float:
        """All it remembers."""

    def thaw(self, memory: float) -> None:
        """Takes up again what `freeze` gave."""


class DepthMemory(NamedTuple):
    """The speed the law is designed for and the climb the model leaves out (m/s), and the axis's own."""

    u: float
    drift: float
    axis: float


class Depth:
    """Follows z_d; sees to the model, its schedule and what it leaves out."""

    def __init__(self, axis: Axis, vehicle: Vehicle, drift_time: float) -> None:
        self._axis, self._vehicle, self._drift_time = axis, vehicle, drift_time
        self._limit = vehicle.effectiveness.delta_s_max
        self._drift = 0.0
        self.schedule(vehicle.propeller.u_trim)

    def schedule(self, u: float) -> None:
        """Designs for the speed u > 0, m/s."""
        self._u = u
        self._model = diving(self._vehicle, u)
        self._axis.schedule(self._model, u / self._vehicle.propeller.u_trim)

    def update(self, reference: Reference, state: StateEstimate, theta_dot: float, dt: float) -> tuple[float, float]:
        """(delta_s, rad; sigma_z, m)."""
        error, delta_d = dive(self._model, reference, state, theta_dot, self._drift)
        if self._drift_time > 0.0:
            found = unexplained_climb(self._model, state) if state.velocity_ok else 0.0
            self._drift += min(dt / self._drift_time, 1.0) * (found - self._drift)
        return self._axis.update(error, delta_d, self._limit, dt)

    def reset(self) -> None:
        """Forgets what it learned."""
        self._drift = 0.0
        self._axis.reset()

    def freeze(self) -> DepthMemory:
        """All it remembers."""
        return DepthMemory(self._u, self._drift, self._axis.freeze())

    def thaw(self, memory: DepthMemory) -> None:
        """Takes up again what `freeze` gave."""
        self.schedule(memory.u)
        self._drift = memory.drift
        self._axis.thaw(memory.axis)
