"""The words of the page for what was named and done, each with its meaning."""

from __future__ import annotations

from collections.abc import Mapping

from firmware_py.records.command import AscentStage
from firmware_py.records.event import Cause
from firmware_py.records.health import ActuatorFault, SourceFault
from sternplane.study.safety.columns import words

STAGES: Mapping[AscentStage, str] = {
    AscentStage.POWERED: "it climbs by propeller and planes",
    AscentStage.BLIND: "without attitude: planes by the pitch that velocity and pressure tell, or at a fixed angle",
    AscentStage.LEVEL: "near the surface, with little pitch, so that the bow does not hang out of the water",
    AscentStage.REVERSE: "it goes down or is far off: the propeller takes the way off, healthy planes oppose",
    AscentStage.STOPPED: "the propeller rests; what buoyancy there is brings it up",
    AscentStage.WAITING: "near the surface, as far as is known, but nothing tells of it: slowly on; after its time the "
    "drop weight goes",
    AscentStage.FULL: "it sinks with its bow up, heavier than the water: it climbs with full power",
}
"""How the vehicle comes up."""
SENSORS: Mapping[SourceFault, str] = {
    SourceFault.SILENT: "nothing comes",
    SourceFault.UNHEALTHY: "it says so itself: not a number, not valid, or its node's status",
    SourceFault.IMPOSSIBLE: "no such value can be",
    SourceFault.FROZEN: "exact repeats, or less noise than the sensor has",
    SourceFault.STEP: "its error changed at once",
    SourceFault.DRIFT: "its error grows slowly",
    SourceFault.OUTLIERS: "single wrong values, more than now and then",
    SourceFault.LATE: "its values come late",
    SourceFault.CONTRADICTED: "other sensors or the vehicle's model speak against it: it is the wrong one",
    SourceFault.UNDECIDED: "it and another sensor contradict each other, and nothing tells which is wrong: the safer "
    "reading holds",
    SourceFault.TWO_SENDERS: "two speak under one node id",
    SourceFault.OTHER_DEVICE: "another device answers under its node id",
    SourceFault.HEADING: "of the AHRS: heading against its gyros, which carry it on",
    SourceFault.STEERING: "of the AHRS: heading and gyro turn otherwise than the rudder turns the vehicle",
    SourceFault.CURRENT: "of the DVL: the current that it tells of changes as currents do not",
}
"""As what a sensor is named."""
ACTUATORS: Mapping[ActuatorFault, str] = {
    ActuatorFault.SILENT: "it reports nothing that is believed; whether it moves is not known",
    ActuatorFault.JAMMED: "it stays where it is",
    ActuatorFault.HARD_OVER: "it is jammed at the end of its travel",
    ActuatorFault.LOST: "it moves, but makes no force",
    ActuatorFault.WEAK: "it makes less force than it should",
    ActuatorFault.SLOW: "it turns more slowly than it should",
    ActuatorFault.LOOSE: "it has play",
    ActuatorFault.RUNAWAY: "of the propeller, which turns faster than it is told",
    ActuatorFault.LAGGING: "of a fin that turns too slowly to steer with",
}
"""As what a fin or the propeller is named."""
RULES: Mapping[Cause, str] = {
    Cause.ATTITUDE_LOST: "no attitude that can be believed",
    Cause.DEPTH_LOST: "no depth that can be believed",
    Cause.DEPTH_UNCHECKED: "pressure alone tells the depth, for too long: neither DVL nor bottom would show its drift",
    Cause.DEPTH_LIMIT: "the depth comes to its limit",
    Cause.DEPTH_ERROR: "the depth is far from the one that is flown",
    Cause.ALTITUDE_LIMIT: "the bottom comes too near",
    Cause.PITCH: "pitched too far",
    Cause.ROLL: "rolled too far",
    Cause.AHRS_SUSPECT: "the AHRS is not relied on, and carried on by gyros or the model",
    Cause.HEADING_SUSPECT: "the AHRS's heading is not believed, and carried on by its gyros",
    Cause.DVL_BAD: "the DVL is not believed, for whatever reason: that stands behind its name",
    Cause.ALTIMETER_BAD: "the altimeter is not believed, for whatever reason",
    Cause.BOTTOM_UNSEEN: "neither altimeter nor DVL sees the bottom",
    Cause.TERRAIN_LOST: "the depth is flown above the bottom, which nothing sees",
    Cause.PLANE_FAULT: "a stern plane is faulty",
    Cause.RUDDER_FAULT: "a rudder is faulty",
    Cause.PROPELLER_FAULT: "the propeller is faulty",
    Cause.ACTUATOR_SILENT: "a fin or the propeller reports nothing",
    Cause.ACTUATOR_WORN: "a fin or the propeller is slow or has play, and still of use",
    Cause.DAMAGED: "what is left of the fins is less than it takes to fly on",
    Cause.BATTERY_LOW: "the charge is below its limit",
    Cause.BATTERY_WARNING: "the charge comes near its limit",
    Cause.BATTERY_SILENT: "the battery is not heard",
    Cause.ENERGY: "the charge is what the way home needs",
    Cause.LEAK: "water in the hull",
    Cause.LEAK_SILENT: "the leak sensor is not heard",
    Cause.BUS_SILENT: "no device is heard",
    Cause.SURFACING_LONG: "it has tried to come up for long, and is not known to be up",
    Cause.SUNK: "it has sunk again after it had surfaced",
    Cause.LEFT_UNDER_WATER: "disarmed, and under water",
    Cause.NO_WAY_MADE: "it comes no nearer to its waypoint",
    Cause.LATE_CYCLES: "the computer is late",
    Cause.HARDPOINT_HOLDS: "the drop weight's hardpoint still holds it after the command",
    Cause.HARDPOINT_SILENT: "the drop weight is not confirmed gone: its hardpoint says nothing",
}
"""Rules that warned or changed the mode."""
GLOSSARY: Mapping[str, Mapping[str, str]] = {
    "Done: how it comes up": {f"stage {words(stage.name)}": text for stage, text in STAGES.items()}
    | {"weight": "the drop weight went"},
    "Done: rules that warned or ended the mission": {words(cause.name): text for cause, text in RULES.items()},
    "Named: of a sensor": {words(fault.name): text for fault, text in SENSORS.items()},
    "Named: of a fin or the propeller": {words(fault.name): text for fault, text in ACTUATORS.items()}
    | {"weight silent": "of the drop weight: its hardpoint reports nothing"},
}
"""Meanings by word, by title of their group."""
