"""Numbers in the log that no schema explains: those of names, and those that a change is encoded as.

A log is read with today's meaning of its numbers. So whoever changes a number below, or the order of fields, must raise
`recorder.FORMAT` too, so that older logs are refused and not misread. A new name with a new number needs no new format.
"""

from __future__ import annotations

import base64
import dataclasses
import enum
import typing
from typing import Any

from firmware_py.adapters.storage import recorder
from firmware_py.records.adoption import Refusal, Source
from firmware_py.records.command import AscentStage
from firmware_py.records.cycle import Cycle
from firmware_py.records.estimate import VelocitySource
from firmware_py.records.event import Cause, EventKind, Severity
from firmware_py.records.fence import Disc, Fence, Place, Polygon
from firmware_py.records.health import ActuatorFault, FinEvidence, Role, SourceFault, SourceState, WeightState
from firmware_py.records.mission import Jump, Loiter, Manoeuvre, ManoeuvreKind, Mission, Surface, Waypoint
from firmware_py.records.order import Arming, Change, FenceChange, MissionChange, Mode, ParameterChange, RallyChange
from firmware_py.records.sensing import node_names
from firmware_py.wire.log.cdr_codec import CdrCodec
from firmware_py.wire.log.changes import ChangeKind, LoggedChange, LoggedChanges, decode, encode

NUMBERS: dict[type[enum.IntEnum], str] = {
    Mode: "DISARMED=0 MANUAL=1 HOLD=2 MISSION=3 SURFACE=4 LOITER=5 GUIDED=6 RETURN=7",
    Arming: "KEEP=0 ARM=1 DISARM=2 CHECK=3 FORCE_DISARM=4",
    Severity: "EMERGENCY=0 ALERT=1 CRITICAL=2 ERROR=3 WARNING=4 NOTICE=5 INFO=6 DEBUG=7",
    EventKind: (
        "MODE_CHANGED=0 MODE_REFUSED=1 ARMING_REFUSED=2 ARMING_CHECK_FAILED=3 ARMING_CHECK_PASSED=4 RULE_HOLDS=5 "
        "CHANGE_FAILED=6 WAYPOINT_PASSED=7 RALLY_POINT_REACHED=8 RALLY_POINT_UNREACHABLE=9 LOITER_DONE=10 "
        "MANOEUVRE_BEGUN=11 MANOEUVRE_WAITS=12 MANOEUVRE_RESUMED=13 MANOEUVRE_DONE=14 MANOEUVRE_GIVEN_UP=15 "
        "LEARNING_REPORT=16 SENSOR_GOOD=17 SENSOR_SUSPECT=18 SENSOR_LOST=19 ACTUATOR_GOOD=20 ACTUATOR_FAULT=21 "
        "ASCENT_STAGE=22 WEIGHT_RELEASED=23 RULE_WARNS=24 NODE_GOOD=25 NODE_FAULT=26 WAYPOINT_MISSED=27 MODE_CHOSEN=28 "
        "HOME_REACHED=29 HOME_UNREACHABLE=30 HOME_NOT_KNOWN=31 "
        "WEIGHT_COMMANDED=32 WEIGHT_NOT_RELEASED=33 WEIGHT_HELD=34 WEIGHT_SILENT=35 "
        "NODE_RESTARTED=36 PARAMETER_CHANGED=37 DESIGN_CHANGED=38 MODEL_CHANGED=39 "
        "POSITION_RESET=40 CANDIDATE_BELIEVED=41 OWN_PART_FAILED=42"
    ),
    VelocitySource: "NONE=0 DVL=1 FILTER=2 HULL_MODEL=3",
    Cause: (
        "NONE=0 ORDERED=1 ATTITUDE_DEAD=2 SURFACED=3 ATTITUDE_LOST=4 DEPTH_LOST=5 LEAK=6 BATTERY_LOW=7 "
        "DEPTH_LIMIT=8 ALTITUDE_LIMIT=9 FENCE=10 LATE_CYCLES=11 MISSION_DONE=12 RETURN_DONE=13 FINS_NOT_HEARD=14 "
        "TILT=15 CHARGE_NEEDED=16 DISARMED=17 SURFACING=18 NO_MISSION=19 MANOEUVRE_DEPTH=20 MANOEUVRE_ALTITUDE=21 "
        "MANOEUVRE_PITCH=22 LEARNED_ALL=23 LEARNED=24 NOT_FINITE=25 NOT_BEGUN=26 NEVER_EXCITED=27 "
        "NOT_IDENTIFIABLE=28 COMBINATION=29 NOT_EXCITED_AT_END=30 "
        "BATTERY_WARNING=31 BATTERY_SILENT=32 LEAK_SILENT=33 PITCH=34 ROLL=35 DEPTH_ERROR=36 NO_WAY_MADE=37 "
        "ENERGY=38 SURFACING_LONG=39 AHRS_SUSPECT=40 PRESSURE_SUSPECT=41 DVL_BAD=42 ALTIMETER_BAD=43 "
        "BOTTOM_UNSEEN=44 PLANE_FAULT=45 RUDDER_FAULT=46 PROPELLER_FAULT=47 ACTUATOR_SILENT=48 ACTUATOR_WORN=49 "
        "BUS_SILENT=50 STATION_LOST=51 STICKS_LOST=52 HEADING_SUSPECT=54 WEIGHT_GONE=55 SUNK=57 RULES_OFF=58 "
        "RESTARTED=56 STARTED_UNDER_WATER=59 "
        "UNDER_WATER=53 PLANES_STUCK=60 DEEPER=61 PITCH_OFF=62 NO_CLIMB=63 ROLLED_OVER=64 NO_DROP_WEIGHT=65 "
        "NOT_TOLD=66 NOT_UP=67 NOTHING_TO_END=70 HARDPOINT_OPEN=71 HARDPOINT_HOLDS=72 HARDPOINT_SILENT=73 BY_ITSELF=74 "
        "DEPTH_UNCHECKED=75 DAMAGED=76 TERRAIN_LOST=77 LEFT_UNDER_WATER=78"
    ),
    Source: "FILE=0 PASSPORT=1 LEARNED=2 LAST_GOOD=3 NOMINAL=4",
    Refusal: "NONE=0 OFF=1 UNCERTAIN=2 BOUND=3 DESIGN=4 RESIDUALS=5",
    Role: "AHRS=0 DVL=1 PRESSURE=2 ALTITUDE=3 FIX=4",
    SourceState: "GOOD=0 SUSPECT=1 LOST=2",
    SourceFault: (
        "NONE=0 SILENT=1 UNHEALTHY=2 IMPOSSIBLE=3 FROZEN=4 STEP=5 DRIFT=6 OUTLIERS=7 LATE=8 CONTRADICTED=9 "
        "TWO_SENDERS=10 HEADING=11 UNDECIDED=12 OTHER_DEVICE=13 STEERING=14 "
        "CURRENT=15"
    ),
    ActuatorFault: "NONE=0 SILENT=1 JAMMED=2 HARD_OVER=3 LOST=4 WEAK=5 SLOW=6 LOOSE=7 RUNAWAY=8 LAGGING=9",
    FinEvidence: "NONE=0 FEEDBACK=1 MOTION=2",
    WeightState: "UNREPORTED=0 HELD=1 SILENT=2 COMMANDED=3 RELEASED=4 STUCK=5 NOT_CONFIRMED=6 GONE=7",
    AscentStage: "NONE=0 POWERED=1 BLIND=2 LEVEL=3 REVERSE=4 STOPPED=5 WAITING=6 FULL=7",
    ManoeuvreKind: "ZIGZAG=1 DOUBLETS=2 PRBS=3",
    ChangeKind: "PARAMETERS=0 MISSION=1 FENCE=2 RALLY=3",
}
"""Each enumeration in the log, with the number of each name."""

GOLDEN: list[tuple[Change, LoggedChange]] = [
    (
        ParameterChange((("control.law", "pid"), ("rate_hz", 100))),
        LoggedChange(ChangeKind.PARAMETERS, '{"control.law": "pid", "rate_hz": 100}'),
    ),
    (
        MissionChange(
            Mission(
                (
                    Waypoint(x=1.0, y=2.0, z=3.0, u=4.0, above=True),
                    Loiter(x=5.0, y=6.0, z=7.0, u=8.0, above=False, radius=9.0, turns=10.0, duration=11.0),
                    Jump(to=0, times=-1),
                    Surface(rally=True),
                    Manoeuvre(ManoeuvreKind.PRBS, 60.0, 0.25, 0.5, 2.0, 33, 0.125, 0.375, 1.5),
                )
            )
        ),
        LoggedChange(
            ChangeKind.MISSION,
            numbers=(
                *(0, 1.0, 2.0, 3.0, 4.0, 1),
                *(1, 5.0, 6.0, 7.0, 8.0, 0, 9.0, 10.0, 11.0),
                *(2, 0, -1),
                *(3, 1),
                *(4, 3, 60.0, 0.25, 0.5, 2.0, 33, 0.125, 0.375, 1.5),
            ),
        ),
    ),
    (
        FenceChange(Fence(within=(Disc(1.0, 2.0, 3.0),), without=(Polygon(((4.0, 5.0), (6.0, 7.0), (8.0, 9.0))),))),
        LoggedChange(ChangeKind.FENCE, numbers=(0, 0, 1.0, 2.0, 3.0, 1, 3, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)),
    ),
    (
        RallyChange((Place(1.0, 2.0), Place(3.0, 4.0))),
        LoggedChange(ChangeKind.RALLY, numbers=(1.0, 2.0, 3.0, 4.0)),
    ),
]
"""A change of each kind with all types of items and areas, and what the log has of it."""

MESSAGE = """
AAEAAAcAAAAAAAAABAAAAAAAAAAnAAAAeyJjb250cm9sLmxhdyI6ICJwaWQiLCAicmF0ZV9oeiI6IDEwMH0AAAAAAAABAAAAAQAAAAAAAAAeAAAAAAAA
AAAAAAAAAAAAAADwPwAAAAAAAABAAAAAAAAACEAAAAAAAAAQQAAAAAAAAPA/AAAAAAAA8D8AAAAAAAAUQAAAAAAAABhAAAAAAAAAHEAAAAAAAAAgQAAA
AAAAAAAAAAAAAAAAIkAAAAAAAAAkQAAAAAAAACZAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAPC/AAAAAAAACEAAAAAAAADwPwAAAAAAABBAAAAAAAAACEAA
AAAAAABOQAAAAAAAANA/AAAAAAAA4D8AAAAAAAAAQAAAAAAAgEBAAAAAAAAAwD8AAAAAAADYPwAAAAAAAPg/AgAAAAEAAAAAAAAADQAAAAAAAAAAAAAA
AAAAAAAAAAAAAAAAAADwPwAAAAAAAABAAAAAAAAACEAAAAAAAADwPwAAAAAAAAhAAAAAAAAAEEAAAAAAAAAUQAAAAAAAABhAAAAAAAAAHEAAAAAAAAAg
QAAAAAAAACJAAwAAAAEAAAAAAAAABAAAAAAAAAAAAPA/AAAAAAAAAEAAAAAAAAAIQAAAAAAAABBA"""
"""All of these in one message of the log, as base64."""


def enumerations(hint: Any) -> set[type[enum.IntEnum]]:
    """Those that a record consists of."""
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return {hint}
    cls, inner = typing.get_origin(hint) or hint, [*typing.get_args(hint)]
    if dataclasses.is_dataclass(cls) or hasattr(cls, "_fields"):
        inner += typing.get_type_hints(cls).values()
    return set().union(*map(enumerations, inner))


def test_what_the_numbers_of_a_log_stand_for_changes_only_with_its_format() -> None:
    assert recorder.FORMAT == 4
    assert enumerations(Cycle) | enumerations(LoggedChanges) == set(NUMBERS)
    assert {cls: " ".join(f"{x.name}={int(x)}" for x in cls) for cls in NUMBERS} == NUMBERS


def test_the_bits_of_nodes_change_only_with_the_format_of_the_log() -> None:
    names = ["autopilot", "servo_hub", "esc", "ahrs", "pressure", "altimeter", "fix", "battery", "hardpoint"]
    spares = [f"{name}.{n}" for n in (2, 3, 4) for name in ("ahrs", "dvl", "pressure", "altimeter", "fix")]
    numbered = [*enumerate([*names, "fin_0", "fin_1"]), *enumerate(spares, 32), *enumerate(("bus", "second_bus"), 48)]
    assert node_names(("fin_0", "fin_1")) == {1 << i: name for i, name in numbered}


def test_changes_are_written_and_read_as_every_log_of_this_format_has_them() -> None:
    changes, logged = zip(*GOLDEN, strict=True)
    assert tuple(map(encode, changes)) == logged
    codec, message = CdrCodec.like(LoggedChanges(0, ())), base64.b64decode(MESSAGE)
    assert codec.encode(LoggedChanges(7, logged)) == message
    assert tuple(map(decode, codec.decode(message).changes)) == changes
