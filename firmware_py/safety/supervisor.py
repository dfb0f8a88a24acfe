"""The supervisor: orders ask for a mode, the rules may only make it safer.

SURFACE is latched: only DISARM ends it. Most of its causes vanish as soon as the vehicle obeys (it is less deep,
farther from the bottom), and an order given blindly, or a mission taken up again, would lead straight back into them.
Under water nothing would bring a disarmed vehicle up, so there disarming must be forced.
"""

from __future__ import annotations

import math
from dataclasses import replace

from firmware_py.records.command import AscentStage, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind, severity_of
from firmware_py.records.fence import HOME, NO_FENCE, WITHIN, Fence, Place
from firmware_py.records.health import ActuatorHealth, sound
from firmware_py.records.order import NOBODY, Arming, Asker, Mode, Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.ascent import Ascent
from firmware_py.safety.ascent_memory import AscentMemory
from firmware_py.safety.ascent_view import view_of
from firmware_py.safety.assessment import actuator_faults, conditions, fins_heard
from firmware_py.safety.conditions import NO_FAULTS, Conditions
from firmware_py.safety.enforcement import NOTHING_HELD, Enforcement, Held
from firmware_py.safety.health_events import NodeBits, actuator_events, node_events, sensor_events, weight_events
from firmware_py.safety.plane_jam import Planes
from firmware_py.safety.rules import Reason, SafetyParams
from firmware_py.safety.safety_params import switched_off
from firmware_py.safety.sink_watch import SinkWatch, leaks
from firmware_py.safety.start import NOT_ARMED, KeptMode, Start
from firmware_py.safety.supervisor_memory import SupervisorMemory, VehicleFin, beginning
from firmware_py.tick import NS_PER_S, Rate, Tick

__all__ = ["SafetyParams", "Supervisor", "SupervisorMemory", "VehicleFin"]

_DISARM = (Arming.DISARM, Arming.FORCE_DISARM)


class Supervisor:
    """Decides the mode, once per tick; `events` are what the last update decided."""

    events: tuple[Event, ...]

    def __init__(
        self,
        params: SafetyParams,
        has_mission: bool = True,
        fence: Fence = NO_FENCE,
        fins: tuple[VehicleFin, ...] = (),
        home: tuple[Place, ...] = (HOME,),
        drop_weight: bool = False,
        surface_speed: float = 1.5,
        integrity: bool = True,
    ) -> None:
        """`home`: where RETURN may go to; `surface_speed`: of SURFACE, m/s; `integrity`: whether sensors are judged."""
        self._params = params
        self._fence = fence
        self._has_mission = has_mission
        self._home = home
        self._fins = fins
        self._fin_names = tuple(fin.name for fin in fins)
        self._sound = sound(len(fins))
        self._ascent = Ascent(params, drop_weight, surface_speed)
        self._planes = Planes([fin.share for fin in fins], [fin.limit for fin in fins])
        self._enforcement = Enforcement(params)
        self._off = tuple(switched_off(params)) + (() if integrity else ("estimation.integrity.enabled",))
        self._memory = beginning(self._sound)
        self.events = ()

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        state: StateEstimate,
        actuators: ActuatorHealth,
        order: Order,
        mission_done: bool,
        reference: Reference | None = None,
    ) -> ModeState:
        """The mode of this tick.

        Args:
            tick: now, and how late it is.
            frame: what was heard; its ages are judged here again, apart from the estimator.
            state: what the estimator makes of it.
            actuators: what the actuator watch makes of it.
            order: what was asked in this tick.
            mission_done: whether the guidance has passed the last waypoint, or come to where it was to return to.
            reference: what the guidance said in the last tick; None before the first.
        """
        params, was, rules = self._params, self._memory, self._enforcement
        late = (was.late << 1 | (tick.late_ns > tick.dt_ns)) & ((1 << NS_PER_S // tick.dt_ns) - 1)
        self.events = sensor_events(was.sensors, state.sensors)
        self.events += actuator_events(was.actuators, actuators, self._fin_names)
        limit = params.actuators.release_time
        self.events += weight_events(was.actuators.drop_weight, actuators.drop_weight, limit)
        nodes = NodeBits(frame.two_senders, frame.unhealthy, frame.replaced, frame.restarted)
        self.events += node_events(was.nodes, nodes)
        submerged = self._submerged(tick, frame, state)
        wanted, ruled = self._mode_asked_for(was.mode, order, state, submerged), None
        chosen = self._chosen(order) if wanted is Mode.DISARMED else Mode.MANUAL
        faults = NO_FAULTS if actuators == self._sound else actuator_faults(actuators, self._fins)
        done = mission_done and was.mode is wanted
        seen = (tick, frame, state, faults, order, reference)
        c = conditions(params, self._fence, was, *seen, wanted, late.bit_count(), done)
        if was.ascent.stage is not AscentStage.NONE:
            seen_now = c.depth_ok, c.depth, c.fix_heard, c.altitude
            c = c._replace(surfaced=self._ascent.witness.is_surfaced(was.ascent, tick.t, *seen_now))
        if faults is not NO_FAULTS:
            up = c.depth < params.surface_depth
            climbs = up or self._ascent.climbs(was.ascent, tick.t, c.depth, c.z_dot, c.altitude)
            c = c._replace(climbs=c.depth_ok and climbs)
        held = Held(rules.ticks(c, was.held.ticks), was.held.warned_ns)
        asked = order.release or (order.terminate and (submerged or was.mode is not Mode.DISARMED))
        release: Reason | None = Reason(Cause.ORDERED) if asked else None
        ready, returning = True, c.returning
        if wanted is not Mode.DISARMED:
            if was.mode is Mode.DISARMED:
                if refusals := rules.obstacles(c, held.ticks):
                    self._refuse(EventKind.ARMING_REFUSED, refusals, order.asker)
                    wanted, chosen = Mode.DISARMED, was.chosen
                else:
                    held = Held(NOTHING_HELD.ticks, held.warned_ns)
                    returning = c.breach != WITHIN and wanted is Mode.MANUAL
                    if returning:
                        self._add_event(EventKind.RULE_WARNS, cause=Cause.FENCE, numbers=(float(c.breach),))
                    self._warn_at_arming(c)
            elif any(held.ticks):
                verdict = rules.judge(was.mode, c, held, tick.t_ns, tick.dt_ns)
                wanted, ruled, held = verdict.mode, verdict.rule, verdict.held
                self.events += verdict.events
                if release is None and verdict.drop is not None:
                    release = verdict.drop.reason(c, params)
        elif was.mode is Mode.DISARMED and was.start.open and order.arming not in _DISARM:
            verdict = rules.judge_start(c, held, tick.t_ns, tick.dt_ns)
            held, self.events = verdict.held, self.events + verdict.events
            if verdict.rule is not None:
                wanted, ruled, chosen, held = verdict.mode, verdict.rule, Mode.MANUAL, NOTHING_HELD
                if release is None and verdict.drop is not None:
                    release = verdict.drop.reason(c, params)
        if wanted is Mode.DISARMED:
            ahead = c._replace(wanted=chosen, mission_done=False, fins_heard=fins_heard(tick, frame, params))
            refusals = rules.obstacles(ahead, held.ticks)
            ready = not refusals
            if order.arming is Arming.CHECK and was.mode is Mode.DISARMED:
                self._refuse(EventKind.ARMING_CHECK_FAILED, refusals, order.asker)
                if ready:
                    self._add_event(EventKind.ARMING_CHECK_PASSED, asker=order.asker)
                    self._warn_at_arming(c)
        sinking, sunk = was.sinking.after(c, order, params), None
        if wanted is Mode.DISARMED and sinking.is_sunk(tick.dt, params):
            wanted, held, sunk = Mode.SURFACE, Held(NOTHING_HELD.ticks, held.warned_ns), Reason(Cause.SUNK, (c.depth,))
            release = release or sunk
        cause, failsafe = was.cause, was.failsafe
        if wanted is not was.mode:
            cause, numbers, names = sunk or (ruled.reason(c, params) if ruled else Reason(Cause.ORDERED))
            if cause is Cause.SURFACED and leaks(c, was.cause):
                release = release or Reason(Cause.LEAK)
            sinking = SinkWatch(cause is Cause.SURFACED)
            by_itself = sunk is not None or ruled is not None
            failsafe = by_itself and (failsafe or cause not in INTENDED_CAUSES)
            self._add_event(
                EventKind.MODE_CHANGED,
                *(was.mode, wanted, cause, NOBODY if by_itself else order.asker),
                numbers=numbers,
                names=names,
            )
        failsafe = failsafe and wanted is not Mode.DISARMED
        ascent = was.ascent if wanted is Mode.SURFACE else AscentMemory(drop=was.drop)
        if release is not None:
            ascent, told = self._ascent.release(ascent, ascent.stage, actuators.drop_weight, *release)
            self.events += tuple(replace(event, asker=order.asker) for event in told) if asked else told
        if wanted is Mode.SURFACE:
            jam = self._planes.jam(actuators.fins, frame.fins)
            ascent, told = self._ascent.update(ascent, view_of(tick, state, jam, actuators.drop_weight, c))
            self.events += told
        progress = was.progress
        if reference is not None and tick.every(Rate.HZ_1):
            charge = math.nan if c.charge_silent else c.charge
            progress = progress.after_a_second(wanted, reference, state, charge, self._home, params)
        settled, shallow = wanted is not Mode.DISARMED or order.arming in _DISARM, c.depth <= params.submerged_depth
        ticks = round(params.restart_time * NS_PER_S / tick.dt_ns)
        start = was.start.after_a_tick(settled, c.depth_ok and shallow, ticks)
        self._memory = SupervisorMemory(
            *(wanted, cause, failsafe, chosen, ascent.drop, returning and wanted is Mode.MANUAL, held, late),
            was.surfacing + 1 if wanted is Mode.SURFACE else 0,
            was.charge_known or c.charge == c.charge,
            *(progress, state.sensors, actuators, nodes, ascent, was.weight_gone, sinking, start),
        )
        return ModeState(
            mode=wanted,
            mission_done=mission_done and was.mode is not Mode.RETURN,
            late=c.late,
            ready=ready,
            cause=cause,
            failsafe=failsafe,
            too_deep=c.depth > params.depth_max,
            breach=c.breach,
            drop=ascent.drop,
            chosen=chosen,
            ascent=ascent.stage,
            pitch=ascent.pitch,
        )

    def keep(self, t: float) -> KeptMode:
        """Return the mode that a later run is to know of: that of an earlier one while it may still have to come up."""
        start = self._memory.start
        return KeptMode(start.kept.mode, start.kept.ago + t) if start.was_armed else KeptMode(self._memory.mode)

    def resume(self, weight_gone: bool, kept: KeptMode = NOT_ARMED) -> None:
        """Go on after an earlier run: whether it released the drop weight, and in which mode it ended."""
        self._memory = self._memory._replace(weight_gone=weight_gone, start=Start(kept))

    def freeze(self) -> SupervisorMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: SupervisorMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _add_event(
        self,
        kind: EventKind,
        before: Mode | None = None,
        after: Mode | None = None,
        cause: Cause = Cause.NONE,
        asker: Asker = NOBODY,
        numbers: tuple[float, ...] = (),
        names: tuple[str, ...] = (),
    ) -> None:
        self.events += (Event(kind, severity_of(kind, cause), before, after, cause, asker, None, numbers, names),)

    def _warn_at_arming(self, c: Conditions) -> None:
        if c.weight_gone:
            self._add_event(EventKind.RULE_WARNS, cause=Cause.WEIGHT_GONE)
        if self._off:
            self._add_event(EventKind.RULE_WARNS, cause=Cause.RULES_OFF, names=self._off)

    def _refuse(self, kind: EventKind, refusals: list[Reason], asker: Asker) -> None:
        for cause, numbers, names in refusals:
            self._add_event(kind, cause=cause, asker=asker, numbers=numbers, names=names)

    def _submerged(self, tick: Tick, frame: SensorFrame, state: StateEstimate) -> bool:
        """Return whether the vehicle is under water; while the depth is not known, unless a fix tells otherwise."""
        if state.depth_ok:
            return state.eta.z > self._params.submerged_depth
        return not frame.fix.usable(tick.t, self._params.fix_timeout)

    def _mode_asked_for(self, mode: Mode, order: Order, state: StateEstimate, submerged: bool) -> Mode:
        """Return the mode that an order asks for if it is allowed, else the present one."""
        asked, why = order.mode, Cause.NONE
        numbers: tuple[float, ...] = ()
        if order.terminate:
            asked = Mode.SURFACE if mode is not Mode.DISARMED else mode
            if asked is Mode.DISARMED and not submerged:
                asked, why = Mode.SURFACE, Cause.NOTHING_TO_END
        elif order.arming in _DISARM or asked is Mode.DISARMED:
            asked = Mode.DISARMED
            if mode is not Mode.DISARMED and submerged and order.arming is not Arming.FORCE_DISARM:
                why, numbers = Cause.UNDER_WATER, (state.eta.z if state.depth_ok else math.nan,)
        elif mode is Mode.DISARMED:
            asked = (asked or self._memory.chosen) if order.arming is Arming.ARM else mode
        elif asked is None or asked is mode:
            return mode
        elif mode is Mode.SURFACE:
            why = Cause.SURFACING
        if asked is Mode.MISSION and not self._has_mission:
            why = why or Cause.NO_MISSION
        if why is not Cause.NONE:
            self._add_event(EventKind.MODE_REFUSED, None, asked, why, order.asker, numbers)
            return mode
        return asked

    def _chosen(self, order: Order) -> Mode:
        """Return the mode that arming leads to, of a disarmed vehicle: MANUAL unless another one is ordered."""
        before, asked = self._memory.chosen, order.mode
        if self._memory.mode is not Mode.DISARMED or asked is Mode.DISARMED or order.arming in _DISARM:
            return Mode.MANUAL
        if asked is None or order.arming is Arming.ARM or (asked is before and order.chooses):
            return before
        why = Cause.NO_MISSION if asked is Mode.MISSION and not self._has_mission else Cause.NONE
        if not order.chooses:
            why = Cause.DISARMED
        if why is not Cause.NONE:
            self._add_event(EventKind.MODE_REFUSED, None, asked, why, order.asker)
            return before
        self._add_event(EventKind.MODE_CHOSEN, None, asked, asker=order.asker)
        return asked
