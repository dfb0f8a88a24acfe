"""The supervisor: orders ask for a mode, the rules may only make it safer.

SURFACE is latched: only DISARM ends it. Most of its causes vanish as soon as the vehicle obeys (it is less deep,
farther from the bottom), and an order given blindly, or a mission taken up again, would lead straight back into them.
Under water nothing would bring a disarmed vehicle up, so there disarming must be forced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from firmware_py.records.command import AscentStage, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind, event
from firmware_py.records.fence import HOME, NO_FENCE, Fence, Place
from firmware_py.records.health import ActuatorHealth, sound
from firmware_py.records.manoeuvrability import UNLIMITED, Manoeuvrability
from firmware_py.records.order import NOBODY, Mode, Order
from firmware_py.records.sensing import NodeBits, SensorFrame
from firmware_py.safety.ascent import Ascent
from firmware_py.safety.ascent_memory import AscentMemory
from firmware_py.safety.ascent_view import view_of
from firmware_py.safety.assessment import Seen, actuator_faults, conditions
from firmware_py.safety.conditions import NO_FAULTS, Conditions
from firmware_py.safety.decision import Decision, decide
from firmware_py.safety.enforcement import Enforcement
from firmware_py.safety.health_events import (
    actuator_events,
    candidate_events,
    node_events,
    position_events,
    sensor_events,
    weight_events,
)
from firmware_py.safety.look_ahead import too_low
from firmware_py.safety.mode_orders import DISARMS, mode_chosen, mode_ordered, without_disarming
from firmware_py.safety.plane_jam import Planes
from firmware_py.safety.rules import Reason, SafetyParams
from firmware_py.safety.safety_params import left_below
from firmware_py.safety.start import NOT_ARMED, KeptMode, Start
from firmware_py.safety.supervisor_memory import SupervisorMemory, VehicleFin, beginning
from firmware_py.tick import NS_PER_S, Rate, Tick

__all__ = ["SafetyParams", "Supervisor", "SupervisorMemory", "VehicleFin"]

_ORDERED = Reason(Cause.ORDERED)


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
        mission_above: bool = False,
        shared_nodes: Sequence[int] = (),
    ) -> None:
        """Take parameters and vehicle.

        `home` is where RETURN may go to, `surface_speed` that of SURFACE, m/s; `integrity` whether sensors are judged,
        `mission_above` whether the mission has depths above the bottom, `shared_nodes` is that of `node_events`.
        """
        self._params = params
        self._fence = fence
        self._has_mission, self._mission_above = has_mission, mission_above
        self._home = home
        self._fins = fins
        self._fin_names, self._shared_nodes = tuple(fin.name for fin in fins), shared_nodes
        self._sound = sound(len(fins))
        self._ascent = Ascent(params, drop_weight, surface_speed)
        self._planes = Planes([fin.s for fin in fins], [fin.limit for fin in fins], params.actuators.timeout)
        self._enforcement = Enforcement(params)
        self._off = tuple(left_below(params)) + (() if integrity else ("estimation.integrity.enabled = false",))
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
        left: Manoeuvrability = UNLIMITED,
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
            left: what the vehicle can still do.
        """
        params, was = self._params, self._memory
        nodes = NodeBits(frame.two_senders, frame.unhealthy, frame.replaced, frame.restarted)
        self._tell_of_health(state, actuators, nodes, frame.fix.usable(tick.t, params.fix_timeout))
        submerged, depth = self._submerged(tick, frame, state), state.eta.z if state.depth_ok else math.nan
        if was.start.was_armed and submerged:
            order, refused = without_disarming(order, depth)
            self.events += refused
        seen = Seen(tick, frame, state, actuators, order, reference, left)
        wanted, chosen = self._asked_for(order, submerged, depth)
        late = (was.late << 1 | (tick.late_ns > tick.dt_ns)) & ((1 << NS_PER_S // tick.dt_ns) - 1)
        done = mission_done and was.mode is wanted
        c = self._conditions(seen, wanted, late.bit_count(), done)

        decision = decide(self._enforcement, was, seen, c, chosen, self._off)
        mode = decision.mode
        self.events += decision.events
        release = self._release_asked(order, submerged) or (decision.drop and decision.drop.reason(c, params))
        cause, failsafe, watched, brought_up = was.cause, was.failsafe, c.watched, was.brought_up
        if mode is not was.mode:
            cause = self._change_mode(decision, c, order)
            by_itself = decision.rule is not None
            failsafe = by_itself and (failsafe or cause not in INTENDED_CAUSES) and mode is not Mode.DISARMED
            watched = cause is Cause.SURFACED
            brought_up = was.failsafe if watched else brought_up
            if watched and (c.leak or was.cause is Cause.LEAK):
                release = release or Reason(Cause.LEAK)
        ascent = self._come_up(seen, c, mode, release)

        progress = was.progress
        if reference is not None and tick.every(Rate.HZ_1):
            charge = math.nan if c.charge_silent else c.charge
            progress = progress.after_a_second(mode, reference, state, charge, self._home, params)
        bottom = was.bottom
        if tick.every(Rate.HZ_10):
            bottom = bottom.after_a_step(state.eta.z + state.altitude)
        settled, shallow = mode is not Mode.DISARMED or order.arming in DISARMS, c.depth <= params.submerged_depth
        ticks = round(params.restart_time * NS_PER_S / tick.dt_ns)
        depth = c.depth if c.depth_ok or c.fix_heard else max(c.depth, was.depth)
        up = c.fix_heard or (watched and not was.watched)
        self._memory = SupervisorMemory(
            mode=mode,
            cause=cause,
            failsafe=failsafe,
            chosen=decision.chosen,
            drop=ascent.drop,
            returning=decision.returning and mode is Mode.MANUAL,
            held=decision.held,
            late=late,
            surfacing=was.surfacing + 1 if mode is Mode.SURFACE else 0,
            charge_known=was.charge_known or c.charge == c.charge,
            progress=progress,
            sensors=state.sensors,
            candidates=state.candidates,
            actuators=actuators,
            nodes=nodes,
            ascent=ascent,
            weight_gone=was.weight_gone,
            watched=watched,
            brought_up=brought_up,
            depth=depth,
            altitude_up=c.altitude if up or was.altitude_up != was.altitude_up else was.altitude_up,
            bottom=bottom,
            t_manual=tick.t if mode is Mode.MANUAL else was.t_manual,
            start=was.start.after_a_tick(settled, c.depth_ok and shallow, ticks, params.submerged_depth),
        )
        return ModeState(
            mode=mode,
            mission_done=mission_done and was.mode is not Mode.RETURN,
            late=c.late,
            ready=decision.ready,
            cause=cause,
            failsafe=failsafe,
            too_deep=c.depth > params.depth_max,
            breach=c.breach,
            drop=ascent.drop,
            chosen=decision.chosen,
            ascent=ascent.stage,
            pitch=ascent.pitch,
        )

    def keep(self, t: float) -> KeptMode:
        """Return the mode that a later run is to know of: that of an earlier one while it may still have to come up."""
        m = self._memory
        if m.start.was_armed:
            return m.start.kept._replace(ago=m.start.kept.ago + t)
        return NOT_ARMED if m.mode is Mode.DISARMED else KeptMode(m.mode, 0.0, m.depth)

    def resume(self, weight_gone: bool, kept: KeptMode = NOT_ARMED) -> None:
        """Go on after an earlier run: whether it released the drop weight, and in which mode it ended."""
        self._memory = self._memory._replace(weight_gone=weight_gone, start=Start(kept), depth=kept.depth)

    def freeze(self) -> SupervisorMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: SupervisorMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory

    def _tell_of_health(
        self, state: StateEstimate, actuators: ActuatorHealth, nodes: NodeBits, fix_heard: bool
    ) -> None:
        was, limit = self._memory, self._params.actuators.release_time
        self.events = (
            *candidate_events(was.candidates, state.candidates),
            *sensor_events(was.sensors, state.sensors, fix_heard),
            *actuator_events(was.actuators, actuators, self._fin_names),
            *weight_events(was.actuators.drop_weight, actuators.drop_weight, limit),
            *node_events(was.nodes, nodes, self._fin_names, self._shared_nodes),
            *position_events(state.fix_jump),
        )

    def _submerged(self, tick: Tick, frame: SensorFrame, state: StateEstimate) -> bool:
        """Return whether the vehicle is under water; while the depth is not known, unless a fix tells otherwise."""
        if state.depth_ok:
            return state.eta.z > self._params.submerged_depth
        return not frame.fix.usable(tick.t, self._params.fix_timeout)

    def _asked_for(self, order: Order, submerged: bool, depth: float) -> tuple[Mode, Mode]:
        """Return the mode that is wanted, by an order that is allowed or as it was; and the one to arm into."""
        was = self._memory
        wanted, refused = mode_ordered(order, was.mode, was.chosen, self._has_mission, submerged, depth)
        if wanted is not Mode.DISARMED or was.mode is not Mode.DISARMED:
            self.events += refused
            return wanted, Mode.MANUAL
        chosen, told = mode_chosen(order, was.chosen, self._has_mission)
        self.events += refused + told
        return wanted, chosen

    def _conditions(self, seen: Seen, wanted: Mode, late: int, done: bool) -> Conditions:
        """Return what the rules look at; what only the procedure of coming up can tell is added here."""
        params, was, ascent = self._params, self._memory, self._ascent
        t, faults = seen.tick.t, NO_FAULTS
        if seen.actuators != self._sound:
            faults = actuator_faults(seen.actuators, self._fins, seen.left, params.reserve)
        c = conditions(params, self._fence, was, seen, faults, wanted, late, done)
        if self._mission_above:
            c = c._replace(mission_above=True)
        if was.ascent.stage is not AscentStage.NONE:
            place = c.depth_ok, c.depth, c.fix_heard, c.altitude
            c = c._replace(surfaced=ascent.witness.is_surfaced(was.ascent, t, *place))
        if faults is not NO_FAULTS:
            up = c.depth < params.surface_depth
            climbs = up or ascent.climbs(was.ascent, t, c.depth, c.z_dot, c.altitude)
            c = c._replace(climbs=c.depth_ok and climbs)
        return c

    def _change_mode(self, decision: Decision, c: Conditions, order: Order) -> Cause:
        """Say that the mode changes, and return why it does."""
        rule = decision.rule
        reason, asker = (rule.reason(c, self._params), NOBODY) if rule else (_ORDERED, order.asker)
        before, after = self._memory.mode, decision.mode
        self.events += (event(EventKind.MODE_CHANGED, *reason, before=before, after=after, asker=asker),)
        return reason.cause

    def _release_asked(self, order: Order, submerged: bool) -> Reason | None:
        """Return why the drop weight goes if an order says so: for itself, or as it ends the flight."""
        ends = order.terminate and (submerged or self._memory.mode is not Mode.DISARMED)
        return _ORDERED if order.release or ends else None

    def _come_up(self, seen: Seen, c: Conditions, mode: Mode, release: Reason | None) -> AscentMemory:
        """Release the drop weight if there is a reason to, come up in SURFACE, and return what is remembered of it."""
        was, weight = self._memory, seen.actuators.drop_weight
        ascent = was.ascent if mode is Mode.SURFACE else AscentMemory(drop=was.drop)
        if release is not None:
            ascent, told = self._ascent.release(ascent, ascent.stage, weight, *release)
            asker = seen.order.asker if release is _ORDERED else NOBODY
            self.events += tuple([replace(event, asker=asker) for event in told])
        if mode is Mode.SURFACE:
            jam = self._planes.jam(seen.tick.t, seen.actuators.fins, seen.frame.fins, seen.actuators.left)
            view = view_of(seen.tick, seen.state, jam, weight, c, too_low(c, self._params))
            ascent, told = self._ascent.update(ascent, view)
            self.events += told
        return ascent
