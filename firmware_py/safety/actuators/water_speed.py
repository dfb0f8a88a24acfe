"""The speed through the water, and the current: what the DVL measures over the bottom is the sum of both.

An extended Kalman filter of three states: the speed u through the water, ahead, and the current, north and east. Thrust
and drag drive u,

    u_dot = k (u_n |u_n| s - u |u|) + turn v r + lift,

where u_n is the speed that belongs to the propeller's, s the share of its thrust (1, or 0 if it is lost), v the sway
through the water that rate of turn and rudder make, and lift what buoyancy beyond weight does at this pitch. The DVL
measures u and v plus what the current adds along and across the hull. Ahead, drag tells the two apart: after 10 s to
0.2 m/s, after a minute to 0.1; aside the modelled sway does, as far as eddies let it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import EDDY_TIME
from firmware_py.vehicle.linear_models import steering_model
from firmware_py.vehicle.vehicle import Vehicle

_CRUISE = 1.8
"""Speed for which the eddies' drag is computed, m/s."""
_CHANGE = 0.03
"""How the current changes, as a random walk, m/s/sqrt(s): 0.3 m/s in 100 s."""
_DVL_STD = 0.02
"""Noise of a ping, m/s."""
_KNOWN = 0.05
"""1 sigma of a speed that counts as known, as share of it."""
_CLIMBS = 20.0
"""Climbs and dives last for so long, s; 2 sigma of buoyancy count, for else sound fins would be called weak."""
_TURN = 0.5
"""What braking in a turn is off by: so much of v r, for about a second."""


class WaterSpeed(NamedTuple):
    """Estimate: u, current north and east, m/s, and their covariance, m^2/s^2."""

    u: float
    north: float
    east: float
    uu: float
    un: float
    ue: float
    nn: float
    ne: float
    ee: float

    @property
    def least(self) -> float:
        """Return u less what its 1 sigma is beyond 5 %, m/s: so little is lost in the errors of the fins' model."""
        return self.u - max(0.0, math.sqrt(max(0.0, self.uu)) - _KNOWN * abs(self.u))

    def along(self, psi: float) -> float:
        """Return the current along the heading psi, rad, m/s."""
        return self.north * math.cos(psi) + self.east * math.sin(psi)

    def across(self, psi: float) -> float:
        """Return the current to starboard, m/s."""
        return self.east * math.cos(psi) - self.north * math.sin(psi)

    def across_std(self, psi: float) -> float:
        """Return its 1 sigma, m/s."""
        s, c = math.sin(psi), math.cos(psi)
        return math.sqrt(max(0.0, self.nn * s * s - 2.0 * self.ne * s * c + self.ee * c * c))


class Surge(NamedTuple):
    """What drives the speed between two pings, `dt` s apart.

    `thrust` is u_n |u_n|, m^2/s^2; `turning` the braking in a turn, m/s^2; `lift` what buoyancy does, m/s^2; `off` what
    all may be off by, m/s^2.
    """

    thrust: float
    turning: float
    lift: float
    dt: float
    off: float = 0.0


class WaterSpeedFilter:
    """Predicts and corrects a `WaterSpeed` of one vehicle."""

    def __init__(self, vehicle: Vehicle, current: float, eddies: float) -> None:
        """Design it.

        Args:
            vehicle: its hull and its propeller.
            current: the strongest current, 2 sigma, m/s.
            eddies: the strongest eddies, 1 sigma, m/s.

        Raises:
            ParamError: the vehicle has no inertia in sway and yaw.
        """
        hull, body, propeller, c = vehicle.hull, vehicle.body, vehicle.propeller, vehicle.coefficients
        half = 0.5 * hull.density * hull.length**2
        inertia = body.mass - half * hull.length * c.X_udot
        self.k, self._lift = vehicle.surge_drag, vehicle.lift_ahead
        self._unweighed = 2.0 * vehicle.unweighed_ahead * math.sqrt(2.0 * _CLIMBS)
        self._current_variance = (0.5 * current) ** 2
        self._turn = (body.mass + half * hull.length * c.X_vr) / inertia
        ((damping, turning, _), *_), (rudder, *_) = steering_model(vehicle, 1.0)
        self._sway = damping, turning, rudder
        self._fin_drag = abs(c.X_drdr) / propeller.C_d0, abs(c.X_dsds) / propeller.C_d0
        self._surge_noise = (2.0 * self.k * _CRUISE * eddies) ** 2 * 2.0 * EDDY_TIME
        self._sway_noise = eddies * eddies * 2.0 * EDDY_TIME

    def begin(self, u: float, psi: float) -> WaterSpeed:
        """Return what a first ping tells: u over the bottom, m/s, at the heading psi, rad."""
        s, c, p = math.sin(psi), math.cos(psi), self._current_variance
        return WaterSpeed(u, 0.0, 0.0, p + _DVL_STD**2, -p * c, -p * s, p, 0.0, p)

    def again(self, x: WaterSpeed, u: float, psi: float, dt: float) -> WaterSpeed:
        """Return what a ping tells dt, s, after the last one: the current has walked on, the speed is not known."""
        s, c, walk = math.sin(psi), math.cos(psi), _CHANGE * _CHANGE * max(dt, 0.0)
        most = self._current_variance
        nn, ee = min(x.nn + walk, most), min(x.ee + walk, most)
        uu = nn * c * c + ee * s * s + _DVL_STD**2
        return WaterSpeed(u - x.along(psi), x.north, x.east, uu, -nn * c, -ee * s, nn, 0.0, ee)

    def widened(self, x: WaterSpeed) -> WaterSpeed:
        """Return the estimate if the current has just changed: both components as if they were not known."""
        return x._replace(nn=x.nn + self._current_variance, ee=x.ee + self._current_variance)

    def sway(self, v: float, u: float, r: float, delta_r: float, dt: float) -> float:
        """Return the sway through the water after dt, s, from v, m/s, at the rate of turn r, rad/s, and rudder, rad."""
        damping, turning, rudder = self._sway
        u = max(u, 0.0)
        return v + dt * u * (damping * v + turning * r + u * rudder * delta_r)

    def braking(self, v: float, r: float) -> float:
        """Return the acceleration that sway v and rate of turn r make ahead, m/s^2."""
        return self._turn * v * r

    def lift(self, theta: float) -> float:
        """Return the acceleration that buoyancy beyond weight makes ahead at this pitch, rad, m/s^2."""
        return self._lift * math.sin(theta)

    def unweighed(self, theta: float) -> float:
        """Return what buoyancy may do beyond that, for about a second at a time, m/s^2."""
        return self._unweighed * math.sin(theta)

    def fin_drag(self, u: float, rudder: float, planes: float) -> float:
        """Return the deceleration that fins make at these angles, rad, m/s^2."""
        return self.k * u * u * (self._fin_drag[0] * rudder * rudder + self._fin_drag[1] * planes * planes)

    def predict(self, x: WaterSpeed, surge: Surge, share: float) -> WaterSpeed:
        """Return the estimate a time later; `share` is that of its thrust which the propeller has."""
        u, north, east, uu, un, ue, nn, ne, ee = x
        thrust, turning, lift, dt, _ = surge
        f = 1.0 - 2.0 * self.k * abs(u) * dt
        noise = self._surge_noise + (_TURN * turning) ** 2 + surge.off * surge.off
        u += dt * (self.k * (share * thrust - u * abs(u)) + turning + lift)
        walk = _CHANGE * _CHANGE * dt
        uu = f * f * uu + dt * noise
        return WaterSpeed(u, north, east, uu, f * un, f * ue, nn + walk, ne, ee + walk)

    def hear_ahead(self, x: WaterSpeed, measured: float, psi: float, theta: float) -> tuple[WaterSpeed, float]:
        """Take u of a ping, m/s; return the estimate, and the log-likelihood of the ping."""
        level = math.cos(theta)
        return _correct(x, measured, 1.0, level * math.cos(psi), level * math.sin(psi), _DVL_STD**2)

    def hear_aside(self, x: WaterSpeed, measured: float, psi: float, dt: float) -> WaterSpeed:
        """Take v of a ping less the sway through the water, m/s, dt, s, after the one before.

        Eddies, which stay for a while, are what it is off by: so one ping counts little.
        """
        return _correct(x, measured, 0.0, -math.sin(psi), math.cos(psi), self._sway_noise / dt)[0]


def _correct(x: WaterSpeed, measured: float, a: float, b: float, c: float, variance: float) -> tuple[WaterSpeed, float]:
    """Return the estimate after a measurement of a u + b north + c east, and its log-likelihood."""
    u, north, east, uu, un, ue, nn, ne, ee = x
    g_u, g_n, g_e = a * uu + b * un + c * ue, a * un + b * nn + c * ne, a * ue + b * ne + c * ee
    s = a * g_u + b * g_n + c * g_e + variance
    e = measured - a * u - b * north - c * east
    k_u, k_n, k_e = g_u / s, g_n / s, g_e / s
    return (
        WaterSpeed(
            u + k_u * e,
            north + k_n * e,
            east + k_e * e,
            uu - k_u * g_u,
            un - k_u * g_n,
            ue - k_u * g_e,
            nn - k_n * g_n,
            ne - k_n * g_e,
            ee - k_e * g_e,
        ),
        -0.5 * (e * e / s + math.log(s)),
    )
