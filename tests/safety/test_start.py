"""A program that begins under water: what comes up by itself, what only warns, and what must not move."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from firmware_py.params import ParamError, dump, load
from firmware_py.records.health import ALL_GOOD, SourceFault, SourceHealth, SourceState
from firmware_py.records.order import NO_ORDER, Arming, Mode, Order
from firmware_py.records.sensing import Fix, Heard
from firmware_py.safety.action import Action
from firmware_py.safety.rules import SafetyParams
from firmware_py.safety.start import KeptMode

from .test_supervisor import PARAMS, SupervisedVehicle

AFTER = 501
"""The tick in which `restart_time` is over."""
LONG = 3000
KEPT = KeptMode(Mode.MISSION, 12.0)


def restarted(kept: KeptMode = KEPT, **actions: Action) -> SupervisedVehicle:
    vehicle = SupervisedVehicle(replace(PARAMS, **actions))
    vehicle.supervisor.resume(weight_gone=False, kept=kept)
    return vehicle


def said(vehicle: SupervisedVehicle, ticks: int, order: Order = NO_ORDER, **inputs: Any) -> list[str]:
    """What it says in so many ticks with the same inputs."""
    found: list[str] = []
    for _ in range(ticks):
        vehicle.tick(order, **inputs)
        found += vehicle.events
    return found


def fix(vehicle: SupervisedVehicle) -> Heard[Fix]:
    return Heard(Fix(0.6, -2.1, 2.0), vehicle.k * 0.01, True, True)


def test_a_vehicle_that_was_armed_comes_up_from_where_its_program_begins_again() -> None:
    vehicle = restarted()
    assert vehicle.ticks_until(Mode.SURFACE, LONG, z=15.0) == AFTER
    assert vehicle.events == (
        "DISARMED -> SURFACE: started again 15.0 m under water, 12 s after its program ended in MISSION",
    )
    assert vehicle.answer.failsafe
    assert not vehicle.answer.drop
    assert said(vehicle, LONG, z=15.0) == []
    assert vehicle.mode is Mode.SURFACE


def test_it_comes_up_though_its_fins_are_not_heard_and_its_charge_is_low() -> None:
    vehicle = restarted()
    assert vehicle.ticks_until(Mode.SURFACE, LONG, frame={"fins": (Heard(math.nan, -math.inf, False, False),) * 4}) == (
        AFTER
    )


@pytest.mark.parametrize(
    "inputs",
    [
        {"z": 0.9},
        {"z": 15.0, "depth_ok": False},
        {"z": 15.0, "sensors": ALL_GOOD._replace(pressure=SourceHealth(SourceState.SUSPECT, SourceFault.DRIFT))},
        {"z": 15.0, "sensors": ALL_GOOD._replace(fix=SourceHealth(SourceState.SUSPECT, SourceFault.IMPOSSIBLE))},
    ],
    ids=["at the surface", "depth lost", "pressure not believed", "fixes where none can be"],
)
def test_nothing_moves_where_no_good_depth_says_that_it_is_under_water(inputs: dict[str, Any]) -> None:
    vehicle = restarted()
    said(vehicle, LONG, **inputs)
    assert vehicle.mode is Mode.DISARMED


def test_nothing_moves_while_a_fix_is_heard() -> None:
    vehicle = restarted()
    for _ in range(LONG):
        vehicle.tick(z=2.0, frame={"fix": fix(vehicle)})
    assert vehicle.mode is Mode.DISARMED


def test_nothing_moves_when_it_is_carried_into_the_water_after_a_start_at_the_surface() -> None:
    vehicle = restarted()
    assert vehicle.supervisor.keep(0.0) == KEPT
    assert said(vehicle, AFTER + 1, z=0.1) == []
    assert said(vehicle, LONG, z=3.0) == []
    assert vehicle.mode is Mode.DISARMED
    assert vehicle.supervisor.keep(40.0) == KeptMode()


@pytest.mark.parametrize(("arming", "z"), [(Arming.FORCE_DISARM, 15.0), (Arming.DISARM, 0.9)])
def test_a_station_that_disarms_it_by_force_or_at_the_surface_is_obeyed(arming: Arming, z: float) -> None:
    vehicle = restarted()
    said(vehicle, 100, z=z)
    vehicle.tick(Order(arming=arming), z=z)
    assert said(vehicle, LONG, z=15.0) == []
    assert vehicle.mode is Mode.DISARMED


@pytest.mark.parametrize("order", [Order(arming=Arming.DISARM), Order(mode=Mode.DISARMED)])
@pytest.mark.parametrize(
    ("where", "at"), [({"z": 15.0}, "under water, at 15.0 m"), ({"depth_ok": False}, "depth not known")]
)
def test_under_water_an_order_to_disarm_is_refused_as_in_flight_and_it_comes_up(
    order: Order, where: dict[str, Any], at: str
) -> None:
    """It lay 15 m deep for good, and nothing was said."""
    vehicle = restarted(DEEP)
    said(vehicle, 100, **where)
    refused = f"DISARMED refused: {at}; surface first, or force it (param2 = 21196)"
    assert said(vehicle, 1, order, **where) == [refused]
    assert vehicle.ticks_until(Mode.SURFACE, LONG, **where) == AFTER - 101


def test_refused_it_does_not_forget_what_arming_leads_to() -> None:
    vehicle = restarted()
    vehicle.tick(Order(mode=Mode.HOLD, chooses=True), z=15.0)
    vehicle.tick(Order(arming=Arming.DISARM), z=15.0)
    assert vehicle.answer.chosen is Mode.HOLD


def test_who_arms_it_in_time_flies_it() -> None:
    vehicle = restarted()
    said(vehicle, 100)
    assert vehicle.tick(Order(arming=Arming.ARM, mode=Mode.HOLD)) is Mode.HOLD
    assert said(vehicle, LONG) == []
    assert vehicle.mode is Mode.HOLD


def test_a_vehicle_that_was_not_armed_says_once_that_it_is_under_water() -> None:
    vehicle = restarted(KeptMode())
    assert said(vehicle, LONG, z=15.0) == ["started 15.0 m under water; arm it in SURFACE to bring it up"]
    assert vehicle.mode is Mode.DISARMED


def test_a_vehicle_that_was_armed_and_does_not_know_its_depth_says_so() -> None:
    assert said(restarted(), LONG, depth_ok=False) == [
        "started where the depth is not known; arm it in SURFACE to bring it up"
    ]
    assert said(restarted(KeptMode()), LONG, depth_ok=False) == []  # as on any bench


@pytest.mark.parametrize(
    ("action", "mode", "drop", "count"),
    [
        (Action.NONE, Mode.DISARMED, False, 0),
        (Action.WARN, Mode.DISARMED, False, 1),
        (Action.SURFACE, Mode.SURFACE, False, 1),
        (Action.SURFACE_AND_DROP, Mode.SURFACE, True, 2),
    ],
)
@pytest.mark.parametrize("kept", [KEPT, KeptMode()])
def test_each_action_does_what_it_says(action: Action, mode: Mode, drop: bool, count: int, kept: KeptMode) -> None:
    vehicle = restarted(kept, **{"start_action" if kept == KeptMode() else "restart_action": action})
    assert len(said(vehicle, AFTER, z=15.0)) == count
    assert (vehicle.mode, vehicle.answer.drop) == (mode, drop)


@pytest.mark.parametrize("name", ["restart_action", "start_action", "sunk_action"])
def test_it_cannot_be_told_to_stay_there(name: str) -> None:
    with pytest.raises(ParamError, match=name):
        load(SafetyParams, {**dump(SafetyParams()), name: "hold"}, "autopilot.toml")


def test_a_program_that_ends_again_before_it_came_up_leaves_that_it_has_to() -> None:
    vehicle = restarted()
    said(vehicle, 100, z=15.0)
    assert vehicle.supervisor.keep(1.0) == KeptMode(Mode.MISSION, 13.0)
    vehicle.ticks_until(Mode.SURFACE, LONG, z=15.0)
    assert vehicle.supervisor.keep(6.0) == KeptMode(Mode.SURFACE, 0.0, 15.0)


DEEP = KeptMode(Mode.SURFACE, 12.0, 14.0)


def test_where_no_depth_is_heard_the_one_with_which_it_ended_counts_for_minutes() -> None:
    """Its pressure was lost, it came up, its program was killed: the next one stayed there, disarmed."""
    vehicle = restarted(DEEP)
    assert vehicle.ticks_until(Mode.SURFACE, LONG, depth_ok=False) == AFTER
    assert vehicle.events == (
        "DISARMED -> SURFACE: started again where the depth is not known, 12 s after its program ended in SURFACE",
    )


@pytest.mark.parametrize("change", [{"ago": 301.0}, {"depth": 0.5}, {"mode": Mode.DISARMED}])
def test_but_not_that_of_long_ago_nor_a_small_one_nor_of_who_was_disarmed(change: dict[str, Any]) -> None:
    vehicle = restarted(DEEP._replace(**change))
    said(vehicle, LONG, depth_ok=False)
    assert vehicle.mode is Mode.DISARMED


def test_nor_where_a_good_depth_or_a_fix_says_otherwise() -> None:
    vehicle = restarted(DEEP)
    said(vehicle, LONG, z=0.2)
    assert vehicle.mode is Mode.DISARMED
    vehicle = restarted(DEEP)
    for _ in range(LONG):
        vehicle.tick(depth_ok=False, frame={"fix": fix(vehicle)})
    assert vehicle.mode is Mode.DISARMED


@pytest.mark.parametrize(("kept", "mode"), [(DEEP, Mode.SURFACE), (KEPT, Mode.DISARMED)])
def test_where_it_was_deep_a_moment_ago_a_pressure_has_time_to_be_found_stuck_near_zero(
    kept: KeptMode, mode: Mode
) -> None:
    """It had 5 s of 0.2 m and was taken for one that is at the surface; the pressure was found out after 9 s."""
    vehicle = restarted(kept)
    said(vehicle, 1600, z=0.2)
    assert vehicle.mode is Mode.DISARMED
    said(vehicle, LONG, depth_ok=False)
    assert vehicle.mode is mode


def test_a_receiver_that_repeats_its_last_fix_does_not_speak_of_air() -> None:
    frozen = ALL_GOOD._replace(fix=SourceHealth(SourceState.SUSPECT, SourceFault.FROZEN))
    vehicle = restarted(DEEP)
    assert vehicle.ticks_until(Mode.SURFACE, LONG, depth_ok=False, sensors=frozen) == AFTER


def test_a_program_that_ends_twice_without_depth_leaves_the_one_that_was_good() -> None:
    """It came up blind, its reckoned depth began at 0, and the second kill left it where it was."""
    vehicle = restarted(DEEP)
    vehicle.ticks_until(Mode.SURFACE, LONG, depth_ok=False, z=0.0)
    assert vehicle.supervisor.keep(6.0) == KeptMode(Mode.SURFACE, 0.0, 14.0)
    vehicle.tick(depth_ok=False, z=0.0, frame={"fix": fix(vehicle)})
    assert vehicle.supervisor.keep(6.0).depth == 0.0
