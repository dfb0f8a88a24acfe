"""Each rule: what breaks it, after what time, and each action that it can be told to take."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from firmware_py.params import ParamError, dump, load
from firmware_py.records.command import Reference
from firmware_py.records.event import Cause, EventKind, Severity
from firmware_py.records.fence import Place
from firmware_py.records.health import (
    ALL_GOOD,
    SOUND_FIN,
    ActuatorFault,
    ActuatorHealth,
    FinEvidence,
    FinHealth,
    SourceFault,
    SourceHealth,
    SourceState,
    WeightState,
    sound,
)
from firmware_py.records.manoeuvrability import UNLIMITED
from firmware_py.records.order import Arming, Asker, Mode, Order, Sticks
from firmware_py.records.sensing import Battery, Heard
from firmware_py.safety.action import MODE_OF, Action
from firmware_py.safety.rules import RULES, SafetyParams
from firmware_py.safety.supervisor import Supervisor, VehicleFin
from firmware_py.tick import Tick

from .test_supervisor import DT_NS, FORCE, PARAMS, STATE, SupervisedVehicle, old, sailing

FINS = (VehicleFin("port"), VehicleFin("starboard"), VehicleFin("upper", r=0.5), VehicleFin("lower", r=0.5))
NONE, LOOSE = ActuatorFault.NONE, ActuatorFault.LOOSE
NAN = math.nan
HELPLESS = UNLIMITED._replace(turn=0.0, turn_left=0.0, up=0.0, up_left=0.0, dive_left=0.0)
CRIPPLED = UNLIMITED._replace(up=0.02, up_left=0.3, dive_left=0.3)
AT_PLACE = Reference(5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0, math.nan)


def battery(charge: float) -> dict[str, Any]:
    return {"frame": {"battery": Heard(Battery(48.0, 1.0, charge), 0.0, True, True)}}


def suspect(
    name: str, state: SourceState = SourceState.SUSPECT, fault: SourceFault = SourceFault.DRIFT
) -> dict[str, Any]:
    return {"sensors": ALL_GOOD._replace(**{name: SourceHealth(state, fault)})}


def faulty(fault: ActuatorFault, at: int) -> dict[str, Any]:
    health = [NONE] * 5
    health[at] = fault
    return {"actuators": ActuatorHealth(tuple(health[:4]), health[4]), "left": HELPLESS}


BLIND = ALL_GOOD._replace(
    dvl=SourceHealth(SourceState.LOST, SourceFault.SILENT), altitude=SourceHealth(SourceState.LOST, SourceFault.SILENT)
)


@dataclass(frozen=True)
class Case:
    """What breaks a rule, in which tick it answers, and the parameter of its answer."""

    cause: Cause
    action: str
    ticks: int
    inputs: dict[str, Any] = field(default_factory=dict)
    mode: Mode = Mode.MISSION


def lagging(*planes: ActuatorFault) -> dict[str, Any]:
    """Return these faults of the two planes, which leave all of the control that there was, by angles alone."""
    return {"actuators": ActuatorHealth((*planes, NONE, NONE), NONE), "left": UNLIMITED}


def stuck(source: FinEvidence, dive_left: float) -> dict[str, Any]:
    """Return a plane that stays at 15 deg, as far as is known, and what that leaves."""
    fin = FinHealth(0.0, math.radians(15.0), source)
    actuators = ActuatorHealth((ActuatorFault.JAMMED, NONE, NONE, NONE), NONE, left=(fin, *[SOUND_FIN] * 3))
    return {"actuators": actuators, "left": UNLIMITED._replace(dive_left=dive_left)}


UNSEEN = {"reference": replace(AT_PLACE, above=True), "altitude": math.nan}
SINKING = STATE.nu._replace(w=0.5)
PITCHED = STATE.eta._replace(theta=-0.55)
STEEP = STATE.nu._replace(u=1.5, w=0.7)
CASES = (
    Case(Cause.LEAK, "leak_action", 51, {"leak": True}),
    Case(Cause.BATTERY_LOW, "battery_action", 501, {**battery(0.09)}),
    Case(Cause.BATTERY_WARNING, "battery_warn_action", 501, battery(0.19)),
    Case(Cause.BATTERY_SILENT, "battery_silent_action", 3001, battery(math.nan)),
    Case(Cause.BATTERY_SILENT, "battery_silent_action", 3001, suspect("battery", SourceState.LOST)),
    Case(Cause.LEAK_SILENT, "leak_silent_action", 3001, {"frame": {"leak": Heard(math.nan, 0.0, True, True)}}),
    Case(Cause.DEPTH_LIMIT, "depth_max_action", 31, {"z": 30.1}),
    Case(Cause.DEPTH_LIMIT, "depth_max_action", 31, {"z": 29.0, "nu": STEEP, "left": CRIPPLED}),
    Case(Cause.DEPTH_LIMIT, "depth_max_action", 31, {"z": 28.0, "nu": STEEP, **lagging(ActuatorFault.SLOW, NONE)}),
    Case(Cause.DEPTH_LIMIT, "depth_max_action", 31, {"z": 28.0, "nu": STEEP, **lagging(LOOSE, ActuatorFault.SLOW)}),
    Case(Cause.ALTITUDE_LIMIT, "altitude_action", 101, {"altitude": 5.4, "nu": STEEP, "left": CRIPPLED}),
    Case(Cause.ALTITUDE_LIMIT, "altitude_action", 101, {"altitude": 1.9}),
    Case(Cause.ALTITUDE_LIMIT, "altitude_action", 101, {"altitude": 3.9, "nu": SINKING}),
    Case(Cause.ALTITUDE_LIMIT, "altitude_action", 101, {"altitude": 1.9, "eta": STATE.eta._replace(theta=math.nan)}),
    Case(Cause.PITCH, "pitch_action", 201, {"eta": STATE.eta._replace(theta=-0.8)}),
    Case(Cause.PITCH, "pitch_action", 201, {"eta": PITCHED, **lagging(NONE, ActuatorFault.LAGGING)}),
    Case(Cause.ROLL, "roll_action", 1001, {"eta": STATE.eta._replace(phi=1.1)}),
    Case(Cause.DEPTH_ERROR, "depth_error_action", 2001, {"reference": replace(AT_PLACE, z_d=10.1)}),
    Case(Cause.AHRS_SUSPECT, "ahrs_action", 201, suspect("ahrs")),
    Case(Cause.HEADING_SUSPECT, "heading_action", 201, suspect("ahrs", fault=SourceFault.HEADING)),
    Case(Cause.DVL_BAD, "dvl_action", 201, suspect("dvl")),
    Case(Cause.DVL_BAD, "dvl_action", 201, suspect("dvl", SourceState.LOST)),
    Case(Cause.ALTIMETER_BAD, "altimeter_action", 201, suspect("altitude", SourceState.LOST)),
    Case(Cause.DEPTH_UNCHECKED, "unchecked_action", 6001, {"altitude": math.nan}),
    Case(Cause.TERRAIN_LOST, "terrain_action", 201, {**UNSEEN, "sensors": BLIND}),
    Case(Cause.TERRAIN_LOST, "terrain_action", 201, {**UNSEEN, **suspect("altitude", SourceState.LOST)}),
    Case(Cause.PLANE_FAULT, "plane_action", 21, faulty(ActuatorFault.JAMMED, 0)),
    Case(Cause.PLANE_FAULT, "plane_action", 21, faulty(ActuatorFault.HARD_OVER, 1)),
    Case(Cause.RUDDER_FAULT, "rudder_action", 21, faulty(ActuatorFault.LOST, 3)),
    Case(Cause.DAMAGED, "damage_action", 21, {**faulty(ActuatorFault.JAMMED, 0), "left": CRIPPLED}),
    Case(Cause.PLANE_FAULT, "plane_action", 21, stuck(FinEvidence.FEEDBACK, 0.16)),
    Case(Cause.DAMAGED, "damage_action", 21, stuck(FinEvidence.MOTION, 0.16)),
    Case(Cause.PLANE_FAULT, "plane_action", 21, stuck(FinEvidence.MOTION, 0.09)),
    Case(Cause.DAMAGED, "damage_action", 21, {**faulty(ActuatorFault.WEAK, 3), "left": UNLIMITED}),
    Case(Cause.PROPELLER_FAULT, "propeller_action", 21, faulty(ActuatorFault.JAMMED, 4)),
    Case(Cause.PROPELLER_FAULT, "runaway_action", 21, faulty(ActuatorFault.RUNAWAY, 4)),
    Case(Cause.ACTUATOR_SILENT, "actuator_silent_action", 21, faulty(ActuatorFault.SILENT, 2)),
    Case(Cause.ACTUATOR_WORN, "actuator_worn_action", 21, faulty(ActuatorFault.SLOW, 0)),
    Case(Cause.ACTUATOR_WORN, "actuator_worn_action", 21, lagging(ActuatorFault.LAGGING, NONE)),
    Case(Cause.ACTUATOR_WORN, "actuator_worn_action", 21, lagging(ActuatorFault.SLOW, ActuatorFault.SLOW)),
    Case(Cause.PLANE_FAULT, "plane_action", 21, lagging(ActuatorFault.LAGGING, ActuatorFault.LAGGING)),
    Case(Cause.PLANE_FAULT, "plane_action", 21, lagging(ActuatorFault.JAMMED, ActuatorFault.LAGGING)),
    Case(Cause.PLANE_FAULT, "plane_action", 21, lagging(ActuatorFault.SILENT, ActuatorFault.LAGGING)),
    Case(Cause.STICKS_LOST, "sticks_action", 1001, mode=Mode.MANUAL),
)
IDS = [f"{case.cause.name}-{i}" for i, case in enumerate(CASES)]
QUIET = {rule.answer: Action.NONE for rule in RULES if isinstance(rule.answer, str) and "." not in rule.answer}


def told(action: Action, case: Case) -> SafetyParams:
    """Parameters under which the case's rule alone does anything, and does this."""
    station = replace(PARAMS.station, sticks_action=Action.NONE, manual_action=Action.NONE)
    if case.action == "sticks_action":
        return replace(PARAMS, **QUIET, station=replace(station, sticks_action=action))
    return replace(PARAMS, **{**QUIET, case.action: action}, station=station)


def answers(vehicle: SupervisedVehicle, case: Case, ticks: int) -> list[Cause]:
    """Feed the case for so many ticks; return the causes that were told of a rule, and of a mode changed."""
    kinds = (EventKind.RULE_WARNS, EventKind.RULE_HOLDS, EventKind.MODE_CHANGED)
    causes = []
    for _ in range(ticks):
        vehicle.tick(**case.inputs)
        causes += [event.cause for event in vehicle.supervisor.events if event.kind in kinds]
    return causes


def test_a_plane_that_is_too_slow_to_steer_with_shortens_a_dive_by_more() -> None:
    fins = (VehicleFin("port", 0.5, limit=0.4), VehicleFin("starboard", 0.5, limit=0.4), *FINS[2:])
    for fault, ends in ((ActuatorFault.SLOW, False), (ActuatorFault.LAGGING, True)):
        case = Case(Cause.DEPTH_LIMIT, "", 0, {"z": 26.5, "nu": STEEP, **lagging(fault, NONE)})
        assert (Cause.DEPTH_LIMIT in answers(sailing(Mode.MISSION, PARAMS, fins), case, 100)) == ends


def test_a_slow_rudder_shortens_no_dive() -> None:
    slow = {"actuators": ActuatorHealth((NONE, NONE, ActuatorFault.SLOW, NONE), NONE), "left": UNLIMITED}
    for case in (
        Case(Cause.DEPTH_LIMIT, "depth_max_action", 31, {"z": 28.0, "nu": STEEP, **slow}),
        Case(Cause.PITCH, "pitch_action", 201, {"eta": PITCHED, **slow}),
    ):
        vehicle = sailing(Mode.MISSION, told(Action.SURFACE, case), FINS)
        assert answers(vehicle, case, 300) == []


@pytest.mark.parametrize("sensor", ["ahrs", "pressure"])
def test_outliers_that_are_left_out_one_by_one_end_no_mode(sensor: str) -> None:
    vehicle = sailing(Mode.MISSION)
    case = Case(Cause.AHRS_SUSPECT, "ahrs_action", 0, suspect(sensor, fault=SourceFault.OUTLIERS))
    assert not answers(vehicle, case, 400)


def test_a_heading_that_gyros_carry_on_warns_and_ends_no_mode() -> None:
    vehicle = sailing(Mode.MISSION)
    case = Case(Cause.HEADING_SUSPECT, "heading_action", 0, suspect("ahrs", fault=SourceFault.HEADING))
    assert answers(vehicle, case, 400) == [Cause.HEADING_SUSPECT]


def test_a_vehicle_that_rises_is_not_too_near_to_the_bottom_ahead_of_it() -> None:
    rising = {"altitude": 2.1, "nu": STATE.nu._replace(w=-0.5)}
    slowly = {"altitude": 2.1, "nu": STATE.nu._replace(w=0.02)}
    for inputs in (rising, slowly):
        vehicle = sailing(Mode.MISSION)
        for _ in range(500):
            vehicle.tick(**inputs)
        assert vehicle.mode is Mode.MISSION


def allowed(case: Case, action: Action) -> SafetyParams | None:
    try:
        return told(action, case)
    except ParamError:
        return None


def releases(vehicle: SupervisedVehicle) -> list[Cause]:
    """Return why the drop weight was released in the last tick, by its events."""
    return [event.cause for event in vehicle.supervisor.events if event.kind is EventKind.WEIGHT_RELEASED]


@pytest.mark.parametrize("action", Action)
@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_a_rule_does_after_its_time_what_it_is_told_and_not_before(case: Case, action: Action) -> None:
    params = allowed(case, action)
    if params is None:
        assert action in (Action.HOLD, Action.RETURN)
        return
    vehicle = sailing(case.mode, params, FINS)
    assert answers(vehicle, case, case.ticks - 1) == []
    assert vehicle.mode is case.mode
    assert answers(vehicle, case, 1) == ([] if action is Action.NONE else [case.cause])
    assert vehicle.mode is MODE_OF.get(action, case.mode)
    drops = action is Action.SURFACE_AND_DROP and case.action != "propeller_action"  # which waits: below
    assert vehicle.answer.drop is drops
    assert releases(vehicle) == ([case.cause] if vehicle.answer.drop else [])
    assert vehicle.answer.failsafe is (action in MODE_OF)
    vehicle.tick()
    assert vehicle.answer.drop is drops  # what is dropped is dropped
    assert releases(vehicle) == []  # and told once


@pytest.mark.parametrize("by_rule", [True, False])
def test_without_a_drop_weight_nothing_is_released_and_that_is_said_once(by_rule: bool) -> None:
    case = next(case for case in CASES if case.action == "leak_action")
    vehicle = SupervisedVehicle(told(Action.SURFACE_AND_DROP, case), fins=FINS, weight=False)
    vehicle.tick(Order(mode=Mode.HOLD, arming=Arming.ARM))
    said, texts = [], list[str]()
    for _ in range(300):
        vehicle.tick(Order() if by_rule else Order(terminate=True), leak=by_rule)
        assert not vehicle.answer.drop
        said += [event.cause for event in vehicle.supervisor.events if event.kind is EventKind.ASCENT_STAGE]
        texts += vehicle.events
    assert vehicle.mode is Mode.SURFACE
    assert said == [Cause.NO_DROP_WEIGHT]
    assert "no drop weight to release" in texts


@pytest.mark.parametrize("case", CASES, ids=IDS)
def test_a_break_begins_the_time_anew(case: Case) -> None:
    vehicle = sailing(case.mode, told(Action.SURFACE, case), FINS)
    answers(vehicle, case, case.ticks - 1)
    steered = Order(sticks=Sticks(0.0, 0.0, 0.0), t_sticks=vehicle.k * DT_NS / 1e9)
    assert vehicle.tick(steered) is case.mode
    inputs = {**case.inputs}
    for _ in range(case.ticks - 1):
        assert vehicle.tick(**inputs) is case.mode


DEFAULTS = {
    "leak_action": Action.SURFACE,
    "battery_warn_action": Action.WARN,
    "battery_silent_action": Action.RETURN,
    "leak_silent_action": Action.WARN,
    "depth_error_action": Action.SURFACE,
    "dvl_action": Action.WARN,
    "terrain_action": Action.SURFACE,
    "plane_action": Action.SURFACE,
    "rudder_action": Action.SURFACE,
    "propeller_action": Action.SURFACE_AND_DROP,
    "actuator_silent_action": Action.WARN,
    "energy_action": Action.WARN,
    "surfacing_action": Action.WARN,
}


def test_what_is_done_unless_told_otherwise() -> None:
    assert {name: getattr(PARAMS, name) for name in DEFAULTS} == DEFAULTS


@pytest.mark.parametrize(
    "name", ["attitude_action", "depth_max_action", "plane_action", "propeller_action", "terrain_action"]
)
@pytest.mark.parametrize("action", [Action.HOLD, Action.RETURN])
def test_an_answer_that_cannot_be_flown_is_refused(name: str, action: Action) -> None:
    with pytest.raises(ParamError, match=f'{name} = "{action.name.lower()}"'):
        load(SafetyParams, {**dump(PARAMS), name: action.name.lower()}, "test")


@pytest.mark.parametrize("name", ["leak_action", "battery_action", "fence_action", "leg_action"])
def test_an_answer_that_keeps_what_is_wrong_is_refused_and_a_return_is_none(name: str) -> None:
    with pytest.raises(ParamError, match=f'{name} = "hold"'):
        load(SafetyParams, {**dump(PARAMS), name: "hold"}, "test")
    assert getattr(load(SafetyParams, {**dump(PARAMS), name: "return"}, "test"), name) is Action.RETURN


def test_a_warning_is_told_once_and_again_when_it_had_ended_but_not_more_often_than_each_minute() -> None:
    case = Case(Cause.BATTERY_WARNING, "battery_warn_action", 501, battery(0.19))
    vehicle = sailing(Mode.MISSION, told(Action.WARN, case))
    assert answers(vehicle, case, 3000) == [Cause.BATTERY_WARNING]
    vehicle.tick()
    assert answers(vehicle, case, 3000) == []  # it had been told half a minute ago
    assert answers(vehicle, case, 3000) == [Cause.BATTERY_WARNING]
    assert answers(vehicle, case, 6000) == []


def test_a_warning_is_a_warning_and_no_reason_not_to_arm() -> None:
    vehicle = SupervisedVehicle(replace(PARAMS, battery_arm=0.1))
    assert vehicle.tick(Order(arming=Arming.ARM), **battery(0.15)) is Mode.MANUAL
    for _ in range(600):
        vehicle.tick(Order(t_sticks=vehicle.k * 0.01), **battery(0.15))
        for event in vehicle.supervisor.events:
            assert (event.kind, event.severity) == (EventKind.RULE_WARNS, Severity.WARNING)


def test_hold_makes_nothing_of_a_mode_that_is_safer() -> None:
    params = replace(PARAMS, dvl_action=Action.HOLD)
    for mode in (Mode.RETURN, Mode.SURFACE):
        vehicle = sailing(mode, params)
        for _ in range(400):
            assert vehicle.tick(**suspect("dvl")) is mode


def test_the_safest_of_several_answers_is_the_mode() -> None:
    params = replace(PARAMS, leak_action=Action.RETURN, battery_warn_action=Action.HOLD)
    vehicle = sailing(Mode.MISSION, params)
    for _ in range(501):
        vehicle.tick(**battery(0.19))
    assert (vehicle.mode, vehicle.answer.cause) == (Mode.HOLD, Cause.BATTERY_WARNING)
    for _ in range(51):
        vehicle.tick(leak=True, **battery(0.19))
    assert (vehicle.mode, vehicle.answer.cause) == (Mode.RETURN, Cause.LEAK)
    vehicle.tick(done=True, leak=True)
    assert (vehicle.mode, vehicle.answer.cause, vehicle.answer.failsafe) == (Mode.SURFACE, Cause.RETURN_DONE, True)


def test_what_a_rule_held_may_be_ordered_away_when_it_ended() -> None:
    vehicle = sailing(Mode.MISSION, replace(PARAMS, dvl_action=Action.HOLD))
    vehicle.ticks_until(Mode.HOLD, 300, **suspect("dvl"))
    assert vehicle.tick(Order(mode=Mode.MISSION), **suspect("dvl")) is Mode.HOLD
    assert vehicle.tick(Order(mode=Mode.MISSION)) is Mode.MISSION
    assert not vehicle.answer.failsafe


X_AND_BOW = (
    *(VehicleFin(name, s, 0.35, 0.35) for name, s in (("a", 0.35), ("b", -0.35), ("c", 0.35), ("d", -0.35))),
    *(VehicleFin(name, 0.8, 0.0, 0.35) for name in ("bow_port", "bow_starboard")),
)


@pytest.mark.parametrize(
    ("dive_left", "turn_left", "said"),
    [
        (0.5, 0.5, "damage found: a: makes no force; 50% of diving and 50% of turning are left"),
        (0.5, 0.0, "MISSION -> SURFACE: a: makes no force"),
        (0.1, 0.1, "MISSION -> SURFACE: a: makes no force"),
    ],
)
def test_fins_that_act_on_both_axes_are_planes_and_rudders(dive_left: float, turn_left: float, said: str) -> None:
    """A vehicle whose X tail had come off flew on by its bow planes, without any way to turn."""
    vehicle = sailing(Mode.MISSION, PARAMS, X_AND_BOW)
    lost = ActuatorHealth((ActuatorFault.LOST,) * 4 + (NONE,) * 2, NONE)
    left = UNLIMITED._replace(dive_left=dive_left, turn_left=turn_left)
    told = [text for _ in range(21) if vehicle.tick(actuators=lost, left=left) for text in vehicle.events]
    assert [text for text in told if ": makes no force" in text][4:] == [said]
    cause = Cause.PLANE_FAULT if dive_left < 0.2 else Cause.RUDDER_FAULT
    assert vehicle.answer.cause is (cause if vehicle.mode is Mode.SURFACE else Cause.ORDERED)


def test_a_fin_of_an_x_that_keeps_it_from_being_armed_is_named_once() -> None:
    vehicle = SupervisedVehicle(fins=X_AND_BOW)
    jammed = ActuatorHealth((ActuatorFault.JAMMED, *(NONE,) * 5), NONE)
    for _ in range(30):
        vehicle.tick(actuators=jammed, left=HELPLESS)
    vehicle.tick(Order(arming=Arming.ARM), actuators=jammed, left=HELPLESS)
    assert vehicle.events == ("arming refused: a: jammed",)


def test_the_actuator_that_a_rule_is_about_is_named_in_its_event() -> None:
    vehicle = sailing(Mode.MISSION, replace(PARAMS, plane_action=Action.SURFACE_AND_DROP), FINS)
    vehicle.ticks_until(Mode.SURFACE, 30, **faulty(ActuatorFault.JAMMED, 1))
    assert vehicle.events[:2] == ("MISSION -> SURFACE: starboard: jammed", "drop weight released: starboard: jammed")
    worn = sailing(Mode.MISSION, PARAMS, FINS)
    for _ in range(21):
        worn.tick(**faulty(ActuatorFault.SLOW, 3))
    assert worn.events == ("lower: too slow (a rule warns)",)


def test_neither_altimeter_nor_dvl() -> None:
    vehicle = sailing(Mode.MISSION, replace(PARAMS, **{**QUIET, "bottom_action": Action.SURFACE}))
    assert vehicle.ticks_until(Mode.SURFACE, 300, sensors=BLIND) == 201
    assert vehicle.answer.cause is Cause.BOTTOM_UNSEEN


@pytest.mark.parametrize(
    "inputs",
    [
        {**UNSEEN, "reference": AT_PLACE, "sensors": BLIND},  # a depth is flown
        {**UNSEEN, "altitude": 6.0, **suspect("altitude", SourceState.LOST)},  # the DVL sees it
        UNSEEN,  # both are sound: it is out of their reach
    ],
    ids=["depth", "seen", "far"],
)
def test_a_bottom_that_need_not_be_seen_ends_no_mode(inputs: dict[str, Any]) -> None:
    vehicle = sailing(Mode.MISSION, replace(PARAMS, **{**QUIET, "terrain_action": Action.SURFACE}))
    for _ in range(1000):
        assert vehicle.tick(**inputs) is Mode.MISSION


@pytest.mark.parametrize("action", [Action.SURFACE, Action.WARN])
def test_a_mission_above_the_bottom_is_not_armed_blind_unless_that_is_wanted(action: Action) -> None:
    vehicle = SupervisedVehicle(replace(PARAMS, terrain_action=action))
    vehicle.supervisor = Supervisor(vehicle.supervisor._params, mission_above=True)
    begin = Order(mode=Mode.MISSION, arming=Arming.ARM)
    refused = action is Action.SURFACE
    assert vehicle.tick(begin, sensors=BLIND) is (Mode.DISARMED if refused else Mode.MISSION)
    if refused:
        assert "arming refused: the depth is flown above the bottom, which nothing sees" in vehicle.events
        assert vehicle.tick(begin, **suspect("dvl", SourceState.LOST)) is Mode.MISSION
        vehicle.tick(FORCE)
        assert vehicle.tick(Order(mode=Mode.HOLD, arming=Arming.ARM), sensors=BLIND) is Mode.HOLD


def test_a_silent_bus_is_told_as_such() -> None:
    params = replace(PARAMS, **{**QUIET, "bus_action": Action.SURFACE})
    vehicle = sailing(Mode.MISSION, params)
    vehicle.tick()
    whole = vehicle.frame()
    silent = {name: getattr(whole, name) for name in ("ahrs", "pressure", "fins", "n", "battery", "leak")}
    assert vehicle.ticks_until(Mode.SURFACE, 300, frame=silent) == pytest.approx(201, abs=1)
    assert vehicle.answer.cause is Cause.BUS_SILENT


def test_what_was_never_heard_is_not_silent() -> None:
    vehicle = sailing(Mode.MISSION, replace(PARAMS, battery_arm=0.0))
    unknown = {"battery": old(math.inf, Battery(math.nan, math.nan, math.nan), 0), "leak": old(math.inf, math.nan, 0)}
    vehicle = SupervisedVehicle(replace(PARAMS, battery_arm=0.0))
    vehicle.tick(Order(arming=Arming.ARM, mode=Mode.MISSION), frame=unknown)
    for _ in range(4000):
        assert vehicle.tick(frame=unknown) is Mode.MISSION
        assert vehicle.events == ()


# A leg, the energy, and how long surfacing takes: looked at once a second.


def on_leg(left: float, item: int = 0) -> Reference:
    return replace(AT_PLACE, cross_track=0.0, item=item, target=Place(500.0 + item, 0.0), target_distance=left)


SOON = replace(PARAMS, leg_way=1.0, leg_time=10.0, surfacing_time=10.0)
"""Times that a test need not wait for."""


def test_a_waypoint_that_comes_no_nearer() -> None:
    vehicle = sailing(Mode.MISSION, SOON)
    for k in range(3000):
        assert vehicle.tick(reference=on_leg(500.0 - 0.15 * k * 0.01)) is Mode.MISSION  # 1 m in 7 s
    assert 400 < vehicle.ticks_until(Mode.SURFACE, 1300, reference=on_leg(495.0)) <= 1201
    assert vehicle.answer.cause is Cause.NO_WAY_MADE


def test_circles_and_other_modes_make_no_way_and_need_none() -> None:
    for mode, reference in (
        (Mode.MISSION, replace(on_leg(30.0), cross_track=math.nan)),
        (Mode.GUIDED, on_leg(30.0)),
        (Mode.HOLD, AT_PLACE),
    ):
        vehicle = sailing(mode, SOON)
        for _ in range(1500):
            assert vehicle.tick(reference=reference) is mode


def test_the_next_leg_has_its_own_time() -> None:
    vehicle = sailing(Mode.MISSION, SOON)
    for item in range(3):
        for _ in range(900):
            assert vehicle.tick(reference=on_leg(100.0, item)) is Mode.MISSION


def driven(
    vehicle: SupervisedVehicle, charges: Iterable[float], u: float = 20.0, water: tuple[float, float] = (NAN, NAN)
) -> list[str]:
    """Drive 1000 m away from home, with another charge each second (NaN: not heard); return what is told."""
    told = []
    for charge in charges:
        for _ in range(100):
            heard = {} if math.isnan(charge) else battery(charge)["frame"]
            if not heard:
                heard = {"battery": old(9.0, Battery(48.0, 1.0, math.nan), vehicle.k)}
            else:
                heard = {"battery": replace(heard["battery"], t_valid=Tick(vehicle.k, DT_NS).t)}
            nu = STATE.nu._replace(u=u)
            vehicle.tick(eta=STATE.eta._replace(x=1000.0), nu=nu, reference=AT_PLACE, frame=heard, water=water)
            told += vehicle.events
    return told


def falling(charge: float, to: float, seconds: int) -> list[float]:
    return [charge + (to - charge) * k / seconds for k in range(1, seconds + 1)]


@pytest.mark.parametrize(("charge", "warns"), [(0.62, False), (0.30, True)])
def test_the_charge_that_brings_it_home(charge: float, warns: bool) -> None:
    """1000 m for 0.8 - charge, and 1000 m back with half as much again."""
    vehicle = sailing(Mode.MISSION)
    told = driven(vehicle, [*falling(0.8, charge, 50), *[charge] * 10])
    assert any("the way home needs" in text for text in told) is warns


def test_metres_that_a_current_gives_cost_no_charge_and_are_not_given_on_the_way_home() -> None:
    vehicle = sailing(Mode.MISSION)
    told = driven(vehicle, falling(0.8, 0.7, 50), water=(5.0, 0.0))
    progress = vehicle.supervisor.freeze().progress
    assert progress.used / progress.way == pytest.approx(0.1 / 750.0, rel=0.05)
    assert told == []


@pytest.mark.parametrize("gauge", ["swapped", "silent for a while", "in whole percents"])
def test_a_step_of_the_gauge_is_no_charge_used(gauge: str) -> None:
    charges = falling(0.8, 0.74, 50)
    after = [charge - 0.35 for charge in falling(0.74, 0.68, 50)]
    if gauge == "silent for a while":
        charges += [math.nan] * 20
    elif gauge == "in whole percents":
        charges, after = ([round(charge, 2) for charge in part] for part in (charges, falling(0.74, 0.68, 50)))
    vehicle = sailing(Mode.MISSION, replace(PARAMS, battery_silent_action=Action.NONE))
    assert driven(vehicle, [*charges, *after]) == []
    progress = vehicle.supervisor.freeze().progress
    assert progress.used / progress.way == pytest.approx(0.06 / 1000.0, rel=0.1)


def test_a_charge_that_rises_is_taken_off_what_was_used() -> None:
    vehicle = sailing(Mode.MISSION)
    driven(vehicle, [0.8 + 0.01 * (k % 2) for k in range(100)])
    assert abs(vehicle.supervisor.freeze().progress.used) <= 0.011


def test_a_charge_that_is_beyond_a_full_battery_is_told_in_words() -> None:
    vehicle = sailing(Mode.MISSION)
    told = driven(vehicle, falling(0.8, 0.25, 50), u=8.0)
    assert [text for text in told if "home" in text] == ["battery at 44%, not enough for the way home"]


def test_surfacing_that_does_not_end_is_told_again_and_again() -> None:
    vehicle = sailing(Mode.SURFACE, replace(SOON, surfacing_time=70.0))
    said = []
    for k in range(14_500):
        vehicle.tick(depth_ok=False)
        said += [k for event in vehicle.supervisor.events if event.cause is Cause.SURFACING_LONG]
    assert said == pytest.approx([7000, 14_000], abs=2)


# Stations and sticks.


def watched(t: float) -> Order:
    return Order(t_station=t, t_sticks=math.inf)


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.GUIDED, Mode.LOITER])
def test_without_its_station_it_holds_and_later_surfaces(mode: Mode) -> None:
    vehicle = sailing(mode)
    entered = {}
    for k in range(6500):
        now = vehicle.tick(watched(0.0))
        entered.setdefault(now, k)
    assert list(entered) == [mode, Mode.HOLD, Mode.SURFACE]
    assert entered[Mode.HOLD] == pytest.approx(2000, abs=2)
    assert entered[Mode.SURFACE] == pytest.approx(6000, abs=2)
    assert vehicle.answer.cause is Cause.STATION_LOST


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.GUIDED, Mode.LOITER, Mode.MISSION, Mode.RETURN])
def test_who_never_had_a_station_misses_none(mode: Mode) -> None:
    vehicle = sailing(mode)
    for _ in range(7000):
        assert vehicle.tick(watched(-math.inf)) is mode


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.GUIDED, Mode.LOITER])
def test_a_station_that_is_heard_now_and_then_is_enough(mode: Mode) -> None:
    vehicle = sailing(mode)
    for k in range(9000):
        assert vehicle.tick(watched(k // 1900 * 19.0)) is mode


def test_a_mission_is_flown_without_a_station_unless_told_otherwise() -> None:
    vehicle = sailing(Mode.MISSION)
    for _ in range(9000):
        assert vehicle.tick(watched(0.0)) is Mode.MISSION
    station = replace(PARAMS.station, mission_action=Action.RETURN)
    vehicle = sailing(Mode.MISSION, replace(PARAMS, station=station))
    assert vehicle.ticks_until(Mode.RETURN, 6010, order=watched(0.0)) == pytest.approx(6000, abs=2)


def test_sticks_may_rest_at_the_surface() -> None:
    vehicle = sailing(Mode.MANUAL)
    for _ in range(3000):
        assert vehicle.tick(z=0.9) is Mode.MANUAL


# The end of the flight.


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.MISSION, Mode.SURFACE])
def test_the_end_of_the_flight_is_the_surface_without_the_weight(mode: Mode) -> None:
    vehicle = sailing(mode)
    assert vehicle.tick(Order(terminate=True)) is Mode.SURFACE
    assert vehicle.answer.drop
    assert releases(vehicle) == [Cause.ORDERED]
    vehicle.tick(Order(terminate=True))
    assert vehicle.answer.drop
    assert releases(vehicle) == []
    vehicle.tick(FORCE)
    assert vehicle.answer.drop


GONE = "the drop weight is released already"


@pytest.mark.parametrize("earlier", [False, True])
def test_who_arms_without_a_drop_weight_is_told(earlier: bool) -> None:
    vehicle = SupervisedVehicle()
    if earlier:
        vehicle.supervisor.resume(weight_gone=True)
    else:
        vehicle.tick(Order(terminate=True))
    vehicle.tick(Order(arming=Arming.CHECK))
    assert vehicle.events == ("ready to be armed", GONE)
    assert vehicle.tick(Order(arming=Arming.ARM)) is Mode.MANUAL
    assert vehicle.events == (GONE, "DISARMED -> MANUAL: ordered")
    assert vehicle.answer.drop is not earlier  # what is fitted since is not released
    vehicle.tick(FORCE)
    needed = Supervisor(replace(PARAMS, weight_needed=True), drop_weight=True)
    needed.thaw(vehicle.supervisor.freeze())
    vehicle.supervisor = needed
    assert vehicle.tick(Order(arming=Arming.ARM)) is Mode.DISARMED
    assert vehicle.events == (f"arming refused: {GONE}",)
    assert vehicle.tick(Order(arming=Arming.ARM, mode=Mode.SURFACE)) is Mode.SURFACE


@pytest.mark.parametrize(("state", "gone"), [(WeightState.HELD, False), (WeightState.GONE, True)])
def test_a_hardpoint_knows_better_whether_a_weight_is_fitted(state: WeightState, gone: bool) -> None:
    vehicle = SupervisedVehicle()
    vehicle.supervisor.resume(weight_gone=not gone)
    reports = replace(sound(0), drop_weight=state)
    vehicle.tick(actuators=reports)
    vehicle.tick(Order(arming=Arming.ARM), actuators=reports)
    assert (GONE in vehicle.events) is gone


def test_who_has_a_drop_weight_or_never_had_one_is_told_nothing() -> None:
    for weight in (True, False):
        vehicle = SupervisedVehicle(weight=weight)
        vehicle.tick(Order(terminate=True) if not weight else Order())
        vehicle.tick(Order(arming=Arming.ARM))
        assert vehicle.events == ("DISARMED -> MANUAL: ordered",)


def test_a_disarmed_vehicle_drops_its_weight_under_water_only() -> None:
    vehicle = SupervisedVehicle()
    assert vehicle.tick(Order(terminate=True), z=0.2) is Mode.DISARMED
    assert vehicle.events == ("flight termination refused: disarmed, and not under water",)
    assert not vehicle.answer.drop
    assert vehicle.tick(Order(terminate=True), z=5.0) is Mode.DISARMED
    assert vehicle.answer.drop
    assert vehicle.events == ("drop weight released: ordered",)


# The drop weight, by what its hardpoint says.


def with_weight(vehicle: SupervisedVehicle, state: WeightState) -> tuple[str, ...]:
    """Return what is told when the actuator watch finds the drop weight in a state."""
    vehicle.tick(actuators=replace(sound(len(vehicle.fins)), drop_weight=state))
    return vehicle.events


@pytest.mark.parametrize(
    ("end", "told"),
    [
        (WeightState.RELEASED, "drop weight released: its hardpoint says so"),
        (WeightState.STUCK, "drop weight not released: its hardpoint still holds it 3 s after the command"),
        (
            WeightState.NOT_CONFIRMED,
            "drop weight not released: not confirmed 3 s after the command, its hardpoint says nothing",
        ),
    ],
)
def test_a_release_is_commanded_first_and_told_as_done_when_the_hardpoint_says_so(end: WeightState, told: str) -> None:
    vehicle = SupervisedVehicle()
    assert with_weight(vehicle, WeightState.HELD) == ()
    held = replace(sound(0), drop_weight=WeightState.HELD)
    vehicle.tick(Order(terminate=True), actuators=held)
    assert vehicle.answer.drop
    assert vehicle.events == ("release of the drop weight commanded: ordered",)
    assert with_weight(vehicle, WeightState.COMMANDED) == ()
    assert with_weight(vehicle, end) == (told,)
    assert with_weight(vehicle, end) == ()


def test_a_weight_that_goes_by_itself_is_told_and_not_commanded() -> None:
    vehicle = SupervisedVehicle()
    with_weight(vehicle, WeightState.HELD)
    assert with_weight(vehicle, WeightState.GONE) == ("drop weight released: its hardpoint says so, without a command",)
    assert not vehicle.answer.drop


def test_a_hardpoint_that_falls_silent_is_told_and_a_rule_warns() -> None:
    vehicle = sailing()
    with_weight(vehicle, WeightState.HELD)
    told = [text for _ in range(25) for text in with_weight(vehicle, WeightState.SILENT)]
    assert told == [
        "drop weight: its hardpoint says nothing any longer",
        "drop weight: reports nothing valid (a rule warns)",
    ]
    assert with_weight(vehicle, WeightState.HELD) == ("drop weight held: its hardpoint says so",)


@pytest.mark.parametrize("mode", [Mode.DISARMED, Mode.MANUAL, Mode.MISSION, Mode.SURFACE])
@pytest.mark.parametrize("z", [0.2, 5.0])
def test_the_weight_alone_is_released_in_any_mode_which_stays_and_who_asked_is_told(mode: Mode, z: float) -> None:
    vehicle = SupervisedVehicle() if mode is Mode.DISARMED else sailing(mode)
    assert vehicle.tick(Order(release=True, asker=Asker(0, 255, 190, 211)), z=z) is mode
    assert vehicle.answer.drop
    assert vehicle.events == ("drop weight released: ordered by station 255/190",)
    assert vehicle.tick(z=z) is mode
    assert vehicle.answer.drop


# A propeller without thrust: the weight goes when it is needed.


def without_propeller(z: float, rate: float, seconds: float, **inputs: Any) -> tuple[bool, float]:
    """Return whether the weight was released, and when, s, of a vehicle that sinks at `rate` from z, m."""
    vehicle = sailing(Mode.MISSION, fins=FINS)
    nu = STATE.nu._replace(u=0.0, w=rate)
    for k in range(round(seconds / 0.01)):
        vehicle.tick(z=z + rate * 0.01 * k, nu=nu, **faulty(ActuatorFault.LOST, 4) | inputs)
        if vehicle.answer.drop:
            return True, 0.01 * k
    return False, seconds


def test_a_vehicle_without_propeller_that_does_not_climb_releases_its_weight_after_its_time() -> None:
    dropped, t = without_propeller(10.0, 0.0, 20.0)
    assert dropped
    assert t == pytest.approx(10.2, abs=0.05)
    assert without_propeller(10.0, 0.2, 20.0) == (True, pytest.approx(10.2, abs=0.05))


def test_a_vehicle_without_propeller_that_coasts_up_keeps_its_weight() -> None:
    assert without_propeller(10.0, -0.2, 30.0) == (False, 30.0)
    assert without_propeller(10.0, -0.05, 30.0)[0]


def test_near_a_limit_and_sinking_the_weight_goes_at_once_and_level_it_does_not() -> None:
    assert without_propeller(28.5, 0.2, 5.0) == (True, pytest.approx(0.2, abs=0.02))
    assert without_propeller(10.0, 0.2, 5.0, altitude=3.5) == (True, pytest.approx(0.2, abs=0.02))
    assert not without_propeller(28.5, 0.0, 5.0)[0]


def test_without_depth_the_weight_goes_at_once() -> None:
    assert without_propeller(10.0, 0.0, 5.0, depth_ok=False) == (True, pytest.approx(0.2, abs=0.02))


def test_near_the_surface_no_weight_is_released_until_it_is_plain_that_it_stays_under() -> None:
    assert without_propeller(0.3, 0.0, 100.0) == (False, 100.0)
    dropped, t = without_propeller(1.2, 0.0, 100.0)
    assert dropped
    assert t > 40.0
