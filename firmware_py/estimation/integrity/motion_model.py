"""Surge, sway and yaw that propeller and rudder make: what the hull does by its model, whatever its sensors say.

Thrust, drag and buoyancy drive the speed; the steering model (`vehicle.turning`), and cross-flow drag beside it, turns
the hull; turning brakes it. All through the water. The steering coefficients are those of vehicle.toml, until it is
told others.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from firmware_py.vehicle.linear_models import SteeringCoefficients, steering_model
from firmware_py.vehicle.turning import yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

_SLOWEST = 0.1
"""Slower than this the rudder does nothing, m/s."""
_STATIONS = (-0.4, -0.2, 0.0, 0.2, 0.4)
"""Where cross-flow drag is summed up, of the length."""


@dataclass(slots=True)
class MotionMemory:
    """Surge and sway through the water, m/s, rate of turn, rad/s.

    `braked` is how much slower, m/s, the fins have made it, `unweighed` how much buoyancy that nobody knows may have
    made it faster or slower; `brakes` is what turning and fins do to it now, m/s^2.
    """

    u: float = 0.0
    v: float = 0.0
    r: float = 0.0
    braked: float = 0.0
    unweighed: float = 0.0
    brakes: float = 0.0


class MotionModel:
    """The model of one vehicle; `trim` is the speed at its propeller's trim point, m/s."""

    def __init__(self, vehicle: Vehicle) -> None:
        hull, c, propeller = vehicle.hull, vehicle.coefficients, vehicle.propeller
        length = hull.length
        self._ratio, self.trim = propeller.u_trim / propeller.n_trim, propeller.u_trim
        self._vehicle, self._yaw, self._length = vehicle, yaw_axis(vehicle), length
        only_Y = SteeringCoefficients(0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
        only_N = SteeringCoefficients(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        self._by_force = steering_model(vehicle, 1.0, only_Y).b
        self._by_moment = steering_model(vehicle, 1.0, only_N).b
        self._cross = -hull.C_dy * hull.height / (len(_STATIONS) * length)
        mass = vehicle.body.mass / (0.5 * hull.density * length**3)
        surge = mass - c.X_udot
        self._drag, self._turn = propeller.C_d0 / (surge * length), (mass + c.X_vr) / surge
        brakes = (c.X_vv / length, c.X_rr * length, c.X_drdr / length, c.X_dsds / length, c.X_rdr, c.X_vdr / length)
        self._brakes = tuple(x / surge for x in brakes)
        self._lift, self._unweighed = vehicle.lift_ahead, vehicle.unweighed_ahead
        self._fins = vehicle.deflection_rows
        self.memory = MotionMemory()

    def follow(self, steering: SteeringCoefficients) -> None:
        """Let the rudder turn the hull by other coefficients than those of the vehicle file from now on."""
        self._yaw = yaw_axis(self._vehicle, steering)

    def speed(self, n: float) -> float:
        """Return the speed that belongs to a propeller speed, rev/s, in the end, m/s."""
        return n * self._ratio

    def deflections(self, fins: list[float]) -> tuple[float, float]:
        """Return delta_s and delta_r for fin angles, rad."""
        s, r, _ = self._fins
        return sum(a * b for a, b in zip(s, fins, strict=True)), sum(a * b for a, b in zip(r, fins, strict=True))

    def step(self, dt: float, n: float, theta: float, delta_s: float, delta_r: float) -> None:
        """Go on by dt, s, at the propeller speed n, rev/s, with pitch, stern planes and rudder at these angles, rad."""
        m, length, yaw = self.memory, self._length, self._yaw
        u, v, r = max(m.u, _SLOWEST), m.v, m.r
        force = moment = 0.0  # of cross-flow, over rho/2 L^2 and rho/2 L^3
        for x in _STATIONS:
            flow = v + x * length * r
            drag = self._cross * flow * abs(flow)
            force += drag
            moment += x * drag
        v_dot = u * (yaw.sway[0] * v + yaw.sway[1] * r + yaw.sway[2] * u * delta_r)
        r_dot = u * (yaw.crosswise * v + yaw.damping * r + yaw.control * u * delta_r)
        v_dot += self._by_force[0] * force + self._by_moment[0] * moment
        r_dot += self._by_force[1] * force + self._by_moment[1] * moment
        pull = self.speed(n)
        vv, rr, drdr, dsds, rdr, vdr = self._brakes
        u_dot = self._drag * (pull * abs(pull) - m.u * abs(m.u))
        fins = drdr * delta_r * delta_r + dsds * delta_s * delta_s
        m.brakes = self._turn * v * r + vv * v * v + rr * r * r + u * (u * fins + (rdr * r + vdr * v) * delta_r)
        fades = 2.0 * self._drag * u
        m.braked -= dt * (u * u * fins + fades * m.braked)
        m.unweighed += dt * (self._unweighed * abs(math.sin(theta)) - fades * m.unweighed)
        m.u += dt * (u_dot + m.brakes + self._lift * math.sin(theta))
        m.v += dt * v_dot
        m.r += dt * r_dot

    def freeze(self) -> MotionMemory:
        """Return the whole memory."""
        return copy.copy(self.memory)

    def thaw(self, memory: MotionMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self.memory = copy.copy(memory)
