"""When surfacing is a failsafe, and what the records say of it: the cause, a breach, a depth beyond the limit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from firmware_py.records.command import ModeState
from firmware_py.records.event import Cause, Event, Severity
from firmware_py.records.fence import WITHIN, Disc, Fence
from firmware_py.records.health import ALL_GOOD, SourceFault, SourceHealth, SourceState
from firmware_py.records.order import NO_ORDER, NOBODY, Asker, Mode, Order
from firmware_py.safety.supervisor import Supervisor

from .test_supervisor import FORCE, PARAMS, STATE, old, sailing

STATION = Asker(0, 255, 190, 0)
RULED = {
    "depth lost": (Cause.DEPTH_LOST, {"depth_ok": False}),
    "attitude lost": (Cause.ATTITUDE_LOST, {"attitude_ok": False}),
    "leak": (Cause.LEAK, {"leak": True}),
    "too deep": (Cause.DEPTH_LIMIT, {"z": PARAMS.depth_max + 0.1}),
    "too near the bottom": (Cause.ALTITUDE_LIMIT, {"altitude": PARAMS.altitude_min - 0.1}),
}


def surfaced(vehicle: Any, **inputs: Any) -> ModeState:
    vehicle.ticks_until(Mode.SURFACE, 1000, **inputs)
    state: ModeState = vehicle.answer
    return state


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION])
def test_surfacing_that_a_station_orders_is_no_failsafe(mode: Mode) -> None:
    vehicle = sailing(mode)
    vehicle.tick(Order(mode=Mode.SURFACE, asker=STATION))
    for _ in range(3):
        assert (vehicle.mode, vehicle.answer.cause, vehicle.answer.failsafe) == (Mode.SURFACE, Cause.ORDERED, False)
        vehicle.tick()
    (event,) = events_of(Order(mode=Mode.SURFACE, asker=STATION))
    assert (event.severity, event.cause, event.asker) == (Severity.INFO, Cause.ORDERED, STATION)


@pytest.mark.parametrize(("mode", "cause"), [(Mode.MISSION, Cause.MISSION_DONE), (Mode.RETURN, Cause.RETURN_DONE)])
def test_surfacing_at_the_end_of_what_was_ordered_is_no_failsafe(mode: Mode, cause: Cause) -> None:
    vehicle = sailing(mode)
    vehicle.tick()
    state = surfaced(vehicle, done=True)
    assert (state.cause, state.failsafe) == (cause, False)


@pytest.mark.parametrize(("cause", "inputs"), RULED.values(), ids=RULED)
def test_surfacing_by_a_rule_is_a_failsafe_with_its_cause_for_as_long_as_it_lasts(
    cause: Cause, inputs: dict[str, Any]
) -> None:
    vehicle = sailing(Mode.HOLD)
    state = surfaced(vehicle, **inputs)
    assert (state.cause, state.failsafe) == (cause, True)
    vehicle.tick()  # all is well again, but surfacing is latched
    vehicle.tick(Order(mode=Mode.SURFACE, asker=STATION))  # and who orders it now did not begin it
    assert (vehicle.mode, vehicle.answer.cause, vehicle.answer.failsafe) == (Mode.SURFACE, cause, True)
    vehicle.tick(FORCE)
    assert (vehicle.mode, vehicle.answer.cause, vehicle.answer.failsafe) == (Mode.DISARMED, Cause.ORDERED, False)


def test_a_rule_that_begins_to_hold_while_surfacing_was_ordered_does_not_make_it_a_failsafe() -> None:
    vehicle = sailing(Mode.SURFACE)
    vehicle.tick(z=PARAMS.depth_max + 0.1)
    assert (vehicle.answer.cause, vehicle.answer.failsafe, vehicle.answer.too_deep) == (Cause.ORDERED, False, True)


def test_too_deep_is_said_for_as_long_as_it_is_so() -> None:
    vehicle = sailing(Mode.HOLD)
    for z, deep in ((PARAMS.depth_max, False), (PARAMS.depth_max + 0.1, True), (5.0, False)):
        vehicle.tick(z=z)
        assert vehicle.answer.too_deep is deep
        assert vehicle.answer.breach == WITHIN


POOL, ROCK = Disc(0.0, 0.0, 100.0), Disc(50.0, 0.0, 10.0)


def test_a_breach_is_said_at_once_and_by_its_place_and_surfacing_for_it_is_a_failsafe() -> None:
    vehicle = sailing(Mode.HOLD)
    fenced = Supervisor(PARAMS, fence=Fence((POOL,), (ROCK,)))
    fenced.thaw(vehicle.supervisor.freeze())
    vehicle.supervisor = fenced
    seen = {}
    for place, x in (("within", 0.0), ("rock", 50.0), ("within again", 0.0), ("outside", 101.0)):
        vehicle.tick(eta=STATE.eta._replace(x=x))
        seen[place] = vehicle.answer.breach
        assert vehicle.mode is Mode.HOLD  # for so short a time it may be an error of the position
        assert not vehicle.answer.failsafe
    assert seen["within"] == seen["within again"] == WITHIN
    assert len({seen["within"], seen["rock"], seen["outside"]}) == 3
    state = surfaced(vehicle, eta=STATE.eta._replace(x=101.0))
    assert (state.cause, state.failsafe, state.breach) == (Cause.FENCE, True, seen["outside"])
    vehicle.tick()
    assert (vehicle.answer.cause, vehicle.answer.failsafe, vehicle.answer.breach) == (Cause.FENCE, True, WITHIN)


def test_the_event_of_a_rule_is_critical_and_nobody_asked_for_it() -> None:
    (event,) = events_of(NO_ORDER, depth_ok=False)
    assert (event.severity, event.cause, event.asker) == (Severity.CRITICAL, Cause.DEPTH_LOST, NOBODY)


LOST = {
    "pressure frozen": ({"depth_ok": False}, "pressure", SourceFault.FROZEN, "no good depth for 1 s", "frozen"),
    "AHRS contradicted": (
        *({"attitude_ok": False}, "ahrs", SourceFault.CONTRADICTED),
        *("no good attitude for 0.5 s", "contradicted by the other sensors"),
    ),
}


@pytest.mark.parametrize(("inputs", "sensor", "fault", "what", "why"), LOST.values(), ids=LOST)
def test_a_lost_attitude_or_depth_is_told_with_what_is_wrong_with_its_sensor(
    inputs: dict[str, Any], sensor: str, fault: SourceFault, what: str, why: str
) -> None:
    sensors = ALL_GOOD._replace(**{sensor: SourceHealth(SourceState.SUSPECT, fault)})
    name = {"pressure": "pressure sensor", "ahrs": "AHRS"}[sensor]
    vehicle = sailing(Mode.HOLD)
    vehicle.tick(sensors=sensors, **inputs)
    assert vehicle.events[-1] == f"HOLD -> SURFACE: {what} ({name}: {why})"
    assert not any(f"{name}" in text for _ in range(400) for text in said(vehicle, sensors=sensors, **inputs))


def said(vehicle: Any, **inputs: Any) -> tuple[str, ...]:
    vehicle.tick(**inputs)
    events: tuple[str, ...] = vehicle.events
    return events


def test_silence_is_named_before_the_integrity_calls_the_sensor_lost() -> None:
    vehicle = sailing(Mode.HOLD)
    k = next(k for k in range(200) if vehicle.tick(frame={"pressure": old(k * 0.01, 1.5e5, vehicle.k)}) is Mode.SURFACE)
    assert k == 101
    assert vehicle.events == ("HOLD -> SURFACE: no good depth for 1 s (pressure sensor: silent)",)
    broken = sailing(Mode.HOLD)
    broken.tick(depth_ok=False, frame={"pressure": replace(old(1.1, 1.5e5, broken.k), ok=False)})
    assert broken.events[0].endswith("(pressure sensor: it reports that it does not work)")
    estimated = sailing(Mode.HOLD)
    estimated.tick(depth_ok=False)  # the estimator has its own reasons
    assert estimated.events == ("HOLD -> SURFACE: no good depth for 1 s",)


def events_of(order: Order, **state: Any) -> tuple[Event, ...]:
    """The events of a tick in HOLD with that order."""
    vehicle = sailing(Mode.HOLD)
    vehicle.tick(order, **state)
    return vehicle.supervisor.events
