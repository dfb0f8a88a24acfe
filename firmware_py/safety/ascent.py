"""Coming up: the stages of SURFACE, judged by whether the vehicle climbs.

Powered, it pitches up and drives. If that leads down, or far from the desired pitch, the propeller goes astern until
the way is off, with the planes still opposing; then it rests, and the drop weight is released. A vehicle that sinks
with its bow up is heavy, and to take its way off would sink it: it drives with full power, and goes on so. Whatever
the stages do, a clock over the whole of SURFACE releases the weight too. Pure: memory in, memory out.
`firmware_py/README.md` has the table of the stages.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.marine import clip
from firmware_py.records.command import AscentStage
from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.health import WeightState
from firmware_py.safety.ascent_memory import AscentMemory
from firmware_py.safety.ascent_view import AscentView
from firmware_py.safety.ascent_witness import SLOW, SurfaceWitness
from firmware_py.safety.plane_jam import PlaneJam
from firmware_py.safety.safety_params import SafetyParams

_TAU = 1.0
"""Time constant of the vertical velocity, s."""
_SINKS = 0.05
"""Faster down than this, m/s, is sinking; faster up is rising."""
_STEEPEST = math.radians(-30.0)
"""From a steeper dive the desired pitch begins here."""
_UPSIDE_DOWN = math.radians(100.0)
"""More roll than this is no heel in a current."""
_SETTLES = 3.0
"""A vehicle at rest is given so long, s, to show that it rises."""
_ENTRY = 8.0
"""Without attitude the end of a dive cannot be seen; it takes at most so long, s."""
_FELL, _FALLS = 0.5, 0.2
"""Without depth, so much less altitude, m, than there was is sinking; and with a depth that stays, where the velocity
says too that it goes down, faster than this, m/s. Bow down under full power, so much deeper is more than a swing."""
_BOW_UP = math.radians(3.0)
"""From this pitch on the propeller drives a vehicle up, whatever pitch is desired; with full power from level on."""
_HEAVY_TIME = 10.0
"""At rest without its weight, a vehicle that still sinks after so long, s, is heavy."""
GATHERS = 45.0
"""A vehicle that rests in the water gathers way in so long, s, before its pitch can lift it."""
_HYSTERESIS = 1.0
"""So much deeper, m, than where a stage near the surface begins, it ends."""
NONE, POWERED, BLIND, LEVEL = AscentStage.NONE, AscentStage.POWERED, AscentStage.BLIND, AscentStage.LEVEL
REVERSE, STOPPED, WAITING, FULL = AscentStage.REVERSE, AscentStage.STOPPED, AscentStage.WAITING, AscentStage.FULL


class Step(NamedTuple):
    """A stage to go to, whether the weight is to be released, and why."""

    stage: AscentStage
    drop: bool
    cause: Cause
    numbers: tuple[float, ...] = ()


class Ascent:
    """The procedure of one vehicle: `weight` is whether it has a drop weight, `speed` that of coming up, m/s."""

    def __init__(self, params: SafetyParams, weight: bool, speed: float) -> None:
        self._params = params.ascent
        self._deepest, self._floor = params.depth_max + params.ascent.limit_margin, params.altitude_min
        self._lowest = 0.5 * self._floor
        self._surface = params.surface_depth
        self._weight = weight
        self.witness = SurfaceWitness(params, speed)

    def update(self, was: AscentMemory, v: AscentView) -> tuple[AscentMemory, tuple[Event, ...]]:
        """Return what is remembered after a tick in SURFACE, and what is to be told."""
        m = self._observe(self._begin(v, was) if was.stage is NONE else was, v)
        step = self._step(m, v)
        events: tuple[Event, ...] = ()
        if step is not None:
            if step.drop:
                m, events = self.release(m._replace(t_told=v.t), step.stage, v.weight, step.cause, step.numbers)
            if step.stage is not was.stage:
                if step.cause is not Cause.NONE or step.stage is STOPPED:  # the others go without saying
                    events += (event(EventKind.ASCENT_STAGE, step.cause, (float(step.stage), *step.numbers)),)
                m = _enter(m, step.stage, v)._replace(gathers=self._gathers(v) if m.stage is STOPPED else m.gathers)
        waits = m.stage is WAITING or (m.stage is STOPPED and m.t_near == m.t_near) or self.witness.is_overdue(m, v)
        began = m.since if m.stage is WAITING else m.t_near
        if waits and v.t - max(m.t_told, began) >= self._params.tell_period:
            events += (event(EventKind.ASCENT_STAGE, Cause.NOT_TOLD, (float(m.stage), v.t - m.begun)),)
            m = m._replace(t_told=v.t)
        elif m.stage is STOPPED and m.asked and not waits:  # all is done that can be, unless it tries again
            gained, patience = max(m.t_best, m.since, m.t_told), self._params.climb_time
            if v.t - gained > patience and m.z_dot >= -_SINKS:
                events += (event(EventKind.ASCENT_STAGE, Cause.NO_CLIMB, (float(m.stage), patience)),)
                m = m._replace(t_told=v.t)
        return m, events

    def release(
        self,
        m: AscentMemory,
        stage: AscentStage,
        weight: WeightState,
        cause: Cause,
        numbers: tuple[float, ...] = (),
        names: tuple[str, ...] = (),
    ) -> tuple[AscentMemory, tuple[Event, ...]]:
        """Command the release for `cause`, or without a weight say so; the one place that does. Told once, at `stage`.

        Where no hardpoint says what becomes of it (`weight`), what is commanded counts as released.
        """
        if m.asked or m.drop:
            return m, ()
        if self._weight:
            reported = weight is not WeightState.UNREPORTED
            kind = EventKind.WEIGHT_COMMANDED if reported else EventKind.WEIGHT_RELEASED
            return m._replace(asked=True, drop=True), (event(kind, cause, numbers, names),)
        return m._replace(asked=True), (event(EventKind.ASCENT_STAGE, Cause.NO_DROP_WEIGHT, (float(stage),)),)

    def climbs(self, m: AscentMemory, t: float, z: float, z_dot: float, altitude: float) -> bool:
        """Return whether the drop weight may wait: it gains height, or has been given no time to yet.

        Args:
            m: what `update` returned last.
            t: now, s.
            z: a good depth, m.
            z_dot: its rate of change, m/s.
            altitude: above the bottom, m; NaN if unknown.
        """
        p = self._params
        if z_dot > _SINKS and (z > self._deepest - p.drop_margin or altitude < self._lowest + p.drop_margin):
            return False
        if m.stage is NONE:
            return True
        if m.t_near == m.t_near:  # no progress can be made here
            return t - m.t_near <= p.climb_time
        return t - max(m.begun, m.t_best) <= p.drop_time

    def _begin(self, v: AscentView, was: AscentMemory) -> AscentMemory:
        stage = POWERED if v.attitude_ok else BLIND
        pitch = clip(v.theta, _STEEPEST, self._params.pitch) if v.attitude_ok else 0.0
        far = v.attitude_ok and abs(v.theta - pitch) > self._params.pitch_error
        off = self._params.pitch_error_time if far else 0.0  # it did not go so far in a moment
        asked = was.asked or was.drop  # what was released before is not asked for again
        begun = AscentMemory(stage, pitch=pitch, z_dot=v.z_dot, off=off, asked=asked, drop=was.drop)
        return begun._replace(
            gathers=self._gathers(v), begun=v.t, since=v.t, t_best=v.t, t_told=v.t,
            z=v.z, least=v.z, best=v.z, z_begun=v.z, altitude_begun=v.altitude,
        )  # fmt: skip

    def _gathers(self, v: AscentView) -> float:
        """Return how much longer a vehicle that moves as `v` says may be without progress, s."""
        return GATHERS if v.through < self._params.rest_speed else 0.0

    def _observe(self, m: AscentMemory, v: AscentView) -> AscentMemory:
        """Bring depth, progress and the clocks of pitch and roll up to date."""
        p, dt = self._params, v.dt
        level = m.stage in (LEVEL, WAITING) or (m.t_near == m.t_near and not self.witness.is_held_down(m, v))
        goal = p.level_pitch if level else p.pitch
        pitch = clip(goal, m.pitch - p.pitch_rate * dt, m.pitch + p.pitch_rate * dt)
        z_dot = m.z_dot + dt / (_TAU + dt) * ((v.z - m.z) / dt - m.z_dot) if v.depth_ok else v.z_dot
        ends_dive = pitch < 0.0 if v.attitude_ok else v.t - m.begun < _ENTRY
        least = v.z if ends_dive else min(m.least, v.z)
        most = v.altitude if ends_dive or not m.most >= v.altitude else m.most
        best, t_best, gathers = (v.z, v.t, 0.0) if v.z <= m.best - p.progress else (m.best, m.t_best, m.gathers)
        shallow = v.depth_ok and v.z < self._surface
        if shallow or v.fix:
            t_best = v.t
        here = p.level_depth + (_HYSTERESIS if m.t_near == m.t_near else 0.0)
        near = v.z < here if v.depth_ok else v.fix
        return m._replace(
            pitch=pitch,
            z=v.z,
            z_dot=z_dot,
            least=least,
            best=best,
            t_best=t_best,
            gathers=gathers,
            off=m.off + dt if v.attitude_ok and abs(v.theta - pitch) > p.pitch_error else 0.0,
            rolled=m.rolled + dt if v.attitude_ok and abs(v.phi) > p.roll else 0.0,
            climbed=m.climbed - v.z_dot * dt if v.attitude_ok else m.climbed,
            t_near=(m.t_near if m.t_near == m.t_near else v.t) if near else math.nan,
            t_up=v.t if shallow else m.t_up,
            t_fix=(m.t_fix if m.t_fix == m.t_fix else v.t) if v.fix else math.nan,
            most=most,
        )

    def _step(self, m: AscentMemory, v: AscentView) -> Step | None:
        """Return where to go from here, or None to stay."""
        if not m.asked and not m.drop and self.witness.is_overdue(m, v):
            return Step(REVERSE if m.stage is REVERSE else STOPPED, True, Cause.NOT_UP, (v.t - m.begun,))
        if not m.asked and not m.drop and self.witness.sinks_unseen(m, v):
            return Step(m.stage, True, Cause.DEEPER, (m.most - v.altitude,))
        if m.stage is STOPPED:
            return self._from_rest(m, v)
        trouble = self._trouble(m, v)
        if m.stage is REVERSE:
            if trouble is not None and trouble.drop and not m.asked:
                return trouble._replace(stage=REVERSE)
            if v.too_low and v.altitude < self._floor and not m.asked:  # way astern turns the bow down, too
                return Step(REVERSE, True, Cause.ALTITUDE_LIMIT, (v.altitude, self._floor))
            way = v.u if v.rise_slope > self._params.pitch else v.through  # planes act by the latter
            stopped = v.speed_ok and way <= self._params.rest_speed
            up = m.z_dot < -_SINKS and not _fell(m, v) > _FELL and v.rise_slope <= self._params.pitch
            rises = v.attitude_ok and v.theta > 0.0 and up
            late = v.t - m.since > self._params.reverse_time
            in_vain = not v.attitude_ok and m.z_dot > _SINKS and v.t - m.since > _ENTRY  # its bow may be up
            if in_vain and not m.asked:
                return Step(STOPPED, True, Cause.NO_CLIMB, (v.t - m.since,))
            return Step(STOPPED, False, Cause.NONE) if stopped or rises or late or in_vain else None
        return trouble or self._drive(m, v)

    def _trouble(self, m: AscentMemory, v: AscentView) -> Step | None:
        """Return what is to be done about what goes wrong while the propeller drives."""
        p, fell = self._params, _fell(m, v)
        sinks = m.z_dot > _SINKS or fell > _FELL
        down = sinks or (v.attitude_ok and v.theta < 0.0)
        driven_up = v.driven_up(0.0 if m.stage is FULL else _BOW_UP)
        brake = REVERSE if down and (v.through > p.rest_speed or not v.speed_ok) else STOPPED
        if not v.attitude_ok and m.drop:
            brake = STOPPED  # without its weight, forward, its bow is up
        if driven_up and ((v.depth_ok and m.z_dot > _SINKS) or m.stage is FULL):
            brake = FULL
        if v.jam is PlaneJam.DOWN:
            return Step(brake, True, Cause.PLANES_STUCK)
        if v.jam is PlaneJam.UP:
            return Step(STOPPED, False, Cause.PLANES_STUCK)
        if v.attitude_ok and (m.rolled > p.roll_time or (m.rolled > 0.0 and abs(v.phi) > _UPSIDE_DOWN)):
            return Step(STOPPED, True, Cause.ROLLED_OVER, (v.phi,))
        if v.depth_ok and sinks and v.z > self._deepest and not m.asked:  # else it tries again, wherever it is
            return Step(brake, True, Cause.DEPTH_LIMIT, (v.z, self._deepest))
        lowest = self._floor if v.through <= SLOW else self._lowest  # without way it sinks by its stern, bow up
        if sinks and v.altitude < lowest:
            return Step(brake, True, Cause.ALTITUDE_LIMIT, (v.altitude, lowest))
        if v.too_low and v.rise_slope > p.pitch and v.u > p.rest_speed:  # the bottom rises more steeply than it climbs
            return Step(REVERSE, False, Cause.ALTITUDE_LIMIT, (v.altitude, self._lowest))
        deeper = max(v.z - m.least, fell) if v.depth_ok else fell
        if sinks and deeper > (_FELL if m.stage is FULL and not driven_up else p.deeper):
            return Step(brake, m.stage is FULL, Cause.DEEPER, (deeper,))
        if m.off > p.pitch_error_time and m.stage not in (LEVEL, WAITING):
            return Step(brake, False, Cause.PITCH_OFF, (v.theta, m.pitch))
        if v.t - m.t_best > p.climb_time + m.gathers and (v.depth_ok or self.witness.is_below(m, v)):
            return Step(brake if m.stage is FULL else STOPPED, True, Cause.NO_CLIMB, (p.climb_time,))
        return None

    def _drive(self, m: AscentMemory, v: AscentView) -> Step | None:
        """Return the stage for this depth, with attitude or without."""
        p, stage = self._params, m.stage
        near = m.t_near == m.t_near
        if m.heavy and v.attitude_ok:
            return None if stage is FULL else Step(FULL, False, Cause.NONE)
        if near and v.t - m.t_near > p.wait_time:
            return None if stage is WAITING else Step(WAITING, False, Cause.NOT_TOLD, (v.t - m.begun,))
        if stage is WAITING and not v.depth_ok:
            return None
        if not v.attitude_ok:
            return None if stage is BLIND else Step(BLIND, False, Cause.NONE)
        if v.depth_ok or near:
            wanted = LEVEL if near and not self.witness.is_held_down(m, v) else POWERED
        elif v.t - m.since > p.turn_time:  # the surface is somewhere here: by turns up to it, and level to be heard
            below = v.z > p.level_depth and v.t - m.begun < self.witness.climb_time(m)
            wanted = POWERED if stage is LEVEL or below else LEVEL
        else:
            wanted = POWERED if stage is BLIND else stage
        return None if wanted is stage else Step(wanted, False, Cause.NONE)

    def _from_rest(self, m: AscentMemory, v: AscentView) -> Step | None:
        """Return what follows when the propeller rests: buoyancy, or another attempt."""
        p, rested = self._params, v.t - m.since
        near = m.t_near == m.t_near
        if self._weight and not m.drop:
            if rested > _SETTLES and not (v.depth_ok and (near or m.z_dot < -_SINKS)):
                return Step(STOPPED, True, Cause.NO_CLIMB, (rested,))
        elif v.jam is PlaneJam.NONE and not near and v.t - max(m.t_best, m.since) > p.climb_time:
            return Step(POWERED if v.attitude_ok else BLIND, False, Cause.NO_CLIMB, (rested,))
        elif not near and v.driven_up(_BOW_UP) and m.z_dot > _SINKS and rested > _HEAVY_TIME:
            return Step(FULL, False, Cause.NO_CLIMB, (rested,))
        if near and v.jam is PlaneJam.NONE and rested > p.wait_time:
            return Step(WAITING, False, Cause.NOT_TOLD, (v.t - m.begun,))
        return None


def _fell(m: AscentMemory, v: AscentView) -> float:
    """Return how much altitude was lost, m, if nothing better tells that it sinks; NaN if that is not known either.

    A depth that stays while velocity and altitude both say that it sinks is no better.
    """
    if not v.depth_ok:
        return m.most - v.altitude
    return m.altitude_begun - v.altitude if v.z_dot > _FALLS and m.z_dot <= _SINKS else 0.0


def _enter(m: AscentMemory, stage: AscentStage, v: AscentView) -> AscentMemory:
    """Begin a stage; a new attempt is judged from where it begins."""
    before = m.stage
    m = m._replace(stage=stage, since=v.t, off=0.0, rolled=0.0)
    if before in (STOPPED, LEVEL, WAITING) and stage in (POWERED, BLIND):
        m = m._replace(least=v.z, most=v.altitude, pitch=v.theta if v.attitude_ok else 0.0)
    if stage is FULL:
        m = m._replace(least=v.z, most=v.altitude, best=v.z, t_best=v.t, heavy=True)
    if before is STOPPED:
        m = m._replace(best=v.z, t_best=v.t)  # from near the surface and back again is no progress
    return m
