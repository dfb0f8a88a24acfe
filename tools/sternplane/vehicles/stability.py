"""Poles of the hull without its laws, over speed: diving (w, q, theta), steering (v, r) and rolling (p, phi).

Linear about straight and level motion at the speed u at which thrust balances drag, by vehicle.toml alone (Fossen 2011,
ch. 7.5; the terms of added mass in u are part of Z_w, M_w, Y_r and N_r, as tables have them).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from firmware_py.vehicle.linear_models import steering_model
from firmware_py.vehicle.vehicle import Vehicle


class Poles(NamedTuple):
    """Poles at a speed, 1/s."""

    u: float
    diving: tuple[complex, ...]
    steering: tuple[complex, ...]
    rolling: tuple[complex, ...]

    def worst(self, plane: str) -> float:
        """Return the greatest real part in a plane, 1/s: what grows, if it is above 0."""
        return max([float(pole.real) for pole in getattr(self, plane)])


def poles(vehicle: Vehicle, u: float) -> Poles:
    """Return the poles at speed u, m/s.

    Raises:
        ParamError: no inertia is left in sway and yaw.
    """
    steering = np.array([row[:2] for row in steering_model(vehicle, u).A[:2]])
    planes = (_diving(vehicle, u), steering, _rolling(vehicle, u))
    return Poles(u, *(tuple(complex(pole) for pole in np.linalg.eigvals(matrix)) for matrix in planes))


def poles_over(vehicle: Vehicle, speeds: Sequence[float]) -> tuple[Poles, ...]:
    """Return the poles at each speed, m/s."""
    return tuple(poles(vehicle, u) for u in speeds)


def doubling_time(growth: float) -> float:
    """Return in what time a motion of that growth, 1/s, doubles, s; infinite if it fades."""
    return math.log(2.0) / growth if growth > 0.0 else math.inf


def righting(vehicle: Vehicle) -> float:
    """Return the righting moment by the sine of pitch or roll, N m."""
    body = vehicle.body
    return body.z_G * body.weight - body.z_B * body.buoyancy


def _diving(vehicle: Vehicle, u: float) -> np.ndarray:
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    L, half = hull.length, 0.5 * hull.density * hull.length**2
    m, x_G = body.mass, body.x_G
    mass = np.array(
        [
            [m - half * L * c.Z_wdot, -m * x_G - half * L**2 * c.Z_qdot],
            [-m * x_G - half * L**2 * c.M_wdot, body.I_y - half * L**3 * c.M_qdot],
        ]
    )
    force = np.array(
        [
            [half * u * c.Z_w, (half * L * c.Z_q + m) * u, 0.0],
            [half * L * u * c.M_w, (half * L**2 * c.M_q - m * x_G) * u, -righting(vehicle)],
        ]
    )
    return np.vstack([np.linalg.solve(mass, force), [0.0, 1.0, 0.0]])


def _rolling(vehicle: Vehicle, u: float) -> np.ndarray:
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    scale = 0.5 * hull.density * hull.length**4
    inertia = body.I_x - scale * hull.length * c.K_pdot
    return np.array([[scale * u * c.K_p / inertia, -righting(vehicle) / inertia], [1.0, 0.0]])
