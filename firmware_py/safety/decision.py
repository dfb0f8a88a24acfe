"""What orders and rules make of the mode in one tick."""

from __future__ import annotations

from typing import NamedTuple

from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.fence import WITHIN
from firmware_py.records.order import Arming, Asker, Mode
from firmware_py.safety.assessment import Seen, fins_heard
from firmware_py.safety.conditions import Conditions
from firmware_py.safety.enforcement import NOTHING_HELD, Enforcement, Held
from firmware_py.safety.mode_orders import DISARMS
from firmware_py.safety.rules import Reason, Rule
from firmware_py.safety.supervisor_memory import SupervisorMemory


class Decision(NamedTuple):
    """The mode, and what goes with it.

    Attributes:
        mode: the mode.
        held: what the rules have held.
        events: what is to be said.
        chosen: the mode that arming leads to.
        rule: the rule that changed the mode; None if none did.
        drop: the rule that asks for the drop weight's release; None if none does.
        returning: whether it was armed beyond the fence, to be steered back.
        ready: whether it is armed or could be.
    """

    mode: Mode
    held: Held
    events: tuple[Event, ...] = ()
    chosen: Mode = Mode.MANUAL
    rule: Rule | None = None
    drop: Rule | None = None
    returning: bool = False
    ready: bool = True


def decide(
    rules: Enforcement, was: SupervisorMemory, seen: Seen, c: Conditions, chosen: Mode, off: tuple[str, ...]
) -> Decision:
    """Return what follows from the mode that is wanted, `c.wanted`, and from the rules that hold.

    Args:
        rules: the rules.
        was: what is remembered.
        seen: what the supervisor is given.
        c: what the rules look at.
        chosen: the mode that arming leads to.
        off: keys of safety functions that are switched off.
    """
    held = Held(rules.ticks(c, was.held.ticks), was.held.warned_ns)
    if c.wanted is Mode.DISARMED:
        decision = _disarmed(rules, was, seen, c, held, chosen)
    elif was.mode is Mode.DISARMED:
        decision = _arming(rules, was, seen, c, held, off)
    else:
        decision = _in_flight(rules, was, seen, c, held)
    return decision if decision.mode is not Mode.DISARMED else _checked(decision, rules, was, seen, c, off)


def _in_flight(rules: Enforcement, was: SupervisorMemory, seen: Seen, c: Conditions, held: Held) -> Decision:
    if not any(held.ticks):
        return Decision(c.wanted, held, returning=c.returning)
    mode, rule, drop, held, events = rules.judge(was.mode, c, held, seen.tick.t_ns, seen.tick.dt_ns)
    return Decision(mode, held, events, rule=rule, drop=drop, returning=c.returning)


def _disarmed(
    rules: Enforcement, was: SupervisorMemory, seen: Seen, c: Conditions, held: Held, chosen: Mode
) -> Decision:
    """Return the decision of a vehicle that is disarmed, or ordered to be: some rules bring it up by themselves."""
    if was.mode is not Mode.DISARMED or seen.order.arming in DISARMS:
        return Decision(Mode.DISARMED, held, chosen=chosen)
    mode, rule, drop, held, events = rules.judge_disarmed(c, held, seen.tick.t_ns, seen.tick.dt_ns)
    if rule is None:
        return Decision(Mode.DISARMED, held, events, chosen)
    return Decision(mode, _begun(held), events, rule=rule, drop=drop)


def _arming(
    rules: Enforcement, was: SupervisorMemory, seen: Seen, c: Conditions, held: Held, off: tuple[str, ...]
) -> Decision:
    """Return the decision on an order to arm."""
    if refusals := rules.obstacles(c, held.ticks):
        events = _refused(EventKind.ARMING_REFUSED, refusals, seen.order.asker)
        return Decision(Mode.DISARMED, held, events, was.chosen)
    returning, events = c.breach != WITHIN and c.wanted is Mode.MANUAL, _warnings(c, off)
    if returning:
        events = (event(EventKind.RULE_WARNS, Cause.FENCE, (float(c.breach),)), *events)
    return Decision(c.wanted, _begun(held), events, returning=returning)


def _checked(
    decision: Decision, rules: Enforcement, was: SupervisorMemory, seen: Seen, c: Conditions, off: tuple[str, ...]
) -> Decision:
    """Return the decision to be disarmed with whether it could be armed now; that is said if it was asked."""
    order, heard = seen.order, fins_heard(seen.tick, seen.frame, rules.params)
    ahead = c._replace(wanted=decision.chosen, mission_done=False, fins_heard=heard)
    refusals, events = rules.obstacles(ahead, decision.held.ticks), decision.events
    if order.arming is Arming.CHECK and was.mode is Mode.DISARMED:
        if refusals:
            events += _refused(EventKind.ARMING_CHECK_FAILED, refusals, order.asker)
        else:
            events += (event(EventKind.ARMING_CHECK_PASSED, asker=order.asker), *_warnings(c, off))
    return decision._replace(events=events, ready=not refusals)


def _begun(held: Held) -> Held:
    """Return that nothing has held yet in the mode that begins; when each rule warned last is kept."""
    return Held(NOTHING_HELD.ticks, held.warned_ns)


def _warnings(c: Conditions, off: tuple[str, ...]) -> tuple[Event, ...]:
    """Return what who arms the vehicle is to know."""
    gone = (event(EventKind.RULE_WARNS, Cause.WEIGHT_GONE),) if c.weight_gone else ()
    return (*gone, event(EventKind.RULE_WARNS, Cause.RULES_OFF, names=off)) if off else gone


def _refused(kind: EventKind, refusals: list[Reason], asker: Asker) -> tuple[Event, ...]:
    return tuple([event(kind, *reason, asker=asker) for reason in refusals])
