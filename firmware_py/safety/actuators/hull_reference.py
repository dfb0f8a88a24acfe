"""What the fins of each axis are held to: the model of vehicle.toml, or of the coefficients that held in flight."""

from __future__ import annotations

import math

from firmware_py.safety.actuators.hull_memory import Values
from firmware_py.vehicle.linear_models import DivingCoefficients, SteeringCoefficients
from firmware_py.vehicle.turning import pitch_axis, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

CRUISE = 1.8
"""Speed for which the eddies' moment is computed, m/s; it grows in proportion."""
_STEP = 1.2
"""Filters are designed anew for eddies that do more, or less, by such a factor: seldom, as that takes a millisecond."""


class HullReference:
    """The models of pitch (axis 0) and yaw (axis 1).

    Attributes:
        models: what each axis is judged by.
        values: the coefficients of these; empty is vehicle.toml.
        eddies: what the strongest eddies do by them as a random walk, rad/s^2/sqrt(s), in steps of a fifth.
    """

    def __init__(self, vehicle: Vehicle, std: float) -> None:
        """Begin with vehicle.toml; `std` is that of the strongest eddies, m/s.

        Raises:
            ParamError: the vehicle has no inertia.
        """
        self._vehicle, self._std = vehicle, std
        self.models = [pitch_axis(vehicle), yaw_axis(vehicle)]
        self.values: list[Values] = [(), ()]
        self.eddies = [model.eddies(CRUISE, std) for model in self.models]
        self._files = tuple(self.eddies)

    def refer(self, axis: int, values: Values) -> bool:
        """Judge an axis by these coefficients from now on, by vehicle.toml if there are none.

        Return whether eddies do something else by them: they turn a hull by what its coefficients make of them.
        """
        self.values[axis] = values
        if axis:
            self.models[1] = yaw_axis(self._vehicle, SteeringCoefficients(*values) if values else None)
        else:
            self.models[0] = pitch_axis(self._vehicle, DivingCoefficients(*values) if values else None)
        file, before = self._files[axis], self.eddies[axis]
        now = self.models[axis].eddies(CRUISE, self._std)
        steps = round(math.log(now / file, _STEP)) if file > 0.0 < now else 0
        self.eddies[axis] = file * _STEP**steps
        return self.eddies[axis] != before
