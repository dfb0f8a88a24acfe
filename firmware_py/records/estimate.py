"""What the vehicle believes about itself."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_py.marine import Eta, Nu


@dataclass(frozen=True, slots=True)
class StateEstimate:
    """The estimators' answer for one tick.

    `eta` and `nu` as in SNAME (`nu` over the ground); `position_std` 1 sigma of (x, y) together, m; `depth_std`
    of z, m; `velocity_std` of u and v, m/s; `altitude` above the bottom, m, NaN when unknown. The `*_ok` flags say
    whether attitude, depth and velocity rest on measurements that are fresh enough to steer by; `leak` that water was
    found.
    """

    eta: Eta
    nu: Nu
    position_std: float
    depth_std: float
    velocity_std: float
    altitude: float
    attitude_ok: bool
    depth_ok: bool
    velocity_ok: bool
    leak: bool
