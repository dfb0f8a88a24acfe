"""What turns the vehicle, pitch and yaw, at any speed: from the linear models, for the actuator watch."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.vehicle.fins import deflection_rows
from firmware_py.vehicle.linear_models import diving_model, steering_model
from firmware_py.vehicle.vehicle import Vehicle

CRUISE = 1.8
"""Speed for which the eddies' moment is computed, m/s; it grows in proportion."""
_EDDY_TIME = 10.0
"""Correlation time of eddies, s."""


class Axis(NamedTuple):
    """One axis: its angular acceleration, by speed u and crosswise velocity c (w in pitch, v in yaw).

    Attributes:
        damping: of the rate, by u, 1/m.
        crosswise: by u c, 1/m^2.
        restoring: by the sine of pitch, 1/s^2; 0 in yaw.
        fins: by u^2, of each fin's angle, 1/m^2 by the radian.
    """

    damping: float
    crosswise: float
    restoring: float
    fins: tuple[float, ...]

    def eddies(self, speed: float) -> float:
        """Return what eddies of that speed (1 sigma, m/s) do, as a random walk, rad/s^2/sqrt(s)."""
        return abs(self.crosswise) * CRUISE * speed * math.sqrt(2.0 / _EDDY_TIME)


def pitch_axis(vehicle: Vehicle) -> Axis:
    """Return the axis of the stern planes and bow planes.

    Raises:
        ParamError: the vehicle has no inertia in pitch.
    """
    ((damping, restoring, _), *_), (control, *_) = diving_model(vehicle, 1.0)
    c = vehicle.coefficients
    return Axis(
        damping, control * c.M_w / c.M_ds, restoring, tuple([control * share for share in vehicle.effectiveness.s])
    )


def yaw_axis(vehicle: Vehicle) -> Axis:
    """Return the axis of the rudders.

    Raises:
        ParamError: the vehicle has no inertia in sway and yaw.
    """
    (_, (crosswise, damping, _), _), (_, control, _) = steering_model(vehicle, 1.0)
    return Axis(damping, crosswise, 0.0, tuple([control * share for share in deflection_rows(vehicle.fins)[1]]))
