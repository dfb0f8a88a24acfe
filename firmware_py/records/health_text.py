"""The words for what is wrong with sensors and actuators, and for the stages of coming up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from firmware_py.records.command import AscentStage
from firmware_py.records.health import ActuatorFault, SourceFault
from firmware_py.records.sensing import BUSES

_SOURCE_FAULTS: Mapping[SourceFault, str] = {
    SourceFault.NONE: "no fault",
    SourceFault.SILENT: "silent",
    SourceFault.UNHEALTHY: "it reports that it does not work",
    SourceFault.IMPOSSIBLE: "impossible values",
    SourceFault.FROZEN: "frozen",
    SourceFault.STEP: "a step that nothing else shows",
    SourceFault.DRIFT: "it drifts from the other sensors",
    SourceFault.OUTLIERS: "too many outliers",
    SourceFault.LATE: "its values come too late",
    SourceFault.CONTRADICTED: "contradicted by the other sensors",
    SourceFault.TWO_SENDERS: "two senders under one node id",
    SourceFault.OTHER_DEVICE: "another device answers under its node id",
    SourceFault.HEADING: "its heading leaves the gyros, which carry it on",
    SourceFault.STEERING: "its heading turns otherwise than the rudder turns the vehicle",
    SourceFault.CURRENT: "by the speed through the water, the current that it tells of has changed as no current does",
    SourceFault.UNDECIDED: "it or another sensor is wrong; the safer reading holds",
}
_ACTUATOR_FAULTS: Mapping[ActuatorFault, str] = {
    ActuatorFault.NONE: "no fault",
    ActuatorFault.SILENT: "reports nothing valid",
    ActuatorFault.JAMMED: "jammed",
    ActuatorFault.HARD_OVER: "jammed at the end of its travel",
    ActuatorFault.LOST: "makes no force",
    ActuatorFault.WEAK: "makes less force than it should",
    ActuatorFault.SLOW: "too slow",
    ActuatorFault.LAGGING: "too slow to steer with",
    ActuatorFault.LOOSE: "has play",
    ActuatorFault.RUNAWAY: "runs away: it drives faster than it is told",
}
_STAGES: Mapping[AscentStage, str] = {
    AscentStage.NONE: "ended",
    AscentStage.POWERED: "under power",
    AscentStage.BLIND: "without attitude",
    AscentStage.LEVEL: "level, near the surface",
    AscentStage.REVERSE: "propeller astern",
    AscentStage.STOPPED: "propeller stopped",
    AscentStage.WAITING: "slowly, until something tells of the surface",
    AscentStage.FULL: "under full power",
}
_ORDINALS = ("first", "second", "third", "fourth")


def source_fault_text(number: float) -> str:
    """Return the words for the `SourceFault` of that number."""
    return _SOURCE_FAULTS[SourceFault(int(number))]


def sensor_text(name: str) -> str:
    """Return what people call the sensor of a role, such as "altitude", or one of several, such as "altitude.2"."""
    role, dot, number = name.partition(".")
    return f"{'altimeter' if role == 'altitude' else role}{dot}{number}"


def actuator_fault_text(number: float) -> str:
    """Return the words for the `ActuatorFault` of that number."""
    return _ACTUATOR_FAULTS[ActuatorFault(int(number))]


def choice_text(now: float, before: float, fault: float) -> str:
    """Return the words for a device that is believed in place of another, by their numbers from 1, and for why."""
    this, that = (_ORDINALS[int(number) - 1] for number in (now, before))
    why = f"the {that}: {source_fault_text(fault)}" if fault else f"it is sound, and comes before the {that}"
    return f"the {this} is believed; {why}"


def stage_text(number: float) -> str:
    """Return the words for the `AscentStage` of that number."""
    return _STAGES[AscentStage(int(number))]


def node_text(names: Sequence[str], number: float) -> str:
    """Return what is wrong with a node, by its roles, or with a bus; or that it is sound again.

    Args:
        names: those of its roles, of `sensing.NODES` or of fins; that of a bus.
        number: of the `SourceFault`.
    """
    of_a_bus = names[0] in BUSES
    named = names[0].replace("_", " ") if of_a_bus else f"node {', '.join(names)}"
    if number == SourceFault.NONE:
        return f"{named} is sound again"
    return f"{named}: {'it is down, off or error-passive' if of_a_bus else source_fault_text(number)}"
