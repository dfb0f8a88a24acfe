"""An estimator of one's own, and a sensor of one's own that it uses: the depth from a second, better instrument."""

from dataclasses import replace

import numpy as np
import sternplane
from first_flight import DIVE


class Altimeter(sternplane.PayloadSensor):
    """A simulated instrument, ten times a second; a real one sends the same key over the CAN bus (KeyValue)."""

    keys = ("reference.depth",)

    def measure(self, plant, chance):
        """Return the true depth with 1 mm of noise, m."""
        return (plant.eta.z + 0.001 * chance.standard_normal(),)


class DepthEstimator(sternplane.StateEstimator):
    """The built-in estimate, but for the depth: integrated, and corrected by the better instrument."""

    z = None

    def update(self, tick, frame, applied, built_in):
        """Return the state; what is not replaced stays as the built-in estimator has it."""
        self.z = built_in.eta.z if self.z is None else self.z + built_in.z_dot * tick.dt
        for reading in frame.payload:
            self.z += 0.5 * (reading.value - self.z)
        return replace(built_in, eta=built_in.eta._replace(z=self.z), depth_std=0.001)


if __name__ == "__main__":
    for estimator in (None, DepthEstimator):
        flown = sternplane.fly(DIVE, estimator=estimator, sensors=[Altimeter]).recording
        error = flown.estimate["z"] - flown.truth["z"]
        print(f"{estimator.__name__ if estimator else 'built in'}: {1000 * np.sqrt(np.mean(error**2)):.1f} mm rms")
