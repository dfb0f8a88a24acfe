"""Events of sensors, actuators and nodes of the bus: one for each change of health."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from firmware_py.records.event import Cause, Event, EventKind, event
from firmware_py.records.health import (
    GOOD,
    ActuatorFault,
    ActuatorHealth,
    Candidate,
    SensorHealth,
    SourceFault,
    SourceHealth,
    SourceState,
    WeightState,
)
from firmware_py.records.sensing import ROLES, NodeBits, node_names

_SOURCE_KINDS = {
    SourceState.GOOD: EventKind.SENSOR_GOOD,
    SourceState.SUSPECT: EventKind.SENSOR_SUSPECT,
    SourceState.LOST: EventKind.SENSOR_LOST,
}
_WEIGHT: Mapping[WeightState, tuple[EventKind, Cause]] = {
    WeightState.HELD: (EventKind.WEIGHT_HELD, Cause.NONE),
    WeightState.SILENT: (EventKind.WEIGHT_SILENT, Cause.NONE),
    WeightState.RELEASED: (EventKind.WEIGHT_RELEASED, Cause.HARDPOINT_OPEN),
    WeightState.STUCK: (EventKind.WEIGHT_NOT_RELEASED, Cause.HARDPOINT_HOLDS),
    WeightState.NOT_CONFIRMED: (EventKind.WEIGHT_NOT_RELEASED, Cause.HARDPOINT_SILENT),
    WeightState.GONE: (EventKind.WEIGHT_RELEASED, Cause.BY_ITSELF),
}


def sensor_events(before: SensorHealth, now: SensorHealth, fix_heard: bool = True) -> tuple[Event, ...]:
    """Return an event for each sensor whose state or fault is another one now.

    A receiver that was silent and is good where it still is not heard need not be: that it is silent stands beside it.
    """
    if now == before:
        return ()
    told = []
    for name, old, new in zip(SensorHealth._fields, before, now, strict=True):
        if new != old:
            unheard = name == "fix" and new == GOOD and not fix_heard
            fault = old.fault if unheard and old.fault is SourceFault.SILENT else new.fault
            numbers = (float(fault), *(() if unheard else _was_silent(old, new)))
            told.append(event(_SOURCE_KINDS[new.state], numbers=numbers, names=(name,)))
    return tuple(told)


def _was_silent(old: SourceHealth, new: SourceHealth) -> tuple[float, ...]:
    """Return that a sensor that is good now was only silent: there was nothing that it could contradict."""
    return (float(SourceFault.SILENT),) if new == GOOD and old.fault is SourceFault.SILENT else ()


def candidate_events(before: Sequence[Candidate], now: Sequence[Candidate]) -> tuple[Event, ...]:
    """Return an event for each role of which another device is believed now, and for each device whose health changed.

    The devices are named by their numbers, from 1: the role itself is that of the one that is believed.
    """
    if now is before or now == before:
        return ()
    told: list[Event] = []
    were = {(one.role, one.number): one for one in before}
    believed = {one.role: one for one in before if one.believed}
    for one in now:
        role, was = ROLES[one.role], were.get((one.role, one.number))
        before_it = was.health if was is not None else GOOD
        if one.health != before_it:
            number, kind = float(one.health.fault), _SOURCE_KINDS[one.health.state]
            numbers = number, *_was_silent(before_it, one.health)
            told.append(event(kind, numbers=numbers, names=(f"{role}.{one.number + 1}",)))
        old = believed.get(one.role)
        if one.believed and (old is None or old.number != one.number) and (one.number or old is not None):
            left = 0 if old is None else old.number
            fault = next(each.left for each in now if (each.role, each.number) == (one.role, left))
            numbers = (one.number + 1.0, left + 1.0, float(fault))
            told.append(event(EventKind.CANDIDATE_BELIEVED, numbers=numbers, names=(role,)))
    return tuple(told)


def position_events(fix_jump: float) -> tuple[Event, ...]:
    """Return an event if fixes put the position right by so much in this tick, m."""
    return (event(EventKind.POSITION_RESET, numbers=(fix_jump,)),) if fix_jump > 0.0 else ()


def actuator_events(before: ActuatorHealth, now: ActuatorHealth, fins: Sequence[str]) -> tuple[Event, ...]:
    """Return an event for each actuator whose fault is another one now; `fins` are their names."""
    if now is before or now == before:
        return ()
    names, olds, news = (*fins, "propeller"), (*before.fins, before.propeller), (*now.fins, now.propeller)
    return tuple(
        event(
            EventKind.ACTUATOR_FAULT if new is not ActuatorFault.NONE else EventKind.ACTUATOR_GOOD,
            numbers=(float(new),),
            names=(name,),
        )
        for name, old, new in zip(names, olds, news, strict=True)
        if new is not old
    )


def weight_events(before: WeightState, now: WeightState, limit: float) -> tuple[Event, ...]:
    """Return an event if the drop weight is in another state now; `limit` is the time to confirm its release, s.

    The command is told where it is given, and that a weight is held at the start goes without saying.
    """
    if now is before or now not in _WEIGHT or (now, before) == (WeightState.HELD, WeightState.UNREPORTED):
        return ()
    kind, cause = _WEIGHT[now]
    numbers = (limit,) if cause in (Cause.HARDPOINT_HOLDS, Cause.HARDPOINT_SILENT) else ()
    return (event(kind, cause, numbers),)


def node_events(before: NodeBits, now: NodeBits, fins: Sequence[str], shared: Sequence[int] = ()) -> tuple[Event, ...]:
    """Return an event for each node whose bits are others now.

    Args:
        before: of the last tick.
        now: of this one.
        fins: the names of the fins; some may have nodes of their own.
        shared: the bits of each node with several roles, together: its event names all of them.
    """
    if now == before:
        return ()
    begun = now.restarted & ~before.restarted
    names = _names_of_nodes(fins, shared)
    begun_anew = [event(EventKind.NODE_RESTARTED, names=roles) for bits, roles in names.items() if begun & bits]
    return tuple(begun_anew) + _node_faults(before, now, names)


def _names_of_nodes(fins: Sequence[str], shared: Sequence[int]) -> dict[int, tuple[str, ...]]:
    """Return the names of the roles of each node by its bits, in the order of their first."""
    named: dict[int, tuple[str, ...]] = {}
    for bit, name in node_names(fins).items():
        bits = next((together for together in shared if together & bit), bit)
        named[bits] = (*named.get(bits, ()), name)
    return named


def _node_faults(before: NodeBits, now: NodeBits, names: Mapping[int, tuple[str, ...]]) -> tuple[Event, ...]:
    olds, news = ([_node_fault(bits, bit) for bit in names] for bits in (before, now))
    return tuple(
        event(
            EventKind.NODE_FAULT if new is not SourceFault.NONE else EventKind.NODE_GOOD,
            numbers=(float(new),),
            names=roles,
        )
        for roles, old, new in zip(names.values(), olds, news, strict=True)
        if new is not old
    )


def _node_fault(bits: NodeBits, bit: int) -> SourceFault:
    two_senders, unhealthy, replaced, _ = bits
    if two_senders & bit:
        return SourceFault.TWO_SENDERS
    if replaced & bit:
        return SourceFault.OTHER_DEVICE
    return SourceFault.UNHEALTHY if unhealthy & bit else SourceFault.NONE
