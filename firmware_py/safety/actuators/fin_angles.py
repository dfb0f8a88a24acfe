"""Where fins are: by their reports, or else where a servo goes that obeys its commands.

The rates of turn by which fins are judged are means over a step. What changes such a mean from one step to the next is
the moment between the middles of both, on the average that between the two steps: so angles count a step later.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.records.command import Applied
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.vehicle.servo import SERVO_TIME

AnglesMemory = tuple[tuple[float, ...], tuple[float, ...]]
"""Of each fin the angle of a modelled servo, and the one that counted in the last step, rad."""


class Told(NamedTuple):
    """Of the fins of one axis, in its order: the angles when a step began, rad, and the places that report nothing."""

    angles: tuple[float, ...]
    mute: tuple[int, ...]


class FinAngles:
    """The angles of the fins of one axis."""

    def __init__(self, params: ActuatorParams, count: int) -> None:
        self._params, self._modelled, self._last = params, [0.0] * count, [0.0] * count

    def freeze(self) -> AnglesMemory:
        """Return the whole memory."""
        return tuple(self._modelled), tuple(self._last)

    def thaw(self, memory: AnglesMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._modelled, self._last = [list(angles) for angles in memory]

    def update(self, fins: Sequence[int], t: float, frame: SensorFrame, applied: Applied, dt: float) -> Told:
        """Return where these fins were when the step began."""
        params, modelled, last = self._params, self._modelled, self._last
        angles, mute = [], []
        for place, i in enumerate(fins):
            heard = frame.fins[i]
            angle = modelled[i] = modelled[i] + (applied.fins[i] - modelled[i]) * (dt / SERVO_TIME)
            age = t - heard.t_valid if heard.ok else math.inf
            angles.append(last[i])
            last[i] = heard.value if age <= params.latency else angle
            if not age <= params.timeout:
                mute.append(place)
        return Told(tuple(angles), tuple(mute))
