"""Guidance: depth, heading and speed setpoints of each mode, which `ReferenceShaper` turns into a reference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from firmware_py.guidance.bottom import Bottom
from firmware_py.guidance.circle import Circle, circle_through, tangent
from firmware_py.guidance.guidance_memory import AT_REST, GuidanceMemory
from firmware_py.guidance.guidance_params import GuidanceParams
from firmware_py.guidance.held_setpoint import held, under_way
from firmware_py.guidance.line_of_sight import Leg, LineOfSight
from firmware_py.guidance.manoeuvre import NO_EXCITATION, Excitation, ManoeuvreGuidance
from firmware_py.guidance.rally_point import home_not_known, seen_from, unreachable
from firmware_py.guidance.reference_shaper import ReferenceShaper
from firmware_py.guidance.route import Route, heading_towards
from firmware_py.records.command import AscentStage, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Event, EventKind, event
from firmware_py.records.fence import HOME, NO_FENCE, NOWHERE, Fence, Place
from firmware_py.records.mission import Loiter, Manoeuvre, Mission, Surface, Waypoint, is_above
from firmware_py.records.order import Mode, Order, Setpoint
from firmware_py.records.turning import Turning
from firmware_py.tick import Tick

__all__ = ["Guidance", "GuidanceParams"]

_CLEAR = 1.0  # distance, m, that flight above the bottom keeps from the supervisor's limits
_RETURN = Mission((Surface(rally=True),))
_JOINED = 0.25  # share of its radius within which a circle is joined


class Guidance:
    """Guidance of all modes: one reference per tick; `events` are those of this tick.

    `depth_max` and `altitude_min` are the supervisor's limits, m: learning manoeuvres keep away from them, and so does
    what is flown above the bottom. SURFACE goes to the `nearest_rally_point`, chosen on entering the mode; RETURN and
    the return of a mission to the nearest of `returns`, which are the rally points unless others are given.
    """

    def __init__(
        self,
        params: GuidanceParams,
        mission: Mission,
        depth_max: float = math.inf,
        altitude_min: float = 0.0,
        rally: Sequence[Place] = (),
        fence: Fence = NO_FENCE,
        returns: Sequence[Place] | None = None,
    ) -> None:
        returns = rally if returns is None else returns
        self._params = params
        self._shaper = ReferenceShaper(params)
        self.limit = self._shaper.limit
        self._depth, self._heading = self._shaper.depth, self._shaper.heading
        self._sight = LineOfSight(params.line_of_sight)
        self._route = Route(mission, returns, fence)
        self._ways = {Mode.RETURN: Route(_RETURN, returns, fence), Mode.SURFACE: Route(_RETURN, rally, fence)}
        self._unreachable = unreachable(returns)
        self._bottom = Bottom(depth_max - _CLEAR, altitude_min + _CLEAR)
        self._learning = ManoeuvreGuidance(params.learning, depth_max, altitude_min)
        self._mode = Mode.DISARMED
        self._wanted = Setpoint(0.0, 0.0, 0.0)
        self.last = AT_REST
        self._circle: Circle | None = None
        self._place: Place | None = None
        self._speed_override = 0.0
        self.events: tuple[Event, ...] = ()

    @property
    def finished(self) -> bool:
        """Whether the mission (in RETURN: the return) is flown, or was removed meanwhile; disarming starts it anew."""
        if self._mode is Mode.RETURN:
            return self._flown.finished
        flown = self._mode is Mode.MISSION or not self._route.empty
        return self._mode is not Mode.DISARMED and self._route.finished and flown

    @property
    def _turning(self) -> Turning:
        return self._shaper.turning

    @property
    def _flown(self) -> Route:
        return self._ways.get(self._mode, self._route)

    def update(self, tick: Tick, mode: ModeState, order: Order, state: StateEstimate) -> Reference:
        """Return this tick's reference; of a state that is not finite, the last, undisturbed."""
        self.events = ()
        reference = self._update(tick, mode, order, state)
        self.events += self._learning.report_events(state.learned.report)
        return reference

    def _update(self, tick: Tick, mode: ModeState, order: Order, state: StateEstimate) -> Reference:
        eta, nu = state.eta, state.nu
        if not math.isfinite(eta.x + eta.y + eta.z + eta.psi + nu.u + nu.v):
            return replace(self.last, **NO_EXCITATION._asdict())
        before, self._mode = self._mode, mode.mode
        entered = mode.mode is not before
        if entered:
            self._learning.reset()
            if mode.mode is Mode.DISARMED:
                self._route.reset()
            for way in self._ways.values():
                way.reset()
            self._place = None
        if order.jump >= 0:
            self._learning.reset()
            self._route.jump(order.jump, eta.x, eta.y, self._depth.command)
        self._bottom.see(eta.z, state.altitude)
        if mode.mode is Mode.DISARMED or mode.mode is Mode.MANUAL:
            self.last = self._follow(mode.mode, state)
            return self.last
        if entered:
            u_d = 0.0 if before is Mode.DISARMED else self.last.u_d  # a disarmed one does not start by itself
            if mode.failsafe:  # nobody sent it on: no rule's HOLD hurries
                u_d = min(u_d, self._params.failsafe_speed)
            self._wanted = Setpoint(self._depth.command, self._heading.command, u_d)
        across, dither = math.nan, NO_EXCITATION
        if mode.mode is Mode.HOLD:
            self._wanted = held(self._wanted, order.setpoint, self._turning)
        elif mode.mode is Mode.LOITER or mode.mode is Mode.GUIDED:
            across = self._guide(entered, order.setpoint, state, tick.dt)
        elif mode.mode is Mode.SURFACE:
            if entered:
                self._flown.enter(eta.x, eta.y, self._depth.command)
            self._wanted = self._surface(state, mode.ascent)
        else:
            flown = self._flown
            rally, stays = flown.rally, flown.rally_unreachable
            across, dither = self._proceed(entered, order.setpoint.u_d, state, tick.dt)
            self.events += (self._unreachable,) * (flown.rally_unreachable and not stays)
            if flown.rally == HOME and rally is None and (lost := home_not_known(eta.x, eta.y, state.position_std)):
                flown.abandon()
                self.events += lost
        self.last = self._shape(state, across, dither, tick.dt)
        return self.last

    def _follow(self, mode: Mode, state: StateEstimate) -> Reference:
        """Return the vehicle's own depth, heading and speed, so that holding them begins without a bump."""
        if mode is Mode.DISARMED:
            self._sight.reset()
            self._speed_override = 0.0
        route, shaped = self._route, self._shaper.follow(state)
        return Reference(*shaped, route.index, math.nan, *NO_EXCITATION, route.item, target_bearing=shaped.psi_d)

    def _guide(self, entered: bool, setpoint: Setpoint, state: StateEstimate, dt: float) -> float:
        """Circle around a position, or hold an ordered heading; return the cross-track distance of the circle, m."""
        x, y = state.eta.x, state.eta.y
        if entered:
            self._wanted = self._wanted._replace(u_d=under_way(self._wanted.u_d, self._turning))
            self._circle = circle_through(x, y, state.eta.psi, self._radius)
        self._wanted = held(self._wanted, setpoint, self._turning)
        if self._mode is Mode.GUIDED:
            if math.isfinite(setpoint.x + setpoint.y):
                self._circle = Circle(setpoint.x, setpoint.y, self._radius)
                self._place = Place(setpoint.x, setpoint.y)
            elif math.isfinite(setpoint.psi_d):
                self._circle = self._place = None
        if self._circle is None:
            return math.nan
        circle = self._circle._replace(radius=max(self._circle.radius, self._radius))
        way, psi_d = self._round(circle, state, dt)
        self._wanted = self._wanted._replace(psi_d=psi_d)
        return way.across

    def _round(self, circle: Circle, state: StateEstimate, dt: float) -> tuple[Leg, float]:
        """Return the tangent of the circle, and the heading that follows it, rad."""
        lag = self._params.heading_lag + self._params.line_of_sight.pivot  # where a turn shows no sway
        way, ahead = tangent(circle, state.eta.x, state.eta.y, lag)
        return way, self._sight.update(way, state, dt) + ahead

    @property
    def _radius(self) -> float:
        """Radius of a circle at the desired speed, m."""
        return self._turning.radius(0.0, self._wanted.u_d)

    def _surface(self, state: StateEstimate, stage: AscentStage) -> Setpoint:
        """Return the setpoint of SURFACE: up and towards the rally point; there, or without one, hold the heading."""
        z_d, speed = 0.0 if state.depth_ok else -self._params.blind_climb, self._params.surfacing_speed(stage)
        psi_d = heading_towards(self._flown.rally, state.eta.x, state.eta.y, self._turning.tightest(speed))
        return Setpoint(z_d, self._wanted.psi_d if math.isnan(psi_d) else psi_d, speed)

    def _proceed(self, entered: bool, u_d: float, state: StateEstimate, dt: float) -> tuple[float, Excitation]:
        """Fly the current item; return cross-track distance, m (NaN off a leg), and excitation."""
        route = self._flown
        self._override_speed(u_d)
        if entered or not route.entered:
            route.enter(state.eta.x, state.eta.y, self._depth.command)
        item = route.current
        if isinstance(item, Manoeuvre):
            return math.nan, self._learn(item, state, dt)
        if isinstance(item, Loiter):
            self._loiter(item, state, dt)
        elif isinstance(item, Waypoint):
            return self._fly(item, state, dt), NO_EXCITATION
        return math.nan, NO_EXCITATION

    def _fly(self, end: Waypoint, state: StateEstimate, dt: float) -> float:
        """Set the setpoint of a leg; return the cross-track distance, m; NaN in a circle for the depth, no leg."""
        route, eta, command = self._flown, state.eta, self._depth.command
        reach = self._params.reach(self._turning, self._speed(end.u), state.nu.u)
        way = route.follow(eta.x, eta.y, reach, lambda end: self._bottom.depth_of(end, command) - eta.z, dt)
        self.events = route.events
        after = route.current
        if isinstance(after, Waypoint) or route.finished:
            end = after if isinstance(after, Waypoint) else end
            z_d = self._bottom.depth_of(end, command)
            if route.spiral is not None:
                way, heading = self._round(route.spiral, state, dt)
            else:
                heading = self._sight.update(way, state, dt)
                z_d = z_d if end.above else route.depth(end, way)
            self._wanted = Setpoint(max(z_d, 0.0), heading, self._speed(end.u))
        return way.across if route.spiral is None else math.nan

    def _loiter(self, item: Loiter, state: StateEstimate, dt: float) -> None:
        """Set the setpoint of a loiter; leave the item when its turns or its time are over."""
        u_d = self._speed(item.u)
        radius = self._turning.radius(item.radius, u_d)
        circle = Circle(item.x, item.y, math.copysign(radius, item.radius or 1.0))
        x, y = state.eta[:2]
        _, psi_d = self._round(circle, state, dt)
        self._wanted = Setpoint(max(self._bottom.depth_of(item, self._depth.command), 0.0), psi_d, u_d)
        if self._route.circle(x, y, circle, _JOINED * radius, dt):
            self.events = (event(EventKind.LOITER_DONE, numbers=(self._route.item + 1.0,)),)
            self._route.leave(x, y, self._depth.command)

    def _learn(self, manoeuvre: Manoeuvre, state: StateEstimate, dt: float) -> Excitation:
        """Hold depth and course of the manoeuvre's beginning; return the excitation."""
        learning = self._learning
        if not learning.begun:
            z_d = max(self._depth.command, 0.0)
            self._wanted = Setpoint(z_d, self._heading.command, self._speed(manoeuvre.speed))
        dither = learning.update(manoeuvre, self._wanted, state, dt)
        self.events = learning.events
        if not learning.begun:
            self._route.leave(state.eta.x, state.eta.y, self._depth.command)
        return dither

    def _override_speed(self, u_d: float) -> None:
        """Override the speed of the mission's items, m/s; 0 ends the override, NaN changes nothing."""
        if math.isfinite(u_d):
            self._speed_override = max(u_d, 0.0)

    def _speed(self, asked: float) -> float:
        """Return the speed of an item, m/s, unless another was ordered; the cruising speed if neither is given."""
        return self._turning.speed(self._speed_override or asked)

    def _shape(self, state: StateEstimate, across: float, dither: Excitation, dt: float) -> Reference:
        shaped = self._shaper.update(self._wanted, self.last.u_d, state.nu.u, dt)
        rally, target = self._rally, self._target
        distance, bearing = seen_from(target, state.eta.x, state.eta.y, across, shaped.psi_d)
        at, where = (self._route.index, across, *dither, self._route.item), target or NOWHERE
        above = self._mode in (Mode.MISSION, Mode.RETURN) and is_above(self._flown.current)
        return Reference(*shaped, *at, where, distance, bearing, rally or NOWHERE, above)

    @property
    def _rally(self) -> Place | None:
        """The rally point that the vehicle goes to, or home, if any."""
        if self._mode is Mode.RETURN and self._flown.finished and self.last.rally.x == self.last.rally.x:
            return self.last.rally  # it stays the target of the tick in which it is reached
        return self._flown.rally if self._mode in (Mode.MISSION, *self._ways) else None

    @property
    def _target(self) -> Place | None:
        """The position that the vehicle flies to, if any."""
        if self._mode is Mode.GUIDED:
            return self._place
        if self._mode is Mode.MISSION:
            item = self._route.current
            return Place(item.x, item.y) if isinstance(item, (Waypoint, Loiter)) else None
        return self._rally

    def restart(self) -> None:
        """Start the mission from its beginning; called when it was replaced. If it is flown, it is entered anew."""
        self._route.reset()
        self._learning.reset()

    def freeze(self) -> GuidanceMemory:
        """Return the whole memory."""
        shaped = (self._mode, self._wanted, self.last, *self._shaper.freeze(), self._sight.freeze())
        home = tuple(way.freeze() for way in self._ways.values())
        flown = (self._route.freeze(), self._learning.freeze(), self._circle, self._place)
        return GuidanceMemory(*shaped, *flown, self._speed_override, self._bottom.z, home)

    def thaw(self, memory: GuidanceMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._mode, self._wanted, self.last = memory.mode, memory.wanted, memory.last
        self._shaper.thaw(memory.depth, memory.heading)
        self._sight.thaw(memory.crab)
        self._route.thaw(memory.route)
        self._learning.thaw(memory.learning)
        self._circle, self._place = memory.circle, memory.place
        self._speed_override = memory.pace
        self._bottom.z = memory.bottom
        for way, progress in zip(self._ways.values(), memory.home, strict=True):
            way.thaw(progress)
