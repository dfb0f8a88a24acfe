"""A vehicle that surfaced and disarmed itself, and sinks again; and one that leaks as it surfaces."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from firmware_py.records.event import Cause, EventKind
from firmware_py.records.health import ALL_GOOD, SensorHealth, SourceFault, SourceHealth, SourceState
from firmware_py.records.order import NO_ORDER, Arming, Mode, Order
from firmware_py.safety.action import Action
from firmware_py.safety.safety_params import SafetyParams
from tests.safety.test_supervisor import DISARM, FORCE, PARAMS, SupervisedVehicle, heard_fix, sailing

SUNK = "DISARMED -> SURFACE: sunk again, to 1.5 m, after it had surfaced"
WARNED = "sunk again, to 1.5 m, after it had surfaced"
LEFT = "disarmed, and 1.5 m under water; arm it in SURFACE to bring it up"
RELEASED = "drop weight released: sunk again, to 1.5 m, after it had surfaced"


def surfaced(params: SafetyParams = PARAMS, failed: bool = True, **state: Any) -> SupervisedVehicle:
    """Return a vehicle that has come up by an order, or because its attitude `failed`, and has just disarmed itself."""
    vehicle = sailing(Mode.HOLD if failed else Mode.SURFACE, params)
    if failed:
        after(vehicle, 2.0, attitude_ok=False, z=5.0)
        assert vehicle.mode is Mode.SURFACE
    return disarmed(vehicle, **state)


def disarmed(vehicle: SupervisedVehicle, **state: Any) -> SupervisedVehicle:
    """Return it at the surface, once it has disarmed itself."""
    for _ in range(1000):
        vehicle.tick(z=0.2, frame=heard_fix(vehicle), **state)
        if vehicle.mode is Mode.DISARMED:
            return vehicle
    raise AssertionError("still armed")


def after(vehicle: SupervisedVehicle, seconds: float, order: Order = NO_ORDER, **state: Any) -> list[str]:
    """Let time pass after an order, and return what was said."""
    said: list[str] = []
    for k in range(round(seconds / 0.01)):
        vehicle.tick(order if k == 0 else NO_ORDER, **state)
        said += vehicle.events
    return said


def test_who_came_up_by_order_and_sinks_has_the_power_to_come_up_once_more() -> None:
    vehicle = surfaced(failed=False)
    assert after(vehicle, 10.1, z=1.5)[0] == SUNK
    assert not vehicle.answer.drop
    disarmed(vehicle)
    assert after(vehicle, 10.1, z=1.5)[:2] == [SUNK, RELEASED]


def test_who_came_up_by_order_and_sinks_with_a_leak_releases_the_weight_at_once() -> None:
    vehicle = surfaced(failed=False)
    assert any(text.startswith("drop weight released: ") for text in after(vehicle, 10.1, z=1.5, leak=True))


def test_who_sinks_after_it_disarmed_itself_surfaces_again_and_releases_the_weight() -> None:
    vehicle = surfaced()
    assert not after(vehicle, 60.0, z=0.9)
    assert not after(vehicle, 9.9, z=1.5)
    assert not after(vehicle, 1.0, z=0.9)
    assert after(vehicle, 10.1, z=1.5)[:2] == [SUNK, RELEASED]
    assert vehicle.mode is Mode.SURFACE
    assert vehicle.answer.drop
    assert vehicle.answer.failsafe


@pytest.mark.parametrize(
    ("action", "mode", "drop", "said"),
    [
        (Action.NONE, Mode.DISARMED, False, []),
        (Action.WARN, Mode.DISARMED, False, [WARNED]),
        (Action.SURFACE, Mode.SURFACE, False, [SUNK]),
        (Action.SURFACE_AND_DROP, Mode.SURFACE, True, [SUNK, RELEASED]),
    ],
)
def test_each_action_does_what_it_says(action: Action, mode: Mode, drop: bool, said: list[str]) -> None:
    vehicle = surfaced(replace(PARAMS, sunk_action=action))
    assert after(vehicle, 10.1, z=1.5)[: len(said) or 1] == said
    assert (vehicle.mode, vehicle.answer.drop) == (mode, drop)


@pytest.mark.parametrize("order", [DISARM, FORCE, Order(mode=Mode.DISARMED)])
def test_an_order_to_disarm_ends_the_watch(order: Order) -> None:
    vehicle = surfaced()
    after(vehicle, 1.0, order, z=0.2)
    assert after(vehicle, 120.0, z=1.5) == [LEFT]
    assert vehicle.mode is Mode.DISARMED


@pytest.mark.parametrize("z", [0.2, 1.5])
def test_an_order_to_arm_that_is_refused_does_not_end_it(z: float) -> None:
    """A low battery kept it from being armed; the hull filled afterwards, and it lay 20 m deep and said nothing."""
    vehicle = surfaced()
    assert any(
        "arming refused" in text for text in after(vehicle, 1.0, Order(arming=Arming.ARM), z=z, attitude_ok=False)
    )
    assert SUNK in after(vehicle, 10.1, z=1.5)
    assert vehicle.answer.drop


def test_a_vehicle_that_was_disarmed_by_order_is_told_of_once_that_it_is_under_water() -> None:
    vehicle = sailing(Mode.HOLD)
    assert vehicle.tick(DISARM, z=0.2) is Mode.DISARMED
    assert not after(vehicle, 60.0, z=0.9)
    assert not after(vehicle, 10.0, z=1.5)
    assert after(vehicle, 600.0, z=1.5) == [LEFT]
    for _ in range(3000):
        vehicle.tick(z=1.5, frame=heard_fix(vehicle))
        assert not vehicle.events
    assert after(vehicle, 60.0, z=1.5) == [LEFT]
    assert not vehicle.answer.drop


def test_one_that_was_disarmed_by_force_under_water_stays_there_and_says_so() -> None:
    vehicle = sailing(Mode.HOLD)
    assert vehicle.tick(FORCE, z=1.5) is Mode.DISARMED
    assert after(vehicle, 60.0, z=1.5) == [LEFT]
    assert vehicle.mode is Mode.DISARMED


def test_a_vehicle_that_was_never_armed_is_lowered_in_peace() -> None:
    fresh = SupervisedVehicle()
    assert not after(fresh, 10.0, z=0.2)
    assert not after(fresh, 60.0, z=5.0)


def test_a_depth_that_is_not_good_or_that_a_fix_contradicts_is_no_sinking() -> None:
    vehicle = surfaced()
    assert not after(vehicle, 30.0, z=1.5, depth_ok=False)
    for _ in range(3000):
        assert vehicle.tick(z=1.5, frame=heard_fix(vehicle)) is Mode.DISARMED


FROZEN = ALL_GOOD._replace(fix=SourceHealth(SourceState.SUSPECT, SourceFault.FROZEN))
JUMPING = ALL_GOOD._replace(fix=SourceHealth(SourceState.SUSPECT, SourceFault.STEP))
NO_PRESSURE = ALL_GOOD._replace(pressure=SourceHealth(SourceState.SUSPECT, SourceFault.FROZEN))


@pytest.mark.parametrize(("sensors", "brought_up"), [(FROZEN, True), (JUMPING, False)])
def test_a_receiver_that_repeats_itself_tells_of_no_surface(sensors: SensorHealth, brought_up: bool) -> None:
    """It froze at the surface; the vehicle sank to the ground before its good pressure, for a fix was in doubt."""
    vehicle = surfaced()
    said = after(vehicle, 10.1, z=1.5, sensors=sensors, frame=heard_fix(vehicle))
    assert (SUNK in said) is brought_up


@pytest.mark.parametrize(
    "blind", [{"depth_ok": False}, {"sensors": NO_PRESSURE, "z": 0.2}], ids=["depth lost", "pressure frozen"]
)
def test_without_depth_and_fix_a_bottom_that_comes_nearer_tells_that_it_sinks(blind: dict[str, Any]) -> None:
    vehicle = surfaced(altitude=40.0)
    assert SUNK not in after(vehicle, 60.0, altitude=36.0, **blind)
    assert vehicle.mode is Mode.DISARMED
    said = after(vehicle, 10.1, altitude=34.0, **blind)
    assert said[0].startswith("DISARMED -> SURFACE: sunk again, ")
    assert vehicle.answer.drop


def test_a_bottom_that_comes_into_sight_counts_from_there() -> None:
    vehicle = surfaced(altitude=math.nan)
    assert not [text for text in after(vehicle, 20.0, altitude=44.0, depth_ok=False) if "SURFACE" in text]
    assert after(vehicle, 10.1, altitude=38.0, depth_ok=False)[0] == (
        "DISARMED -> SURFACE: sunk again, as the bottom that comes nearer says, after it had surfaced"
    )


def test_without_a_receiver_the_bottom_counts_from_where_it_surfaced() -> None:
    """It had seen 40 m at the start; over a flat bottom of 28 m it took a lost pressure for sinking."""
    vehicle = sailing(Mode.SURFACE, replace(PARAMS, ascent=replace(PARAMS.ascent, fix_needed=False)))
    after(vehicle, 1.0, z=20.0, altitude=40.0)
    for k in range(3000):
        vehicle.tick(z=max(0.2, 20.0 - 0.01 * k), altitude=min(27.8, 8.0 + 0.01 * k))
    assert vehicle.mode is Mode.DISARMED
    assert not [text for text in after(vehicle, 30.0, altitude=27.8, depth_ok=False) if "SURFACE" in text]
    assert after(vehicle, 10.1, altitude=22.0, depth_ok=False)[0].startswith("DISARMED -> SURFACE: sunk again")


def test_over_a_bottom_that_rises_who_hears_fixes_lies_at_the_surface() -> None:
    vehicle = surfaced(altitude=40.0)
    for k in range(3000):
        assert vehicle.tick(z=0.2, altitude=40.0 - 0.01 * k, depth_ok=False, frame=heard_fix(vehicle)) is Mode.DISARMED
    assert not [text for text in after(vehicle, 20.0, altitude=8.0, depth_ok=False) if "SURFACE" in text]


def test_who_surfaced_with_a_leak_releases_the_weight_as_it_disarms() -> None:
    vehicle = surfaced(leak=True)
    assert vehicle.events[0] == "SURFACE -> DISARMED: surfaced"
    kinds = [(event.kind, event.cause) for event in vehicle.supervisor.events]
    assert kinds[-1] == (EventKind.WEIGHT_RELEASED, Cause.LEAK)
    assert vehicle.answer.drop
    dry = surfaced()
    assert not dry.answer.drop
