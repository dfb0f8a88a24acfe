"""Whether the AHRS may speak against fins: fresh, believed, not too steep, and there all along.

One that was away may be late for good, and nothing but its stamp would tell, which DroneCAN does not carry: 1 s late it
convicted sound fins of having no effect. So for two minutes after it was lost in flight only reports speak of fins.
"""

from __future__ import annotations

import math

from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import SourceState
from firmware_py.records.sensing import SensorFrame

_PITCH_MAX, _ROLL_MAX = math.radians(45.0), math.radians(30.0)
"""In a steeper dive the model does not hold; rolled over farther, planes steer and rudders dive."""
_STALE = 0.1
"""An older attitude, s, is none."""
_AWAY = 120.0
"""So long, s, an AHRS that was away is no witness."""


class AttitudeWitness:
    """Remembers when the AHRS was away last while armed, `t_away`, s."""

    def __init__(self) -> None:
        self.t_away = -math.inf

    def hear(self, t: float, state: StateEstimate, armed: bool) -> None:
        """Take note at the time t, s, of whether it is there."""
        if armed and state.sensors.ahrs.state is SourceState.LOST:
            self.t_away = t

    def speaks(self, t: float, frame: SensorFrame, state: StateEstimate) -> bool:
        """Return whether rates and angles may speak against fins at the time t, s."""
        return (
            -_PITCH_MAX < state.eta.theta < _PITCH_MAX
            and -_ROLL_MAX < state.eta.phi < _ROLL_MAX
            and state.attitude_ok
            and t - frame.ahrs.t_valid < _STALE
            and state.sensors.ahrs.state is SourceState.GOOD
            and t - self.t_away >= _AWAY
        )
