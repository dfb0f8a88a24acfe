"""Guidance: what each mode wants of depth, heading and speed, made into a reference that the boat can follow.

No reference moves faster than the boat can: a dive is at most as steep as pitch_max, a turn at most as tight as
turn_radius, and both begin and end over a way, not a time, since the fins' moment goes with u^2. At rest they stand
still, so a boat armed at u = 0 asks for nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from firmware_py.guidance.circle import Circle, beside, tangent
from firmware_py.guidance.learning import STILL, Course, Dither, Learning, LearningParams
from firmware_py.guidance.line_of_sight import LineOfSight, LineOfSightParams
from firmware_py.guidance.reference_model import Lags, ReferenceModel, Shape
from firmware_py.guidance.route import Progress, Route
from firmware_py.marine import clip
from firmware_py.params import When, param, table
from firmware_py.records.command import ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.order import Manoeuvre, Mission, Mode, Order, Setpoint
from firmware_py.schedule import Tick


@dataclass(frozen=True, slots=True)
class GuidanceParams:
    """How references move."""

    shape: Shape = param(Shape.SMOOTH, mav="SHAPE", when=When.DISARMED)
    depth_way: float = param(
        4.5, unit="m", low=0.1, high=100.0, doc="Way made in each of the depth's lags.", mav="DEPTH_WAY"
    )
    climb_max: float = param(0.5, unit="m/s", low=0.01, high=5.0, doc="Fastest change of depth.", mav="CLIMB_MAX")
    pitch_max: float = param(20.0, unit="deg", low=1.0, high=45.0, doc="Steepest change of depth.", mav="PITCH_MAX")
    heading_way: float = param(
        1.5, unit="m", low=0.1, high=100.0, doc="Way made in each of the heading's lags.", mav="HDG_WAY"
    )
    turn_rate_max: float = param(4.0, unit="deg/s", low=0.1, high=90.0, doc="Fastest turn.", mav="TURN_RATE")
    turn_radius: float = param(20.0, unit="m", low=0.1, high=1000.0, doc="Tightest turn.", mav="TURN_RADIUS")
    acceleration: float = param(
        0.05, unit="m/s^2", low=0.001, high=10.0, doc="Change of the speed that is asked for.", mav="ACCEL"
    )
    speed_max: float = param(
        2.5, unit="m/s", low=0.1, high=20.0, doc="Fastest speed that is asked for.", mav="SPEED_MAX"
    )
    cruise_speed: float = param(
        1.8, unit="m/s", low=0.1, high=20.0, doc="Speed on legs that do not give one.", mav="CRUISE"
    )
    blind_climb: float = param(
        10.0,
        unit="m",
        low=0.0,
        high=100.0,
        doc="Surfacing without a depth: how far above the surface it aims.",
        mav="BLIND_CLIMB",
    )
    surface_speed: float = param(
        1.5, unit="m/s", low=0.1, high=20.0, doc="Speed on the way up: fins need it.", mav="SURF_SPEED"
    )
    loiter_radius: float = param(
        30.0,
        unit="m",
        low=5.0,
        high=1000.0,
        doc="Of the circle around a place; turn_radius and speed may widen it.",
        mav="LOIT_RADIUS",
    )
    line_of_sight: LineOfSightParams = table(LineOfSightParams)
    learning: LearningParams = table(LearningParams, mav="LRN_")


_LAGS = 3
"""A reference model has as many, so its heading comes as many ways later than the leg asks for it."""
_ROOM = 1.25
"""A circle is so much wider than the tightest turn, so that the boat can come nearer to its centre."""
_AT_REST = 0.1
"""Slower than this, m/s, is noise."""


class GuidanceMemory(NamedTuple):
    """Everything guidance remembers: `wanted` is what the mode asks for, `last` the reference that became of it."""

    mode: Mode
    wanted: Setpoint
    last: Reference
    depth: Lags
    heading: Lags
    crab: float
    route: Progress
    learning: Course | None
    circle: Circle | None
    pace: float


AT_REST = Reference(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, math.nan)


class Guidance:
    """One reference per tick. `finished` once the mission is flown; `events` are the sentences of this tick.

    `depth_max` and `altitude_min` are the supervisor's limits, m: learning manoeuvres keep away from them.
    """

    def __init__(
        self, params: GuidanceParams, mission: Mission, depth_max: float = math.inf, altitude_min: float = 0.0
    ) -> None:
        self._params = params
        self._depth = ReferenceModel(params.shape)
        self._heading = ReferenceModel(params.shape, angle=True)
        self._sight = LineOfSight(params.line_of_sight)
        self._route = Route(mission)
        self._learning = Learning(params.learning, depth_max, altitude_min)
        self._mode = Mode.DISARMED
        self._wanted = Setpoint(0.0, 0.0, 0.0)
        self._last = AT_REST
        self._circle: Circle | None = None
        self._pace = 0.0
        self._climb_share = math.sin(params.pitch_max)
        self.events: tuple[str, ...] = ()

    @property
    def finished(self) -> bool:
        """True once all of a mission was flown; disarming starts it anew."""
        return self._mode is not Mode.DISARMED and self._route.finished and not self._route.empty

    def update(self, tick: Tick, mode: ModeState, order: Order, state: StateEstimate) -> Reference:
        """The reference of this tick. While the state is not finite the last one stands, and no manoeuvre goes on."""
        self.events = ()
        eta, nu = state.eta, state.nu
        if not math.isfinite(eta.x + eta.y + eta.z + eta.psi + nu.u + nu.v):
            return replace(self._last, **STILL._asdict())
        before, self._mode = self._mode, mode.mode
        entered = mode.mode is not before
        if entered:
            self._learning.reset()
        if mode.mode is Mode.DISARMED or mode.mode is Mode.MANUAL:
            self._last = self._follow(mode.mode, state)
            return self._last
        if entered:
            u_d = 0.0 if before is Mode.DISARMED else self._last.u_d  # who was disarmed is not driven on by itself
            self._wanted = Setpoint(self._depth.command, self._heading.command, u_d)
        across, dither = math.nan, STILL
        if mode.mode is Mode.HOLD:
            self._hold(order.setpoint)
        elif mode.mode is Mode.LOITER or mode.mode is Mode.GUIDED:
            across = self._guide(entered, order.setpoint, state, tick.dt)
        elif mode.mode is Mode.SURFACE:
            z_d = 0.0 if state.depth_ok else -self._params.blind_climb
            self._wanted = Setpoint(z_d, self._wanted.psi_d, self._params.surface_speed)
        elif manoeuvre := self._route.manoeuvre:
            self._hurry(order.setpoint.u_d)
            dither = self._learn(manoeuvre, state, tick.dt)
        elif len(self._route):
            self._hurry(order.setpoint.u_d)
            across = self._fly(entered, state, tick.dt)
        self._last = self._shape(nu.u, across, dither, tick.dt)
        return self._last

    def _follow(self, mode: Mode, state: StateEstimate) -> Reference:
        """Nobody holds anything: the reference is where the boat is, so that holding begins without a bump."""
        if mode is Mode.DISARMED:
            self._route.reset()
            self._sight.reset()
            self._pace = 0.0
        u_d = min(state.nu.u, self._params.speed_max) if state.nu.u > _AT_REST else 0.0
        z_d = self._depth.reset(state.eta.z).d
        psi_d = self._heading.reset(state.eta.psi).d
        return Reference(z_d, 0.0, 0.0, 0.0, psi_d, 0.0, 0.0, u_d, self._route.index, math.nan)

    def _hold(self, setpoint: Setpoint) -> None:
        z_d, psi_d, u_d, _, _ = setpoint
        if math.isfinite(z_d):
            self._wanted = self._wanted._replace(z_d=max(z_d, 0.0))
        if math.isfinite(psi_d):
            self._wanted = self._wanted._replace(psi_d=psi_d)
        if math.isfinite(u_d):
            self._wanted = self._wanted._replace(u_d=clip(u_d, 0.0, self._params.speed_max))

    def _guide(self, entered: bool, setpoint: Setpoint, state: StateEstimate, dt: float) -> float:
        """Goes around a place, or on a heading that was asked for since; returns the distance across the circle, m."""
        x, y = state.eta.x, state.eta.y
        if entered:
            if self._wanted.u_d < _AT_REST:
                self._wanted = self._wanted._replace(u_d=min(self._params.cruise_speed, self._params.speed_max))
            self._circle = beside(x, y, state.eta.psi, self._radius)
        self._hold(setpoint)
        if self._mode is Mode.GUIDED:
            if math.isfinite(setpoint.x + setpoint.y):
                self._circle = Circle(setpoint.x, setpoint.y, self._radius)
            elif math.isfinite(setpoint.psi_d):
                self._circle = None
        if self._circle is None:
            return math.nan
        circle = self._circle._replace(radius=max(self._circle.radius, self._radius))
        lag = _LAGS * self._params.heading_way + self._params.line_of_sight.pivot  # where a turn shows no sway
        way, ahead = tangent(circle, x, y, lag)
        self._wanted = self._wanted._replace(psi_d=self._sight.update(way, state, dt) + ahead)
        return way.across

    @property
    def _radius(self) -> float:
        """Of a circle at the speed that is asked for, m."""
        tightest = max(self._params.turn_radius, self._wanted.u_d / self._params.turn_rate_max)
        return max(self._params.loiter_radius, _ROOM * tightest)

    def _fly(self, entered: bool, state: StateEstimate, dt: float) -> float:
        """Wants what the leg wants; returns the distance across it, m."""
        route, sight = self._route, self._params.line_of_sight
        x, y = state.eta.x, state.eta.y
        if entered:
            route.enter(x, y, self._depth.command)
        before = route.index
        radius = max(self._params.turn_radius, state.nu.u / self._params.turn_rate_max)
        way = route.follow(x, y, sight.acceptance, radius, _LAGS * self._params.heading_way)
        if route.index != before:
            self.events = tuple(f"waypoint {i} of {len(route)} passed" for i in range(before + 1, route.index + 1))
        if route.manoeuvre is None:
            heading = self._sight.update(way, state, dt)
            self._wanted = Setpoint(max(route.depth(way), 0.0), heading, self._speed(route.end.u))
        return way.across

    def _learn(self, manoeuvre: Manoeuvre, state: StateEstimate, dt: float) -> Dither:
        """Wants to stay at the depth and on the course at which the manoeuvre began; returns what it does meanwhile."""
        learning = self._learning
        if not learning.begun:
            z_d = max(self._depth.command, 0.0)
            self._wanted = Setpoint(z_d, self._heading.command, self._speed(manoeuvre.speed))
        dither = learning.update(manoeuvre, self._wanted, state, dt)
        self.events = learning.events
        if not learning.begun:
            self._route.leave(state.eta.x, state.eta.y, self._depth.command)
        return dither

    def _hurry(self, u_d: float) -> None:
        """From now on the mission is flown with this speed, m/s, whatever its items say; with 0 as they say."""
        if math.isfinite(u_d):
            self._pace = max(u_d, 0.0)

    def _speed(self, asked: float) -> float:
        """The speed of an item, m/s, unless another was ordered; the cruising speed where neither is given."""
        return min(self._pace or (asked if asked > 0.0 else self._params.cruise_speed), self._params.speed_max)

    def _shape(self, u: float, across: float, dither: Dither, dt: float) -> Reference:
        params, wanted = self._params, self._wanted
        u = max(u, 0.0)
        climb = min(params.climb_max, self._climb_share * u)
        turn = min(params.turn_rate_max, u / params.turn_radius)
        z_d, z_d_dot, z_d_ddot, z_d_dddot = self._depth.update(wanted.z_d, climb, u / params.depth_way, dt)
        psi_d, psi_d_dot, psi_d_ddot, _ = self._heading.update(wanted.psi_d, turn, u / params.heading_way, dt)
        step = params.acceleration * dt
        u_d = self._last.u_d + clip(wanted.u_d - self._last.u_d, -step, step)
        index = self._route.index
        return Reference(z_d, z_d_dot, z_d_ddot, z_d_dddot, psi_d, psi_d_dot, psi_d_ddot, u_d, index, across, *dither)

    def freeze(self) -> GuidanceMemory:
        """All it remembers."""
        return GuidanceMemory(
            self._mode,
            self._wanted,
            self._last,
            self._depth.freeze(),
            self._heading.freeze(),
            self._sight.freeze(),
            self._route.freeze(),
            self._learning.freeze(),
            self._circle,
            self._pace,
        )

    def thaw(self, memory: GuidanceMemory) -> None:
        """Takes up again what `freeze` gave."""
        self._mode, self._wanted, self._last = memory.mode, memory.wanted, memory.last
        self._depth.thaw(memory.depth)
        self._heading.thaw(memory.heading)
        self._sight.thaw(memory.crab)
        self._route.thaw(memory.route)
        self._learning.thaw(memory.learning)
        self._circle = memory.circle
        self._pace = memory.pace
