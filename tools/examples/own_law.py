"""A control law of one's own, a PD law with two parameters, against the sliding-mode law that is built in."""

from dataclasses import dataclass

import numpy as np
import sternplane
from first_flight import DIVE


@dataclass(frozen=True)
class Gains:
    """Declared once: checked in TOML, in `params` and on the command line (autopilot.control.own.k_psi=3)."""

    k_z: float = sternplane.param(0.13, low=0.0, high=1.0, doc="Pitch per depth error, rad/m.")
    k_psi: float = sternplane.param(4.0, low=0.0, high=20.0, doc="Rudder per heading error.")


class PdLaw(sternplane.Law):
    """Depth by pitch, heading by rudder; the propeller is left to the built-in speed control."""

    Params = Gains

    def update(self, tick, reference, state):
        """Return stern planes and rudder, rad."""
        theta_d = np.clip(self.params.k_z * (state.eta.z - reference.z_d), -0.26, 0.26)
        delta_s = 5.5 * (state.eta.theta - theta_d) + 3.5 * state.nu.q
        delta_r = self.params.k_psi * sternplane.wrap(state.eta.psi - reference.psi_d) + 5.0 * state.nu.r
        return delta_s, delta_r


if __name__ == "__main__":
    flights = {"sliding": sternplane.fly(DIVE), "mine": sternplane.fly(DIVE, law=PdLaw, params={"law": {"k_psi": 5.0}})}
    for name, flight in flights.items():
        print(f"{name}: depth {flight.summary['depth_tracking_error_rms_m']:.3f} m rms off")
    print(sternplane.replay(flights["mine"].recording))
    sternplane.plot(flights).savefig("own_law.png")
