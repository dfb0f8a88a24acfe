"""The supervisor: orders ask for a mode, the rules may only make it safer.

SURFACE is latched: only DISARM ends it. Most of its causes vanish as soon as the vehicle obeys (it is less deep,
farther from the bottom), and an order given blindly, or a mission taken up again, would lead straight back into them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.command import ModeState
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind, severity_of
from firmware_py.records.fence import NO_FENCE, Fence
from firmware_py.records.health import ALL_GOOD, ActuatorHealth, SensorHealth, sound
from firmware_py.records.order import NOBODY, Arming, Asker, Mode, Order
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.health_events import actuator_events, node_events, sensor_events
from firmware_py.safety.rules import ARMING, RULES, Conditions, Rule, SafetyParams, safer
from firmware_py.tick import NS_PER_S, Tick

__all__ = ["SafetyParams", "Supervisor", "SupervisorMemory"]

ArmingRefusal = tuple[Cause, tuple[float, ...]]
"""Why arming is refused: a cause and its numbers."""


class SupervisorMemory(NamedTuple):
    """The mode and why it was entered; for how many ticks each rule's condition has held; a bit per late tick of the
    last second; the health of sensors, actuators and nodes of the bus (`two_senders` and `unhealthy` of the frame).
    """

    mode: Mode
    cause: Cause
    held: tuple[int, ...]
    late: int
    sensors: SensorHealth
    actuators: ActuatorHealth
    nodes: tuple[int, int] = (0, 0)


class Supervisor:
    """Decides the mode, once per tick; `events` are what the last update decided."""

    events: tuple[Event, ...]

    def __init__(
        self, params: SafetyParams, has_mission: bool = True, fence: Fence = NO_FENCE, fins: tuple[str, ...] = ()
    ) -> None:
        self._params = params
        self._fence = fence
        self._has_mission = has_mission
        self._fins = fins
        self._rules = tuple(
            (rule.holds, round(getattr(params, rule.time) * NS_PER_S) if rule.time else 0) for rule in RULES
        )
        self._memory = SupervisorMemory(Mode.DISARMED, Cause.NONE, (0,) * len(RULES), 0, ALL_GOOD, sound(len(fins)))
        self.events = ()

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        state: StateEstimate,
        actuators: ActuatorHealth,
        order: Order,
        mission_done: bool,
    ) -> ModeState:
        """The mode of this tick.

        Args:
            tick: now, and how late it is.
            frame: what was heard; its ages are judged here again, apart from the estimator.
            state: what the estimator makes of it.
            actuators: what the actuator watch makes of it.
            order: what was asked in this tick.
            mission_done: whether the guidance has passed the last waypoint, or come to where it was to return to.
        """
        params, was = self._params, self._memory
        late = (was.late << 1 | (tick.late_ns > tick.dt_ns)) & ((1 << NS_PER_S // tick.dt_ns) - 1)
        self.events = sensor_events(was.sensors, state.sensors)
        self.events += actuator_events(was.actuators, actuators, self._fins)
        nodes = frame.two_senders, frame.unhealthy
        self.events += node_events(was.nodes, nodes)
        ready = True
        wanted, ruled = self._mode_asked_for(was.mode, order), None
        done = mission_done and was.mode is wanted
        c = self._conditions(tick, frame, state, wanted, late.bit_count(), done)

        held = tuple([n + 1 if holds(c, params) else 0 for (holds, _), n in zip(self._rules, was.held, strict=True)])
        if wanted is not Mode.DISARMED:
            if was.mode is Mode.DISARMED and (refusals := self._refusals(c, held)):
                self._refuse(EventKind.ARMING_REFUSED, refusals, order.asker)
                wanted = Mode.DISARMED
            elif any(held):
                wanted, ruled = self._safest_mode(wanted, c, held, tick.dt_ns)
        if wanted is Mode.DISARMED:
            refusals = self._refusals(self._conditions(tick, frame, state, Mode.MANUAL, c.late, False), held)
            ready = not refusals
            if order.arming is Arming.CHECK and was.mode is Mode.DISARMED:
                self._refuse(EventKind.ARMING_CHECK_FAILED, refusals, order.asker)
                if ready:
                    self._add_event(EventKind.ARMING_CHECK_PASSED, asker=order.asker)
        cause = was.cause
        if wanted is not was.mode:
            cause = ruled.cause if ruled else Cause.ORDERED
            self._add_event(
                EventKind.MODE_CHANGED,
                *(was.mode, wanted, cause, NOBODY if ruled else order.asker),
                numbers=ruled.numbers(c, params) if ruled else (),
            )
        self._memory = SupervisorMemory(wanted, cause, held, late, state.sensors, actuators, nodes)
        return ModeState(
            mode=wanted,
            mission_done=mission_done and was.mode is not Mode.RETURN,
            late=c.late,
            ready=ready,
            cause=cause,
            failsafe=wanted is Mode.SURFACE and cause not in INTENDED_CAUSES,
            too_deep=c.depth > params.depth_max,
            breach=c.breach,
        )

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
    ) -> None:
        self.events += (Event(kind, severity_of(kind, cause), before, after, cause, asker, numbers=numbers),)

    def _refuse(self, kind: EventKind, refusals: list[ArmingRefusal], asker: Asker) -> None:
        for cause, numbers in refusals:
            self._add_event(kind, cause=cause, asker=asker, numbers=numbers)

    def _mode_asked_for(self, mode: Mode, order: Order) -> Mode:
        """Return the mode that an order asks for if it is allowed, else the present one."""
        if order.arming == Arming.DISARM or order.mode == Mode.DISARMED:
            return Mode.DISARMED
        asked, why = order.mode, Cause.NONE
        if mode is Mode.DISARMED and order.arming == Arming.ARM:
            if asked is None:
                asked = Mode.MANUAL  # with centred sticks and a stopped propeller
        elif asked is None or asked is mode:
            return mode
        elif mode is Mode.DISARMED:
            why = Cause.DISARMED
        elif mode is Mode.SURFACE:
            why = Cause.SURFACING
        if asked is Mode.MISSION and not self._has_mission:
            why = why or Cause.NO_MISSION
        if why is not Cause.NONE:
            self._add_event(EventKind.MODE_REFUSED, None, asked, why, order.asker)
            return mode
        return asked

    def _conditions(
        self, tick: Tick, frame: SensorFrame, state: StateEstimate, wanted: Mode, late: int, mission_done: bool
    ) -> Conditions:
        params, t, eta, battery = self._params, tick.t, state.eta, frame.battery
        return Conditions(
            wanted=wanted,
            attitude_ok=state.attitude_ok and t - frame.ahrs.t_valid <= params.attitude_timeout,
            depth_ok=state.depth_ok and t - frame.pressure.t_valid <= params.depth_timeout,
            depth=eta.z,
            altitude=state.altitude,
            fix_heard=frame.fix.usable(t, params.fix_timeout),
            leak=state.leak,
            charge=battery.value.remaining if battery.ok else math.nan,
            late=late,
            mission_done=mission_done,
            tilt=max(abs(eta.phi), abs(eta.theta)),
            fins_heard=wanted is self._memory.mode  # it matters on arming alone, and costs a microsecond
            or all(fin.usable(t, params.fin_timeout) and math.isfinite(fin.value) for fin in frame.fins),
            breach=self._fence.breach_at(eta.x, eta.y),
        )

    def _refusals(self, c: Conditions, held: tuple[int, ...]) -> list[ArmingRefusal]:
        """Return why arming is refused: checks of `ARMING`, and rules that hold and ask for a safer mode."""
        checks = [rule for rule in ARMING if rule.holds(c, self._params)]
        rules = [rule for rule, n in zip(RULES, held, strict=True) if n and safer(rule.mode, c.wanted)]
        return list(dict.fromkeys((rule.cause, rule.numbers(c, self._params)) for rule in checks + rules))

    def _safest_mode(self, wanted: Mode, c: Conditions, held: tuple[int, ...], dt_ns: int) -> tuple[Mode, Rule | None]:
        """Return the ordered mode, or the safest one that a rule in force asks for, and that rule."""
        mode, ruled = wanted, None
        for rule, (_, after_ns), n in zip(RULES, self._rules, held, strict=True):
            if (n - 1) * dt_ns < after_ns:
                continue
            if safer(rule.mode, mode):
                mode, ruled = rule.mode, rule
            elif rule.mode is self._memory.mode and (n - 2) * dt_ns < after_ns:  # one more reason
                numbers = rule.numbers(c, self._params)
                self._add_event(EventKind.RULE_HOLDS, cause=rule.cause, numbers=numbers)
        return mode, ruled
