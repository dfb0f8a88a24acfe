"""Sentences of events: every kind and every cause has one, with its numbers and their units."""

from __future__ import annotations

import enum
import math

import pytest

from firmware_py.records.adoption import Refusal, Source
from firmware_py.records.command import AscentStage
from firmware_py.records.event import INTENDED_CAUSES, Cause, Event, EventKind, Severity, event
from firmware_py.records.event_text import sentences, texts
from firmware_py.records.health import ActuatorFault, SourceFault
from firmware_py.records.health_text import source_fault_text
from firmware_py.records.mission import ManoeuvreKind
from firmware_py.records.order import Asker, Mode

STATION = Asker(0, 255, 190, 400)
NUMBERS: dict[Cause, tuple[float, ...]] = {
    Cause.ATTITUDE_DEAD: (30.0,),
    Cause.ATTITUDE_LOST: (0.5,),
    Cause.DEPTH_LOST: (1.0,),
    Cause.BATTERY_LOW: (0.05, 0.1),
    Cause.DEPTH_LIMIT: (31.0, 30.0),
    Cause.ALTITUDE_LIMIT: (1.25, 2.0),
    Cause.FENCE: (2.0,),
    Cause.LATE_CYCLES: (11.0, 10.0),
    Cause.FINS_NOT_HEARD: (1.0,),
    Cause.TILT: (1.0, 0.79),
    Cause.CHARGE_NEEDED: (math.nan, 0.2),
    Cause.MANOEUVRE_DEPTH: (56.0, 57.0, 55.0, 65.0),
    Cause.MANOEUVRE_ALTITUDE: (6.0, 5.0, 7.0),
    Cause.DEEPER: (2.1,),
    Cause.PITCH_OFF: (-0.5, 0.2),
    Cause.NO_CLIMB: (45.0,),
    Cause.ROLLED_OVER: (2.5,),
    Cause.NOT_TOLD: (90.0,),
    Cause.NOT_UP: (240.0,),
    Cause.SUNK: (1.5,),
    Cause.LEFT_UNDER_WATER: (1.5,),
    Cause.MANOEUVRE_PITCH: (0.4, 0.5, math.radians(25.0)),
    Cause.BATTERY_WARNING: (0.19, 0.2),
    Cause.BATTERY_SILENT: (30.0,),
    Cause.LEAK_SILENT: (30.0,),
    Cause.PITCH: (0.9, math.radians(45.0)),
    Cause.ROLL: (1.2, math.radians(60.0)),
    Cause.DEPTH_ERROR: (17.0, 10.0, 5.0),
    Cause.NO_WAY_MADE: (120.0, 180.0),
    Cause.ENERGY: (0.3, 0.35),
    Cause.SURFACING_LONG: (600.0,),
    Cause.AHRS_SUSPECT: (float(SourceFault.STEP),),
    Cause.PRESSURE_SUSPECT: (float(SourceFault.FROZEN),),
    Cause.DEPTH_UNCHECKED: (60.0,),
    Cause.DVL_BAD: (float(SourceFault.SILENT),),
    Cause.ALTIMETER_BAD: (float(SourceFault.SILENT),),
    Cause.PLANE_FAULT: (float(ActuatorFault.JAMMED),),
    Cause.RUDDER_FAULT: (float(ActuatorFault.HARD_OVER),),
    Cause.PROPELLER_FAULT: (float(ActuatorFault.LOST),),
    Cause.ACTUATOR_SILENT: (float(ActuatorFault.SILENT),),
    Cause.DAMAGED: (float(ActuatorFault.JAMMED), 0.28, 1.0),
    Cause.ACTUATOR_WORN: (float(ActuatorFault.SLOW),),
    Cause.BUS_SILENT: (2.0,),
    Cause.STATION_LOST: (20.0,),
    Cause.STICKS_LOST: (10.0,),
    Cause.UNDER_WATER: (5.0,),
    Cause.RESTARTED: (15.0, float(Mode.MISSION), 12.0),
    Cause.STARTED_UNDER_WATER: (15.0,),
    Cause.HARDPOINT_HOLDS: (3.0,),
    Cause.HARDPOINT_SILENT: (3.0,),
}
OF_FAULTS = (
    *(Cause.AHRS_SUSPECT, Cause.PRESSURE_SUSPECT, Cause.DVL_BAD, Cause.ALTIMETER_BAD),
    *(Cause.PLANE_FAULT, Cause.RUDDER_FAULT, Cause.PROPELLER_FAULT, Cause.ACTUATOR_SILENT, Cause.ACTUATOR_WORN),
)
"""Causes whose number is a `SourceFault` (the first four) or an `ActuatorFault`."""
REPORTED: dict[Cause, tuple[tuple[float, ...], tuple[str, ...]]] = {
    Cause.LEARNED_ALL: ((10.0, 0.02), ("Y_r",)),
    Cause.LEARNED: ((4.0, 10.0, 3.0, 0.03), ("Z_ds",)),
    Cause.NOT_FINITE: ((10.0,), ()),
    Cause.NOT_BEGUN: ((10.0,), ()),
    Cause.NEVER_EXCITED: ((), ("N_r", "N_v")),
    Cause.NOT_IDENTIFIABLE: ((), ("Y_v",)),
    Cause.COMBINATION: ((0.7, -0.7), ("Y_r", "Y_v")),
    Cause.NOT_EXCITED_AT_END: ((), ("N_r",)),
}
BY_KIND: dict[EventKind, tuple[float, ...]] = {
    EventKind.WAYPOINT_PASSED: (1.0, 3.0),
    EventKind.WAYPOINT_MISSED: (1.0, 3.0, 2.8),
    EventKind.LOITER_DONE: (2.0,),
    EventKind.MANOEUVRE_BEGUN: (120.0, 30.0),
    EventKind.MANOEUVRE_DONE: (120.0, 4.5),
    EventKind.HOME_NOT_KNOWN: (120.0, 150.0),
    EventKind.POSITION_RESET: (148.0,),
}
OF_HEALTH: dict[EventKind, type[enum.IntEnum]] = {
    EventKind.SENSOR_GOOD: SourceFault,
    EventKind.SENSOR_SUSPECT: SourceFault,
    EventKind.SENSOR_LOST: SourceFault,
    EventKind.ACTUATOR_GOOD: ActuatorFault,
    EventKind.ACTUATOR_FAULT: ActuatorFault,
    EventKind.ASCENT_STAGE: AscentStage,
    EventKind.NODE_GOOD: SourceFault,
    EventKind.NODE_FAULT: SourceFault,
}
"""Kinds whose first number is a member of an enumeration."""


def sample(kind: EventKind, cause: Cause = Cause.LEAK, numbers: tuple[float, ...] | None = None) -> Event:
    numbers = BY_KIND.get(kind, NUMBERS.get(cause, ())) if numbers is None else numbers
    return Event(kind, Severity.WARNING, Mode.HOLD, Mode.SURFACE, cause, STATION, ManoeuvreKind.PRBS, numbers, ("why",))


def test_of_weak_fins_that_act_together_the_axis_is_named() -> None:
    numbers = float(ActuatorFault.WEAK), 1.0, 0.5
    [text] = texts([event(EventKind.RULE_WARNS, Cause.DAMAGED, numbers, ("rudders",))])
    assert text == "damage found: rudders: half of the effect is left; 100% of diving and 50% of turning are left"
    [text] = texts([event(EventKind.RULE_HOLDS, Cause.RUDDER_FAULT, numbers[:1], ("rudders",))])
    assert text == "rudders: half of the effect is left (one more reason for the mode)"


@pytest.mark.parametrize("kind", [EventKind.RULE_WARNS, EventKind.RULE_HOLDS])
def test_a_rule_does_not_repeat_word_for_word_what_a_watch_told(kind: EventKind) -> None:
    silent, lost = (float(ActuatorFault.SILENT),), (float(SourceFault.SILENT),)
    watch = texts([event(EventKind.ACTUATOR_FAULT, numbers=silent, names=("stern_port",))])
    rule = texts([event(kind, Cause.ACTUATOR_SILENT, silent, ("stern_port",))])
    does = {EventKind.RULE_WARNS: "a rule warns", EventKind.RULE_HOLDS: "one more reason for the mode"}[kind]
    assert (watch, rule) == (["stern_port: reports nothing valid"], [f"stern_port: reports nothing valid ({does})"])
    assert texts([event(kind, Cause.DVL_BAD, lost)]) == [f"DVL not to be relied on: silent ({does})"]
    changed = event(EventKind.MODE_CHANGED, Cause.ACTUATOR_SILENT, silent, ("stern_port",), before=Mode.MISSION,
                    after=Mode.SURFACE)  # fmt: skip
    assert texts([changed]) == ["MISSION -> SURFACE: stern_port: reports nothing valid"]


def test_which_of_weak_fins_it_is_is_left_open_where_their_hull_alone_tells_of_it() -> None:
    """Of a pair that moves alike the hull shows what both do together: the one may be sound."""
    names = "stern_port", "stern_starboard", "rudder_upper"
    weak, jammed = float(ActuatorFault.WEAK), float(ActuatorFault.JAMMED)
    fault = EventKind.ACTUATOR_FAULT
    pair = [event(fault, numbers=(weak,), names=(name,)) for name in names[:2]]
    other = event(fault, numbers=(jammed,), names=names[2:])
    assert texts([*pair, other]) == [
        "stern_port or stern_starboard, one or more of them: makes less force than it should",
        "rudder_upper: jammed",
    ]
    assert texts(pair[:1]) == ["stern_port: makes less force than it should"]


def test_all_that_changed_of_a_vehicle_is_one_sentence() -> None:
    kind = EventKind.MODEL_CHANGED
    moved = [event(kind, numbers=(1.0, -0.22, 6.2), names=("rudder", "N_dr"))]
    moved += [event(kind, numbers=(1.0, 0.117, 4.0), names=("yaw damping", "N_r"))]
    clauses = "rudder (N_dr) -22 %, 6 sigma; yaw damping (N_r) +12 %, 4 sigma"
    assert texts(moved) == [f"this flight against the earlier: {clauses}"]


@pytest.mark.parametrize(
    "kind",
    sorted(
        set(EventKind)
        - {EventKind.LEARNING_REPORT, EventKind.DESIGN_CHANGED, EventKind.MODEL_CHANGED, EventKind.CANDIDATE_BELIEVED}
        - {EventKind.OWN_PART_FAILED}
        - set(OF_HEALTH)
    ),
)
def test_every_kind_has_a_sentence(kind: EventKind) -> None:
    numbers = (4.0,) if kind is EventKind.MANOEUVRE_GIVEN_UP else None
    (text,) = texts([sample(kind, numbers=numbers)])
    assert len(text) > 5
    assert all(f"{number:g}" in text for number in sample(kind).numbers)


@pytest.mark.parametrize("fault", SourceFault)
def test_a_device_that_is_believed_is_named_and_why(fault: SourceFault) -> None:
    [text] = texts([event(EventKind.CANDIDATE_BELIEVED, numbers=(2.0, 1.0, float(fault)), names=("dvl",))])
    why = f"the first: {source_fault_text(fault)}" if fault else "it is sound, and comes before the first"
    assert text == f"dvl: the second is believed; {why}"


@pytest.mark.parametrize(("name", "told"), [("altitude", "altimeter"), ("altitude.2", "altimeter.2"), ("dvl", "dvl")])
def test_the_altimeter_has_one_name_in_all_sentences(name: str, told: str) -> None:
    silent, none = (float(SourceFault.SILENT),), (float(SourceFault.NONE),)
    kinds = (EventKind.SENSOR_GOOD, none), (EventKind.SENSOR_SUSPECT, silent), (EventKind.SENSOR_LOST, silent)
    said = [texts([event(kind, numbers=fault, names=(name,))])[0] for kind, fault in kinds]
    assert said == [f"{told} agrees again", f"{told} not believed: silent", f"{told} lost: silent"]
    choice = event(EventKind.CANDIDATE_BELIEVED, numbers=(2.0, 1.0, *silent), names=(name,))
    assert texts([choice])[0].startswith(f"{told}: the second is believed")


@pytest.mark.parametrize("source", Source)
@pytest.mark.parametrize("refusal", Refusal)
def test_every_design_and_what_is_against_it_have_words(source: Source, refusal: Refusal) -> None:
    (text,) = texts([sample(EventKind.DESIGN_CHANGED, Cause.NONE, (float(source), float(refusal)))])
    assert text.startswith("why law: ")
    assert source.name not in text
    assert refusal.name not in text


@pytest.mark.parametrize(
    ("kind", "member"), [(kind, member) for kind, members in OF_HEALTH.items() for member in members]
)
def test_every_fault_and_every_stage_has_words(kind: EventKind, member: enum.IntEnum) -> None:
    (text,) = texts([sample(kind, Cause.NONE, (float(member),))])
    assert len(text) > 5
    assert member.name not in text


@pytest.mark.parametrize("cause", [cause for cause in Cause if cause not in REPORTED])
def test_every_cause_has_a_sentence_with_its_numbers(cause: Cause) -> None:
    (text,) = texts([sample(EventKind.MODE_CHANGED, cause)])
    assert text.startswith("HOLD -> SURFACE: ")
    assert "{" not in text
    units = (" m", " s", "%", " deg", " rad", "cycles", "exclusion 2")
    assert cause in OF_FAULTS or any(unit in text for unit in units) or not NUMBERS.get(cause)


@pytest.mark.parametrize("cause", OF_FAULTS)
def test_a_fault_behind_a_rule_is_told_in_words(cause: Cause) -> None:
    members = SourceFault if cause in OF_FAULTS[:4] else ActuatorFault
    said = {texts([sample(EventKind.RULE_WARNS, cause, (float(member),))])[0] for member in members}
    assert len(said) == len(members)


def test_angles_and_shares_are_told_as_people_think_of_them() -> None:
    pitch, battery, unknown = (
        sample(EventKind.RULE_HOLDS, cause) for cause in (Cause.MANOEUVRE_PITCH, Cause.BATTERY_LOW, Cause.CHARGE_NEEDED)
    )
    assert texts([pitch]) == ["pitch 23 deg, soon 29 deg, limit 25 deg"]
    assert texts([battery]) == ["battery at 5%, less than 10%"]
    assert texts([unknown]) == ["battery not heard, needs 20%"]


@pytest.mark.parametrize("cause", REPORTED)
def test_every_part_of_a_learning_report_is_told(cause: Cause) -> None:
    numbers, names = REPORTED[cause]
    report = Event(EventKind.LEARNING_REPORT, Severity.WARNING, cause=cause, manoeuvre=ManoeuvreKind.PRBS,
                   numbers=numbers, names=names)  # fmt: skip
    (text,) = texts([report])
    assert text.startswith("prbs: ")
    assert all(name in text for name in names)


def test_the_causes_of_a_refusal_come_in_one_sentence_as_severe_as_the_worst() -> None:
    parts = [sample(EventKind.ARMING_REFUSED, cause) for cause in (Cause.LEAK, Cause.DEPTH_LOST)]
    other = sample(EventKind.RULE_HOLDS)
    found = sentences([*parts, other])
    assert [sentence.text for sentence in found] == [
        "arming refused to station 255/190: water in the hull; no good depth for 1 s",
        "water in the hull",
    ]
    assert {sentence.severity for sentence in found} == {Severity.WARNING}


def test_of_a_weight_that_is_not_there_nothing_is_said_of_coming_up_before_that_begins() -> None:
    said = [event(EventKind.ASCENT_STAGE, Cause.NO_DROP_WEIGHT, (float(at),)) for at in (0, AscentStage.STOPPED)]
    assert texts(said) == ["no drop weight to release", "coming up: propeller stopped: no drop weight to release"]


def test_modes_are_called_what_the_reader_calls_them() -> None:
    (sentence,) = sentences([sample(EventKind.MODE_CHANGED, Cause.ORDERED)], lambda mode: mode.name.title())
    assert sentence.text == "Hold -> Surface: ordered by station 255/190"


def test_who_meant_a_change_of_mode_is_known() -> None:
    assert set(INTENDED_CAUSES) == {Cause.ORDERED, Cause.MISSION_DONE, Cause.RETURN_DONE, Cause.SURFACED}


@pytest.mark.parametrize("kind", EventKind)
def test_what_nobody_has_to_act_on_is_information(kind: EventKind) -> None:
    normal = {
        EventKind.ARMING_CHECK_PASSED,
        EventKind.WAYPOINT_PASSED,
        EventKind.RALLY_POINT_REACHED,
        EventKind.LOITER_DONE,
        EventKind.MANOEUVRE_BEGUN,
        EventKind.MANOEUVRE_RESUMED,
        EventKind.MANOEUVRE_DONE,
        EventKind.MODE_CHOSEN,
        EventKind.HOME_REACHED,
    }
    assert (event(kind).severity is Severity.INFO) == (kind in normal)


@pytest.mark.parametrize("cause", [cause for cause in Cause if cause not in REPORTED])
def test_a_failsafe_is_critical_and_a_change_of_mode_that_was_meant_is_information(cause: Cause) -> None:
    severity = event(EventKind.MODE_CHANGED, cause).severity
    assert severity is (Severity.INFO if cause in INTENDED_CAUSES else Severity.CRITICAL)
    assert event(EventKind.RULE_HOLDS, cause).severity is Severity.CRITICAL


def test_a_report_of_all_learned_is_information_and_one_that_is_not_finite_an_error() -> None:
    expected = {Cause.LEARNED_ALL: Severity.INFO, Cause.NOT_FINITE: Severity.ERROR}
    assert {cause: event(EventKind.LEARNING_REPORT, cause).severity for cause in REPORTED} == {
        cause: expected.get(cause, Severity.NOTICE) for cause in REPORTED
    }
