"""Surge, sway and yaw that propeller and rudder make: what the hull does by its model, whatever its sensors say.

Thrust and drag drive the speed; the sway-yaw equations of the steering model (Fossen 2011, Sec. 7.2), with the vehicle
file's coefficients and cross-flow drag, turn the hull; turning brakes it. All through the water.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

from firmware_py.vehicle.vehicle import Vehicle

_SLOWEST = 0.1
"""Slower than this the rudder does nothing, m/s."""
_STATIONS = (-0.4, -0.2, 0.0, 0.2, 0.4)
"""Where cross-flow drag is summed up, of the length."""


@dataclass(slots=True)
class MotionMemory:
    """Surge and sway through the water, m/s, and rate of turn, rad/s."""

    u: float = 0.0
    v: float = 0.0
    r: float = 0.0


class MotionModel:
    """The model of one vehicle."""

    def __init__(self, vehicle: Vehicle) -> None:
        hull, body, c, propeller = vehicle.hull, vehicle.body, vehicle.coefficients, vehicle.propeller
        length, half = hull.length, 0.5 * hull.density
        self._ratio = propeller.u_trim / propeller.n_trim
        mass, inertia = body.mass / (half * length**3), body.I_z / (half * length**5)
        m11, m12, m21, m22 = mass - c.Y_vdot, -c.Y_rdot, -c.N_vdot, inertia - c.N_rdot
        det = m11 * m22 - m12 * m21
        self._inverse = (m22 / det, -m12 / det, -m21 / det, m11 / det)
        self._damping = (c.Y_v, c.Y_r - mass, c.N_v, c.N_r, c.Y_dr, c.N_dr)
        self._length = length
        self._cross = -hull.C_dy * hull.height / (len(_STATIONS) * length)
        surge = mass - c.X_udot
        self._drag, self._turn = propeller.C_d0 / (surge * length), (mass + c.X_vr) / surge
        brakes = (c.X_vv / length, c.X_rr * length, c.X_drdr / length, c.X_dsds / length, c.X_rdr, c.X_vdr / length)
        self._brakes = tuple(x / surge for x in brakes)
        self._fins = vehicle.deflection_rows
        self.memory = MotionMemory()

    def deflections(self, fins: list[float]) -> tuple[float, float]:
        """Return delta_s and delta_r for fin angles, rad."""
        s, r, _ = self._fins
        return sum(a * b for a, b in zip(s, fins, strict=True)), sum(a * b for a, b in zip(r, fins, strict=True))

    def step(self, dt: float, n: float, delta_s: float, delta_r: float) -> None:
        """Go on by dt, s, at the propeller speed n, rev/s, with stern planes and rudder at these angles, rad."""
        m, length = self.memory, self._length
        u, v, r = max(m.u, _SLOWEST), m.v, m.r
        y_v, y_r, n_v, n_r, y_dr, n_dr = self._damping
        side = moment = 0.0
        for x in _STATIONS:
            flow = v + x * length * r
            drag = self._cross * flow * abs(flow)
            side += drag
            moment += x * drag
        # Force over rho/2 L^3, moment over rho/2 L^4: both accelerations, of v and of r L.
        force = u * (y_v * v + y_r * r * length + y_dr * u * delta_r) / length + side
        torque = u * (n_v * v + n_r * r * length + n_dr * u * delta_r) / length + moment
        a, b, c, d = self._inverse
        pull = n * self._ratio
        vv, rr, drdr, dsds, rdr, vdr = self._brakes
        u_dot = self._drag * (pull * abs(pull) - m.u * abs(m.u)) + self._turn * v * r + vv * v * v + rr * r * r
        u_dot += u * (u * (drdr * delta_r * delta_r + dsds * delta_s * delta_s) + (rdr * r + vdr * v) * delta_r)
        m.u += dt * u_dot
        m.v += dt * (a * force + b * torque)
        m.r += dt * (c * force + d * torque) / length

    def freeze(self) -> MotionMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: MotionMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
