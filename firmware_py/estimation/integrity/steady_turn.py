"""How well it is known how fast a rudder that is held turns the hull in the end (`vehicle.turning.steady_turn`).

As coefficients are off by their 1 sigma, so is G: each
is varied by itself, and the logarithms of what becomes of G are added as independent. The filter's errors of two
coefficients mostly cancel in G, which it sees better than either: this is the careful side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_py.vehicle.linear_models import SteeringCoefficients
from firmware_py.vehicle.turning import steady_turn, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle


def steady_turn_std(vehicle: Vehicle, steering: SteeringCoefficients, std: Sequence[float]) -> float:
    """Return 1 sigma of the logarithm of G, for that of each coefficient; infinite: G is not known at all."""
    believed, variance = steady_turn(yaw_axis(vehicle, steering)), 0.0
    for name, value, sigma in zip(steering._fields, steering, std, strict=True):
        if sigma == 0.0:
            continue
        most = 0.0
        for other in (value - sigma, value + sigma):
            ratio = steady_turn(yaw_axis(vehicle, steering._replace(**{name: other}))) / believed
            if not 0.0 < ratio < math.inf:
                return math.inf
            most = max(most, abs(math.log(ratio)))
        variance += most * most
    return math.sqrt(variance)
