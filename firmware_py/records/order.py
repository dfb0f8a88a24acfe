"""What stations ask for: modes, setpoints, permanent changes. All of it enters the core as an `Order`."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from firmware_py.records.fence import Fence, Place
from firmware_py.records.mission import Mission

BESIDE = "beside"
"""In a field's metadata: a log keeps it in a topic of its own, so the record's encoding leaves it out."""
ANY_LENGTH = "any length"
"""In a field's metadata: a tuple that may be of another length in each record; it comes last."""


class Mode(enum.IntEnum):
    """What the vehicle is doing."""

    DISARMED = 0
    MANUAL = 1
    HOLD = 2
    """Depth, heading and speed are held."""
    MISSION = 3
    SURFACE = 4
    LOITER = 5
    """A circle that begins where the vehicle was: a fin vehicle cannot stand still."""
    GUIDED = 6
    """As a station says it, setpoint by setpoint: to a place and around it, or on a heading."""
    RETURN = 7
    """To the `nearest_rally_point`, home without one, at the present depth, then up."""


class Arming(enum.IntEnum):
    """A word on arming; most ticks say nothing."""

    KEEP = 0
    ARM = 1
    DISARM = 2
    CHECK = 3
    """Say what would become of arming, and do nothing."""
    FORCE_DISARM = 4
    """Under water too, where a vehicle that is disarmed stays."""


class Setpoint(NamedTuple):
    """Depth (m), heading (rad), speed (m/s) to hold, and a place (m, local NED) to go to; NaN leaves what is there."""

    z_d: float
    psi_d: float
    u_d: float
    x: float = math.nan
    y: float = math.nan


class Asker(NamedTuple):
    """Which station asked, by which link and MAVLink command (0: a message that is none); link -1 is no station."""

    link: int
    system: int
    component: int
    command: int


class Sticks(NamedTuple):
    """Manual control: stern plane and rudder angle (rad), propeller speed (rev/s)."""

    delta_s: float
    delta_r: float
    n: float


KEEP_SETPOINT = Setpoint(math.nan, math.nan, math.nan)
CENTRED_STICKS = Sticks(0.0, 0.0, 0.0)
NOBODY = Asker(-1, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Order:
    """What was asked in one tick. `mode` None asks for no change; `t_sticks` is when the sticks were last heard, s.

    `t_station` is when a ground station was last heard, s, -inf if none ever was. `terminate` asks to end the flight:
    to surface, and to release the drop weight; `release` asks for the latter alone. `chooses` says that a disarmed
    vehicle takes `mode` as the one that arming leads to, and does not refuse it. `jump` is the mission's item to fly
    next, -1 none; `asker` is who asked for mode, arming or setpoint. `changes` are what is changed for good, made in
    their order before anything else. A log keeps them in a topic of their own, for they have no fixed length.
    """

    arming: Arming = Arming.KEEP
    mode: Mode | None = None
    setpoint: Setpoint = KEEP_SETPOINT
    sticks: Sticks = CENTRED_STICKS
    t_sticks: float = -math.inf
    jump: int = -1
    asker: Asker = NOBODY
    t_station: float = -math.inf
    terminate: bool = False
    release: bool = False
    chooses: bool = True
    changes: tuple[Change, ...] = field(default=(), metadata={BESIDE: True})


NO_ORDER = Order()


@dataclass(frozen=True, slots=True)
class ParameterChange:
    """Other values of parameters: (dotted key, value) pairs, both as in autopilot.toml."""

    values: tuple[tuple[str, Any], ...]


@dataclass(frozen=True, slots=True)
class MissionChange:
    """Another mission, flown from its beginning."""

    mission: Mission


@dataclass(frozen=True, slots=True)
class FenceChange:
    """Another fence."""

    fence: Fence


@dataclass(frozen=True, slots=True)
class RallyChange:
    """Other rally points."""

    points: tuple[Place, ...]


Change = ParameterChange | MissionChange | FenceChange | RallyChange
"""What a station changes for good."""
