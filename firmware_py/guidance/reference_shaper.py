"""Setpoints made into a reference that the vehicle can follow.

No reference moves faster than the vehicle can: a dive is at most as steep as pitch_max, a turn at most as tight as
turn_radius, and both begin and end over a distance, not a time, since the fins' moment goes with u^2. At rest they
stand still, so a vehicle armed at u = 0 asks for nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.guidance_params import GuidanceParams
from firmware_py.guidance.reference_model import Lags, ReferenceModel
from firmware_py.marine import clip
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.manoeuvrability import RESERVE, UNLIMITED, Manoeuvrability
from firmware_py.records.order import Setpoint

_AT_REST = 0.1
"""Slower than this, m/s, is noise."""


class ShapedReference(NamedTuple):
    """Depth, heading and speed with the derivatives that the laws use (m, rad, s): the first of a `Reference`."""

    z_d: float
    z_d_dot: float
    z_d_ddot: float
    z_d_dddot: float
    psi_d: float
    psi_d_dot: float
    psi_d_ddot: float
    u_d: float


class ReferenceShaper:
    """The reference models of depth and heading, and the slope of speed."""

    def __init__(self, params: GuidanceParams) -> None:
        self._params = params
        self.depth = ReferenceModel(params.shape)
        self.heading = ReferenceModel(params.shape, angle=True)
        self._climb_share = math.sin(params.pitch_max)
        self.turning, self._left, self._caution, self._dive_share = params.turning, UNLIMITED, 0.0, 1.0

    def limit(self, left: Manoeuvrability, caution: float) -> None:
        """Ask for no tighter turns, steeper dives or slower ways than the vehicle can make.

        Args:
            left: what it can do.
            caution: how little is known of it, in [0, 1]; at 1 it climbs and turns at a share of its rates.
        """
        self._caution = caution
        if left is self._left:
            return
        self._left, self.turning = left, self._params.turning.widened(left.turn_radius)
        self._dive_share = math.sin(min(left.slope, 0.5 * math.pi)) if left.up < math.inf else 1.0

    def follow(self, state: StateEstimate) -> ShapedReference:
        """Return the vehicle's own depth, heading and speed, so that holding them begins without a bump."""
        u_d = min(state.nu.u, self._params.speed_max) if state.nu.u > _AT_REST else 0.0
        z_d = self.depth.reset(state.eta.z).d
        psi_d = self.heading.reset(state.eta.psi).d
        return ShapedReference(z_d, 0.0, 0.0, 0.0, psi_d, 0.0, 0.0, u_d)

    def update(self, wanted: Setpoint, u_d: float, u: float, dt: float) -> ShapedReference:
        """Move the reference towards what is wanted, from the speed reference `u_d` at the speed `u`, both m/s."""
        params, u = self._params, max(u, 0.0)
        share = 1.0 - self._caution * (1.0 - params.cautious)
        climb = share * min(params.climb_max, self._climb_share * u, self._dive_share * u)
        turn = share * min(params.turn_rate_max, u / params.turn_radius, RESERVE * self._left.turn * u)
        z_d, z_d_dot, z_d_ddot, z_d_dddot = self.depth.update(wanted.z_d, climb, u / params.depth_way, dt)
        psi_d, psi_d_dot, psi_d_ddot, _ = self.heading.update(wanted.psi_d, turn, u / params.heading_way, dt)
        step = params.acceleration * dt
        asked = wanted.u_d if not 0.0 < wanted.u_d < self._left.speed else min(self._left.speed, params.speed_max)
        u_d += clip(asked - u_d, -step, step)
        return ShapedReference(z_d, z_d_dot, z_d_ddot, z_d_dddot, psi_d, psi_d_dot, psi_d_ddot, u_d)

    def freeze(self) -> tuple[Lags, Lags]:
        """Return the memory of depth and of heading."""
        return self.depth.freeze(), self.heading.freeze()

    def thaw(self, depth: Lags, heading: Lags) -> None:
        """Take up again what `freeze` gave."""
        self.depth.thaw(depth)
        self.heading.thaw(heading)
