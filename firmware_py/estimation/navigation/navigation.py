"""Navigation: AHRS and gyro, the DVL held between its pings, depth from pressure, position by dead reckoning.

Each quantity has its own small filter (`attitude`, `velocity`, `depth`, `altitude`, `dead_reckoning`): pure functions
from memory to memory. Here they are put in order. A value that is not finite, out of range or from the future counts as
not received, so the answer is always finite (but `altitude`, NaN when unknown). Sensors are taken to sit at the body's
origin: `lever_arms` has brought there what they measure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.navigation import altitude, attitude, dead_reckoning, depth, velocity
from firmware_py.estimation.navigation.current_ahead import current_ahead
from firmware_py.estimation.navigation.velocity_params import VelocityParams
from firmware_py.marine import Eta, Nu, Origin, body_to_ned, depth_of_pressure
from firmware_py.params import param, table
from firmware_py.records.command import Applied
from firmware_py.records.estimate import NOTHING_LEARNED, Learned, StateEstimate
from firmware_py.records.health import ALL_GOOD, HEADING_FAULTS, SensorHealth
from firmware_py.records.sensing import SensorFrame
from firmware_py.tick import Tick

PITCHED = math.sin(math.radians(20.0))
"""Without an AHRS the pitch is not known: 1 sigma of its sine, and of the vertical velocity as a part of the speed. A
climb by a fixed stern angle has 20 deg."""


@dataclass(frozen=True)
class NavigationParams:
    """One table per filter, and the two sensors that need none."""

    attitude: attitude.AttitudeParams = table(attitude.AttitudeParams, mav="ATT_")
    velocity: VelocityParams = table(VelocityParams, mav="VEL_")
    depth: depth.DepthParams = table(depth.DepthParams, mav="DEP_")
    position: dead_reckoning.PositionParams = table(dead_reckoning.PositionParams, mav="POS_")
    altitude_timeout: float = param(
        2.0, unit="s", low=0.1, high=30.0, doc="An altitude older than this is unknown.", mav="ALT_TIMEOUT"
    )
    propeller_timeout: float = param(
        1.0,
        unit="s",
        low=0.1,
        high=30.0,
        doc="An older report of the propeller's speed gives way to the command.",
        mav="N_TIMEOUT",
    )
    humidity_max: float = param(
        80.0, unit="%", low=1.0, high=100.0, doc="More humidity in the hull than this is a leak.", mav="HUMID_MAX"
    )


class NavigationMemory(NamedTuple):
    """Everything the estimator remembers."""

    attitude: attitude.AttitudeMemory
    velocity: velocity.VelocityMemory
    depth: depth.DepthMemory
    position: dead_reckoning.PositionMemory


class KeptNavigation(NamedTuple):
    """What is worth keeping from one run to the next: position (m) with its 1 sigma, and the zero of depth (Pa)."""

    x: float
    y: float
    position_std: float
    surface_pressure: float


class Navigation:
    """Estimates the state from one frame per tick."""

    def __init__(self, params: NavigationParams, origin: Origin) -> None:
        self._params = params
        self._origin = origin
        self._memory = NavigationMemory(
            attitude.START, velocity.START, depth.start(params.depth), dead_reckoning.start(params.position)
        )

    def correct(self, depth: float, heading: float, fixes: float = math.nan) -> None:
        """Put depth (m) and heading (rad) right, where what they rest on has turned out to be wrong; NaN leaves one.

        What `fixes` since that time, s, have moved the position by is taken back.
        """
        was = self._memory
        if not math.isnan(fixes):
            was = was._replace(position=dead_reckoning.take_back(self._params.position, was.position, fixes))
        if not math.isnan(depth):
            was = was._replace(depth=was.depth._replace(z=depth))
        if not math.isnan(heading):
            was = was._replace(attitude=was.attitude._replace(psi=heading))
        self._memory = was

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        sensors: SensorHealth = ALL_GOOD,
        known: velocity.FilterVelocity | None = None,
        hull: velocity.HullVelocity | None = None,
        learned: Learned = NOTHING_LEARNED,
        refused: tuple[int, ...] = (),
        doubt: float = 0.0,
        port: float = 0.0,
    ) -> StateEstimate:
        """Return the state at the tick, from what was received up to it and what was commanded one tick ago.

        `sensors` is what is known of the sensors; what is not believed is not ok in the frame. `known` is the velocity
        of the coefficient filter, `hull` that of the vehicle's model, each None if it is not to be believed. `learned`
        and `refused` become part of the state as they are. `doubt` is what the position may be off by beside, m. `port`
        is how much more than in the frame the air's pressure is, Pa; see `depth.update`.
        """
        params, was, t, dt = self._params, self._memory, tick.t, tick.dt

        att = attitude.update(params.attitude, was.attitude, frame.ahrs, t)
        phi, theta, psi = attitude.angles(params.attitude, att, t)
        attitude_ok = t - att.t <= params.attitude.timeout

        motion = velocity.Motion(phi, theta, psi, self._propeller(frame, applied, t), hull)
        vel = velocity.update(params.velocity, was.velocity, frame.dvl, t, dt, motion, known)
        velocity_ok = t - vel.t <= params.velocity.timeout
        velocity_std = velocity.std(params.velocity, vel, t)
        _, _, z_dot = body_to_ned(phi, theta, psi, vel.u, vel.v, vel.w)

        pinged = t - vel.ping.t <= params.velocity.timeout
        z_dot_std = PITCHED * abs(vel.u) if not attitude_ok else 0.0 if pinged else velocity_std
        dep = depth.update(params.depth, was.depth, frame.pressure, t, dt, z_dot, z_dot_std, applied.armed, port)
        depth_ok = t - dep.t <= params.depth.timeout

        pos = dead_reckoning.go_by_pings(was.position) if pinged else was.position
        x, y, walk, drift, *_ = pos
        before = velocity.reckoned(params.velocity, was.velocity, t - dt)
        now = velocity.reckoned(params.velocity, vel, t)
        x_dot, y_dot, _ = body_to_ned(phi, theta, psi, now.u, now.v, now.w)
        carried = sensors.ahrs.fault in HEADING_FAULTS
        lasting = math.hypot(velocity.lasting_std(params.velocity, vel, t), hull.doubt if hull is not None else 0.0)
        rate = dead_reckoning.drift_rate(params.position, math.hypot(x_dot, y_dot), attitude_ok, carried, lasting)
        if not pinged:
            walk += dead_reckoning.wander_rate(vel.turbulence) * dt
        x, y, drift = x + x_dot * dt, y + y_dot * dt, drift + (rate + pos.astray) * dt
        gap = now.t - before.t
        if 0.0 < gap <= params.velocity.timeout:
            # The velocity went from the last one to this one while the last one was held.
            late = 0.5 * gap + t - now.t
            u, v, w = (now.u - before.u) * late, (now.v - before.v) * late, (now.w - before.w) * late
            dx, dy, _ = body_to_ned(phi, theta, psi, u, v, w)
            x, y = x + dx, y + dy
            if now.t == vel.ping.t:  # a ping's noise is new in every one
                walk += 2.0 * (now.std * gap) ** 2
        pos = pos._replace(x=x, y=y, walk=walk, drift=drift, jump=0.0, doubt=doubt)
        if not depth_ok or dep.z < params.position.fix_depth:
            pos = dead_reckoning.take_fix(params.position, pos, frame.fix, t, self._origin, (x_dot, y_dot), pinged)
        north, east, water_std = velocity.water(params.velocity, vel, t)

        self._memory = NavigationMemory(att, vel, dep, pos)
        return StateEstimate(
            eta=Eta(pos.x, pos.y, dep.z, phi, theta, psi),
            nu=Nu(vel.u, vel.v, vel.w, att.p, att.q, att.r),
            position_std=dead_reckoning.std(pos),
            depth_std=depth.std(params.depth, dep, t, z_dot_std),
            velocity_std=velocity_std,
            altitude=altitude.nearest(frame, t, params.altitude_timeout),
            attitude_ok=attitude_ok,
            depth_ok=depth_ok,
            velocity_ok=velocity_ok,
            leak=frame.leak.ok and frame.leak.value > params.humidity_max,
            sensors=sensors,
            velocity_source=vel.source,
            water=(north, east),
            water_std=water_std,
            current_ahead=current_ahead(params.velocity, vel, t, theta, psi) if attitude_ok else 0.0,
            fix_jump=pos.jump,
            refused=refused,
            learned=learned,
        )

    def depth_by(self, pressure: float) -> float:
        """Return the depth that a pressure, Pa, stands for, m."""
        return depth_of_pressure(pressure, self._memory.depth.zero, self._params.depth.density)

    def keep(self) -> KeptNavigation:
        """Return what a later run may start from."""
        pos, dep = self._memory.position, self._memory.depth
        return KeptNavigation(pos.x, pos.y, dead_reckoning.std(pos), dep.zero)

    def resume(self, kept: KeptNavigation) -> None:
        """Start from what an earlier run kept."""
        was = self._memory
        there = was.position._replace(x=kept.x, y=kept.y, walk=kept.position_std**2, drift=0.0)
        self._memory = was._replace(position=there, depth=was.depth._replace(zero=kept.surface_pressure))

    def freeze(self) -> NavigationMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: NavigationMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _propeller(self, frame: SensorFrame, applied: Applied, t: float) -> float:
        """Return the speed that the propeller reports, else the commanded one, rev/s."""
        if frame.n.usable(t, self._params.propeller_timeout) and math.isfinite(frame.n.value):
            return frame.n.value
        return applied.n
