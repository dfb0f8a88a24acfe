"""What the procedure of coming up looks at in one tick."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.estimate import StateEstimate
from firmware_py.safety.plane_jam import PlaneJam
from firmware_py.tick import Tick


class AscentView(NamedTuple):
    """What the procedure looks at in one tick (s, m, rad, m/s).

    `z`, `z_dot` and `altitude` as estimated; `depth_ok`, `attitude_ok` and `speed_ok` say whether depth, attitude and
    `u` rest on measurements; `fix` that a position fix is heard; `jam` what the planes do that are known to be stuck.
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
    altitude: float
    fix: bool
    jam: PlaneJam


def view_of(
    tick: Tick, state: StateEstimate, jam: PlaneJam, attitude_ok: bool, depth_ok: bool, fix: bool
) -> AscentView:
    """Return the view of a tick; `attitude_ok`, `depth_ok` and `fix` as the supervisor judges them."""
    (_, _, z, phi, theta, _), (u, v, w, _, _, _) = state.eta, state.nu
    z_dot = math.cos(theta) * (math.sin(phi) * v + math.cos(phi) * w) - math.sin(theta) * u
    seen = (attitude_ok, depth_ok, state.velocity_ok, z, z_dot, phi, theta, u, state.altitude, fix, jam)
    return AscentView(tick.t, tick.dt, *seen)
