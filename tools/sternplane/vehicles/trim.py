"""Level flight: the pitch and the stern planes that hold depth against weight, buoyancy and their levers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from firmware_py.vehicle.vehicle import Vehicle
from sternplane.vehicles.stability import righting


class Level(NamedTuple):
    """Straight and level motion at a speed: pitch and stern planes, rad, and the share of their travel."""

    u: float
    theta: float
    delta_s: float
    share: float


def level(vehicle: Vehicle, u: float) -> Level:
    """Return level motion at speed u, m/s, linear in pitch: w = u theta, and no force or moment is left.

    The angles are infinite where hull and planes cannot do it.
    """
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    half, L = 0.5 * hull.density * hull.length**2, hull.length
    heavy = body.weight - body.buoyancy
    nose = body.x_G * body.weight - body.x_B * body.buoyancy
    matrix = np.array(
        [
            [half * u * u * c.Z_w, half * u * u * c.Z_ds],
            [half * L * u * u * c.M_w - righting(vehicle), half * L * u * u * c.M_ds],
        ]
    )
    most = vehicle.effectiveness.delta_s_max
    if abs(np.linalg.det(matrix)) < 1e-12 * abs(matrix).max() ** 2:
        return Level(u, math.inf, math.inf, math.inf)
    theta, delta_s = np.linalg.solve(matrix, [-heavy, nose])
    return Level(u, float(theta), float(delta_s), abs(float(delta_s)) / most)


def least_level_speed(vehicle: Vehicle, top: float, share: float = 1.0) -> float:
    """Return the least speed above which planes hold it level with that share of their travel, m/s; infinite: none."""
    speeds = np.linspace(0.05 * top, top, 96)
    good = [one.share <= share and abs(one.theta) < math.radians(30.0) for one in (level(vehicle, u) for u in speeds)]
    if not good[-1]:
        return math.inf
    bad = [i for i, held in enumerate(good) if not held]
    return float(speeds[bad[-1] + 1]) if bad else 0.0
