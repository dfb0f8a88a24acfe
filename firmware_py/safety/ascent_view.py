"""What the procedure of coming up looks at in one tick."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import WeightState
from firmware_py.safety.conditions import Conditions
from firmware_py.safety.plane_jam import PlaneJam
from firmware_py.tick import Tick

_TOO_STEEP = math.radians(70.0)
"""At a greater pitch the propeller drives it up no longer in a way that anything steers."""


class AscentView(NamedTuple):
    """What the procedure looks at in one tick (s, m, rad, m/s).

    `z`, `z_dot`, `u` and `altitude` as estimated, `through` the speed through the water as far as the current is sure;
    `depth_ok`, `attitude_ok` and `speed_ok` say whether depth, attitude and `u` rest on measurements, and the attitude
    on such as nothing contradicts; `fix` that a position fix is heard; `jam` what the planes do that are known to be
    stuck, `weight` where the drop weight is, `too_low` whether the rule on the altitude says so, `rise_slope` how
    steeply the bottom rises against the way through the water.
    """

    t: float
    dt: float
    attitude_ok: bool
    depth_ok: bool
    speed_ok: bool
    z: float
    z_dot: float
    phi: float
    theta: float
    u: float
    through: float
    altitude: float
    fix: bool
    jam: PlaneJam
    weight: WeightState = WeightState.UNREPORTED
    too_low: bool = False
    rise_slope: float = 0.0

    def driven_up(self, least: float) -> bool:
        """Return whether the propeller drives it up: the bow is up by `least`, rad, and no plane known to be stuck."""
        return self.attitude_ok and least < self.theta < _TOO_STEEP and self.jam is PlaneJam.NONE


def view_of(
    tick: Tick, state: StateEstimate, jam: PlaneJam, weight: WeightState, c: Conditions, low: bool
) -> AscentView:
    """Return the view of a tick, in which `c` is what the rules look at, `low` whether it is too near to the bottom."""
    ok = c.attitude_ok and not c.sensors.ahrs.tilt_doubted, c.depth_ok, state.velocity_ok
    seen = c.depth, c.z_dot, state.eta.phi, state.eta.theta, state.nu.u, state.through_water_sure, c.altitude
    return AscentView(tick.t, tick.dt, *ok, *seen, c.fix_heard, jam, weight, low, c.rise_slope)
