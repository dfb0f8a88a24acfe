"""Health of sensors and actuators: which of them can be believed, and if not, why."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple


class SourceState(enum.IntEnum):
    """How far a sensor is believed."""

    GOOD = 0
    SUSPECT = 1
    """Its values arrive, but are not used; it becomes good again when they agree with the others.

    Of two that are UNDECIDED the safer ones are used.
    """
    LOST = 2
    """It is silent, or reports itself that it does not work."""


class SourceFault(enum.IntEnum):
    """Why a sensor is not believed."""

    NONE = 0
    SILENT = 1
    UNHEALTHY = 2  # it says so itself: not a number, not valid, NodeStatus
    IMPOSSIBLE = 3  # no such value can be: under the air's pressure, above the vehicle's fastest speed
    FROZEN = 4  # exact repeats, or less noise than the sensor has
    STEP = 5
    DRIFT = 6
    OUTLIERS = 7  # more than now and then
    LATE = 8
    CONTRADICTED = 9  # by other sensors or the model of the vehicle
    TWO_SENDERS = 10  # under one node id
    HEADING = 11  # of the AHRS, steps or drifts against the gyros, which carry it on
    UNDECIDED = 12  # contradicts another sensor, and nothing tells which of the two is wrong: the safer reading holds
    OTHER_DEVICE = 13  # answers under its node id
    STEERING = 14  # of the AHRS: heading and gyro together turn otherwise than the rudder turns the vehicle
    CURRENT = 15  # of the DVL: the current that it tells of has changed as currents do not


HEADING_FAULTS = (SourceFault.HEADING, SourceFault.STEERING)
"""Of the AHRS: roll and pitch hold, and the heading may be off by more than usual."""


class SourceHealth(NamedTuple):
    """One sensor."""

    state: SourceState
    fault: SourceFault

    @property
    def believed(self) -> bool:
        """True if its values are used."""
        return self.state is SourceState.GOOD

    @property
    def tilt_doubted(self) -> bool:
        """True of an AHRS whose tilt, or the gyros that carry it on, may be wrong; outliers are left out singly.

        So it is with one that was lost, and is heard again not for long enough: it may be late, or another one.
        """
        others = (SourceFault.OUTLIERS, SourceFault.HEADING)
        return self.state is SourceState.LOST or (self.state is SourceState.SUSPECT and self.fault not in others)


class SensorHealth(NamedTuple):
    """Every sensor of `SensorFrame` that is no actuator."""

    ahrs: SourceHealth
    dvl: SourceHealth
    pressure: SourceHealth
    altitude: SourceHealth
    """The altimeter; the DVL measures altitude too."""
    fix: SourceHealth
    battery: SourceHealth
    leak: SourceHealth


class Role(enum.IntEnum):
    """What several devices may measure, in the order of `sensing.ROLES`."""

    AHRS = 0
    DVL = 1
    PRESSURE = 2
    ALTITUDE = 3
    FIX = 4


class Candidate(NamedTuple):
    """One of several devices of a role.

    Attributes:
        role: what it measures.
        number: its place in the order of priority, from 0.
        believed: whether the vehicle uses this one of them.
        health: state and fault, with it in use.
        left: why another one was believed in its place last; NONE: that one has priority, or it is believed.
    """

    role: Role
    number: int
    believed: bool
    health: SourceHealth
    left: SourceFault = SourceFault.NONE


class ActuatorFault(enum.IntEnum):
    """What is wrong with a fin or with the propeller."""

    NONE = 0
    SILENT = 1  # it reports nothing, or nothing that is believed; whether it moves is not known
    JAMMED = 2
    HARD_OVER = 3  # jammed at the end of its travel
    LOST = 4  # it moves, but makes no force
    WEAK = 5  # it makes less force than it should
    SLOW = 6
    LOOSE = 7  # it has play
    RUNAWAY = 8  # of the propeller, which turns faster than it is told
    LAGGING = 9  # of a fin that turns too slowly to steer with


class FinEvidence(enum.IntEnum):
    """What tells of a fin's damage."""

    NONE = 0
    FEEDBACK = 1
    """What it reports."""
    MOTION = 2
    """What the vehicle does."""


class FinHealth(NamedTuple):
    """What is left of one fin.

    Attributes:
        effect: share of its effect, in [0, 1]; of fins that act alike each counts as what they have together.
        stuck: angle at which it stays, rad; NaN: it moves, or nobody knows where it is.
        source: what tells so.
    """

    effect: float = 1.0
    stuck: float = math.nan
    source: FinEvidence = FinEvidence.NONE

    @property
    def is_stuck(self) -> bool:
        """Return whether it stays at a known angle."""
        return self.stuck == self.stuck


SOUND_FIN = FinHealth()


class AxisDoubt(NamedTuple):
    """What the motion says of the fins of one axis.

    Attributes:
        stays: for how long it has been likeliest that one of them stays somewhere, or known, s; 0: it is not.
        weak: whether they make less force than they should, or none.
        idle: numbers of the fins that rest for good: what they make, if anything, is not known.
    """

    stays: float = 0.0
    weak: bool = False
    idle: tuple[int, ...] = ()


NO_DOUBTS = (AxisDoubt(), AxisDoubt())
"""Of planes and rudders."""


class WeightState(enum.IntEnum):
    """Where the drop weight is, by what was commanded and what its hardpoint says."""

    UNREPORTED = 0
    """The hardpoint has never said anything, as a relay does not; or there is none. What is commanded counts."""
    HELD = 1
    SILENT = 2
    """The hardpoint says nothing any longer; the release is not commanded."""
    COMMANDED = 3
    """The release is commanded; the hardpoint is given the time to say so."""
    RELEASED = 4
    """The release was commanded, and the hardpoint says that it is done."""
    STUCK = 5
    """The release was commanded, and the hardpoint still says that it holds the weight."""
    NOT_CONFIRMED = 6
    """The release was commanded, and the hardpoint says nothing."""
    GONE = 7
    """The hardpoint says that it holds nothing, though no release was commanded."""


@dataclass(frozen=True, slots=True)
class ActuatorHealth:
    """Fins, in the order of the vehicle's fin list, the propeller, and the drop weight."""

    fins: tuple[ActuatorFault, ...]
    propeller: ActuatorFault
    drop_weight: WeightState = WeightState.UNREPORTED
    left: tuple[FinHealth, ...] = ()
    """Of each fin what is left of it; empty: nobody has said."""

    @property
    def faultless(self) -> bool:
        """True if nothing was found."""
        return not (self.propeller or any(self.fins) or self.drop_weight in WEIGHT_FAULTS)


WEIGHT_FAULTS = (WeightState.SILENT, WeightState.STUCK, WeightState.NOT_CONFIRMED, WeightState.GONE)
"""States of the drop weight in which something is wrong with it."""
GOOD = SourceHealth(SourceState.GOOD, SourceFault.NONE)
ALL_GOOD = SensorHealth(GOOD, GOOD, GOOD, GOOD, GOOD, GOOD, GOOD)


def sound(fins: int) -> ActuatorHealth:
    """Return the health of that many fins and a propeller in which nothing was found."""
    return ActuatorHealth((ActuatorFault.NONE,) * fins, ActuatorFault.NONE, left=(SOUND_FIN,) * fins)
