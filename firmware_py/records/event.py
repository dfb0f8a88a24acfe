"""Events: what happened in a cycle, as values. `event_text` makes sentences of them for people."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass

from firmware_py.records.mission import ManoeuvreKind
from firmware_py.records.order import NOBODY, Asker, Mode


class Severity(enum.IntEnum):
    """The severity of an event, with the numbers and the meaning of MAV_SEVERITY."""

    EMERGENCY = 0  # the system is unusable
    ALERT = 1  # act immediately; a failure outside the primary systems
    CRITICAL = 2  # act immediately; a failure of a primary system
    ERROR = 3  # an error of a secondary or redundant system
    WARNING = 4  # will become an error unless somebody acts
    NOTICE = 5  # unusual, but no error
    INFO = 6  # normal operation; nobody has to act
    DEBUG = 7


class EventKind(enum.IntEnum):
    """What happened; the comment says what `Event.numbers` and `Event.names` are."""

    MODE_CHANGED = 0  # numbers: the cause's
    MODE_REFUSED = 1  # `after` was asked for
    ARMING_REFUSED = 2  # one event for each cause; numbers: the cause's
    ARMING_CHECK_FAILED = 3  # arming would be refused; one event for each cause; numbers: the cause's
    ARMING_CHECK_PASSED = 4
    RULE_HOLDS = 5  # one more failsafe asks for the mode in force; numbers: the cause's
    CHANGE_FAILED = 6  # names: why
    WAYPOINT_PASSED = 7  # numbers: which, counted from 1; of how many
    RALLY_POINT_REACHED = 8
    RALLY_POINT_UNREACHABLE = 9  # no rally point has a straight way within the fence
    LOITER_DONE = 10  # numbers: the mission's item, counted from 1
    MANOEUVRE_BEGUN = 11  # numbers: duration, s; depth, m
    MANOEUVRE_WAITS = 12  # at a limit; numbers: the cause's
    MANOEUVRE_RESUMED = 13
    MANOEUVRE_DONE = 14  # numbers: duration, s; waited, s
    MANOEUVRE_GIVEN_UP = 15  # numbers: flown, s; then the cause's
    LEARNING_REPORT = 16  # what was learned in a manoeuvre; one event for each cause; numbers and names: the cause's
    SENSOR_GOOD = 17  # names: the sensor; numbers: `SourceFault`: NONE, SILENT: need not be heard; SILENT if it was
    SENSOR_SUSPECT = 18  # it is not used; numbers: its `SourceFault`; names: the sensor
    SENSOR_LOST = 19  # numbers: its `SourceFault`; names: the sensor
    ACTUATOR_GOOD = 20  # numbers: NONE of `ActuatorFault`; names: the actuator
    ACTUATOR_FAULT = 21  # numbers: its `ActuatorFault`; names: the actuator
    ASCENT_STAGE = 22  # numbers: the `AscentStage`; the cause's
    WEIGHT_RELEASED = 23  # numbers: the cause's; told when its hardpoint says so, or as it is commanded if it is silent
    RULE_WARNS = 24  # a rule holds whose action is to warn; numbers: the cause's
    NODE_GOOD = 25  # of the bus; numbers: NONE of `SourceFault`; names: the node's roles
    NODE_FAULT = 26  # numbers: its `SourceFault`, TWO_SENDERS, OTHER_DEVICE or UNHEALTHY; names: its roles
    WAYPOINT_MISSED = 27  # its depth was not reached in time; numbers: which, of how many, how much too shallow, m
    MODE_CHOSEN = 28  # while disarmed: arming leads to `after`
    HOME_REACHED = 29
    HOME_UNREACHABLE = 30  # it has no straight way within the fence
    HOME_NOT_KNOWN = 31  # numbers: distance, m, and 1 sigma of the position, m
    WEIGHT_COMMANDED = 32  # to be released; numbers: the cause's
    WEIGHT_NOT_RELEASED = 33  # though it was commanded; numbers: the cause's
    WEIGHT_HELD = 34  # its hardpoint says so again
    WEIGHT_SILENT = 35  # its hardpoint says nothing any longer
    NODE_RESTARTED = 36  # names: the node's roles
    PARAMETER_CHANGED = 37  # one that safety rests on; names: its key, the value before, the value from now on
    DESIGN_CHANGED = 38  # of a law; numbers: `Source` of its coefficients, `Refusal`; names: the law
    MODEL_CHANGED = 39  # of what an earlier flight learned; numbers: 0 against vehicle.toml, 1 what this flight found
    # against the earlier; share of the change, sigmas; names: what, and the coefficient that shows it best
    POSITION_RESET = 40  # fixes that agree contradicted it; numbers: by how much, m
    CANDIDATE_BELIEVED = 41  # another device of a role; numbers: which, and which before, from 1, and the `SourceFault`
    # of that one, NONE: it is of less priority, CONTRADICTED: other sensors are; names: the role
    OWN_PART_FAILED = 42  # a part of one's own; the built-in one goes on; names: "law", its name, how


class Cause(enum.IntEnum):
    """Why it happened; the comment says what its numbers and names are."""

    NONE = 0
    ORDERED = 1  # by `Event.asker`
    # The rules, which end a mode.
    ATTITUDE_DEAD = 2  # limit, s; in older logs
    SURFACED = 3
    ATTITUDE_LOST = 4  # limit, s; `SourceFault` of the AHRS
    DEPTH_LOST = 5  # limit, s; `SourceFault` of the pressure sensor
    LEAK = 6
    BATTERY_LOW = 7  # charge and limit, in [0, 1]; NaN is not known
    DEPTH_LIMIT = 8  # depth and limit, m
    ALTITUDE_LIMIT = 9  # altitude and limit, m
    FENCE = 10  # `Fence.breach_at`
    LATE_CYCLES = 11  # late cycles of the last second, and limit
    MISSION_DONE = 12
    RETURN_DONE = 13
    # What arming needs beyond the rules.
    FINS_NOT_HEARD = 14  # limit, s
    TILT = 15  # tilt and limit, rad
    CHARGE_NEEDED = 16  # charge and limit, in [0, 1]; NaN is not known
    # Why a mode that was ordered is refused.
    DISARMED = 17
    SURFACING = 18
    NO_MISSION = 19
    # The limits at which a learning manoeuvre waits.
    MANOEUVRE_DEPTH = 20  # depth, depth ahead in time, least, greatest, m
    MANOEUVRE_ALTITUDE = 21  # altitude, altitude ahead in time, least, m
    MANOEUVRE_PITCH = 22  # pitch, pitch ahead in time, greatest, rad
    # What was learned and what was not.
    LEARNED_ALL = 23  # count of coefficients, greatest relative sigma; names: whose
    LEARNED = 24  # learned, count, valid of these, greatest relative sigma (where any is learned); names: whose
    NOT_FINITE = 25  # count of coefficients
    NOT_BEGUN = 26  # count of coefficients
    NEVER_EXCITED = 27  # names: coefficients that are not identifiable
    NOT_IDENTIFIABLE = 28  # names: coefficients, each by itself
    COMBINATION = 29  # numbers, names: weights and coefficients of a combination that is not identifiable
    NOT_EXCITED_AT_END = 30  # names: coefficients
    # More rules.
    BATTERY_WARNING = 31  # charge and level, in [0, 1]
    BATTERY_SILENT = 32  # limit, s
    LEAK_SILENT = 33  # limit, s
    PITCH = 34  # pitch and limit, rad
    ROLL = 35  # roll and limit, rad
    DEPTH_ERROR = 36  # depth, depth that is flown, limit, m
    NO_WAY_MADE = 37  # distance to the waypoint, m; limit, s
    ENERGY = 38  # charge, and what the way home needs, in [0, 1]
    SURFACING_LONG = 39  # s
    AHRS_SUSPECT = 40  # `SourceFault`
    PRESSURE_SUSPECT = 41  # `SourceFault`; in older logs
    DVL_BAD = 42  # `SourceFault`
    ALTIMETER_BAD = 43  # `SourceFault`
    BOTTOM_UNSEEN = 44
    PLANE_FAULT = 45  # `ActuatorFault`; names: whose
    RUDDER_FAULT = 46  # `ActuatorFault`; names: whose
    PROPELLER_FAULT = 47  # `ActuatorFault`; names: whose
    ACTUATOR_SILENT = 48  # `ActuatorFault`; names: whose
    ACTUATOR_WORN = 49  # `ActuatorFault`; names: whose
    BUS_SILENT = 50  # limit, s
    STATION_LOST = 51  # limit, s
    STICKS_LOST = 52  # limit, s
    HEADING_SUSPECT = 54
    WEIGHT_GONE = 55
    SUNK = 57  # depth, m
    RULES_OFF = 58  # names: keys and values under which it is not brought up
    RESTARTED = 56  # depth, m; `Mode` in which the program ended before; time since, s
    STARTED_UNDER_WATER = 59  # depth, m; NaN is not known
    # Why disarming is refused.
    UNDER_WATER = 53  # depth, m; NaN is not known
    # Why coming up goes on in another stage, and why the drop weight is released.
    PLANES_STUCK = 60
    DEEPER = 61  # than it was, m
    PITCH_OFF = 62  # pitch, desired pitch, rad
    NO_CLIMB = 63  # time, s
    ROLLED_OVER = 64  # roll, rad
    NO_DROP_WEIGHT = 65
    NOT_TOLD = 66  # time since SURFACE began, s
    NOT_UP = 67  # time since SURFACE began, s
    # Why the end of the flight is refused.
    NOTHING_TO_END = 70
    # What the drop weight's hardpoint says.
    HARDPOINT_OPEN = 71
    HARDPOINT_HOLDS = 72  # limit, s
    HARDPOINT_SILENT = 73  # limit, s
    BY_ITSELF = 74
    # One more rule.
    DEPTH_UNCHECKED = 75  # limit, s
    DAMAGED = 76  # `ActuatorFault`; shares left of diving and of turning, in [0, 1]; names: whose
    TERRAIN_LOST = 77
    LEFT_UNDER_WATER = 78  # depth, m


INTENDED_CAUSES = (Cause.ORDERED, Cause.MISSION_DONE, Cause.RETURN_DONE, Cause.SURFACED)
"""Causes of a change of mode that somebody asked for, at once or beforehand; with any other it is a failsafe."""


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that happened, SI and radians.

    `before` and `after` are modes, where it is about such; `asker` is the station that asked, `manoeuvre` the learning
    manoeuvre that it is about. `EventKind` and `Cause` say what `numbers` and `names` are.
    """

    kind: EventKind
    severity: Severity
    before: Mode | None = None
    after: Mode | None = None
    cause: Cause = Cause.NONE
    asker: Asker = NOBODY
    manoeuvre: ManoeuvreKind | None = None
    numbers: tuple[float, ...] = ()
    names: tuple[str, ...] = ()


_SEVERITIES: Mapping[EventKind, Severity] = {
    EventKind.MODE_CHANGED: Severity.CRITICAL,
    EventKind.MODE_REFUSED: Severity.WARNING,
    EventKind.ARMING_REFUSED: Severity.WARNING,
    EventKind.ARMING_CHECK_FAILED: Severity.WARNING,
    EventKind.ARMING_CHECK_PASSED: Severity.INFO,
    EventKind.RULE_HOLDS: Severity.CRITICAL,
    EventKind.CHANGE_FAILED: Severity.ERROR,  # it was checked before it was ordered
    EventKind.WAYPOINT_PASSED: Severity.INFO,
    EventKind.RALLY_POINT_REACHED: Severity.INFO,
    EventKind.RALLY_POINT_UNREACHABLE: Severity.WARNING,
    EventKind.LOITER_DONE: Severity.INFO,
    EventKind.MANOEUVRE_BEGUN: Severity.INFO,
    EventKind.MANOEUVRE_WAITS: Severity.NOTICE,
    EventKind.MANOEUVRE_RESUMED: Severity.INFO,
    EventKind.MANOEUVRE_DONE: Severity.INFO,
    EventKind.MANOEUVRE_GIVEN_UP: Severity.WARNING,
    EventKind.LEARNING_REPORT: Severity.NOTICE,
    EventKind.SENSOR_GOOD: Severity.NOTICE,
    EventKind.SENSOR_SUSPECT: Severity.WARNING,
    EventKind.SENSOR_LOST: Severity.ERROR,
    EventKind.ACTUATOR_GOOD: Severity.NOTICE,
    EventKind.ACTUATOR_FAULT: Severity.CRITICAL,
    EventKind.ASCENT_STAGE: Severity.WARNING,
    EventKind.WEIGHT_RELEASED: Severity.CRITICAL,
    EventKind.RULE_WARNS: Severity.WARNING,
    EventKind.NODE_GOOD: Severity.NOTICE,
    EventKind.NODE_FAULT: Severity.CRITICAL,
    EventKind.WAYPOINT_MISSED: Severity.WARNING,
    EventKind.MODE_CHOSEN: Severity.INFO,
    EventKind.HOME_REACHED: Severity.INFO,
    EventKind.HOME_UNREACHABLE: Severity.WARNING,
    EventKind.HOME_NOT_KNOWN: Severity.WARNING,
    EventKind.WEIGHT_COMMANDED: Severity.CRITICAL,
    EventKind.WEIGHT_NOT_RELEASED: Severity.ALERT,
    EventKind.WEIGHT_HELD: Severity.NOTICE,
    EventKind.WEIGHT_SILENT: Severity.WARNING,
    EventKind.NODE_RESTARTED: Severity.WARNING,
    EventKind.PARAMETER_CHANGED: Severity.NOTICE,
    EventKind.DESIGN_CHANGED: Severity.NOTICE,
    EventKind.MODEL_CHANGED: Severity.NOTICE,
    EventKind.POSITION_RESET: Severity.WARNING,
    EventKind.CANDIDATE_BELIEVED: Severity.WARNING,
    EventKind.OWN_PART_FAILED: Severity.ERROR,
}
_BY_CAUSE: Mapping[tuple[EventKind, Cause], Severity] = {
    **{(EventKind.MODE_CHANGED, cause): Severity.INFO for cause in INTENDED_CAUSES},
    (EventKind.LEARNING_REPORT, Cause.LEARNED_ALL): Severity.INFO,
    (EventKind.LEARNING_REPORT, Cause.NOT_FINITE): Severity.ERROR,
}
"""Severities that differ from that of the kind."""


def event(
    kind: EventKind,
    cause: Cause = Cause.NONE,
    numbers: tuple[float, ...] = (),
    names: tuple[str, ...] = (),
    *,
    before: Mode | None = None,
    after: Mode | None = None,
    asker: Asker = NOBODY,
    manoeuvre: ManoeuvreKind | None = None,
) -> Event:
    """Return an event, as severe as its kind and its cause are."""
    severity = _BY_CAUSE.get((kind, cause), _SEVERITIES[kind])
    return Event(kind, severity, before, after, cause, asker, manoeuvre, numbers, names)
