"""Where fins are: by their reports, or else where a servo goes that obeys its commands."""

from __future__ import annotations

import math
from collections.abc import Sequence

from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.vehicle.servo import SERVO_TIME


class FinAngles:
    """The angles of all fins; `modelled` is what is remembered, rad."""

    def __init__(self, params: ActuatorParams, count: int) -> None:
        self._params, self.modelled = params, [0.0] * count

    def update(
        self, fins: Sequence[int], t: float, frame: SensorFrame, applied: Applied, dt: float
    ) -> tuple[tuple[float, ...], tuple[int, ...]]:
        """Return the angles, rad, of these fins, and the places among them of those that report nothing."""
        params, modelled = self._params, self.modelled
        angles, mute = [], []
        for place, i in enumerate(fins):
            heard = frame.fins[i]
            angle = modelled[i] = modelled[i] + (applied.fins[i] - modelled[i]) * (dt / SERVO_TIME)
            age = t - heard.t_valid if heard.ok else math.inf
            angles.append(heard.value if age <= params.latency else angle)
            if not age <= params.timeout:
                mute.append(place)
        return tuple(angles), tuple(mute)
