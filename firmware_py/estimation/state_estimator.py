"""The base class of an estimator of one's own."""

from __future__ import annotations

from firmware_py.own_part import OwnPart
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick


class StateEstimator(OwnPart):
    """An estimator. It is asked in every tick, disarmed too.

    It may answer for eta, nu, their sigmas, the altitude, the water and what is learned. The built-in estimator alone
    says whether attitude, depth and velocity may be steered by, which sensors are believed, whether there is a leak.
    Guidance and laws fly by the answer, which is the estimate of the log; the supervisor goes by the built-in estimate,
    and so does SURFACE.
    """

    def update(self, tick: Tick, frame: SensorFrame, applied: Applied, built_in: StateEstimate) -> StateEstimate:
        """Return the state at the tick, as `dataclasses.replace(built_in, eta=..., nu=...)`.

        Args:
            tick: now.
            frame: what was heard, as sensors at the body's origin would have measured it, without what is not believed;
                `frame.payload` are sensors of one's own.
            applied: fins (rad) and propeller (rev/s) as they were commanded one tick ago.
            built_in: the answer of the built-in estimator.
        """
        raise NotImplementedError
