"""What people ask for: modes, orders, missions. What a ground station may change enters the core as an `Order`."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple


class Mode(enum.IntEnum):
    """What the vehicle is doing."""

    DISARMED = 0
    MANUAL = 1
    HOLD = 2
    """Depth, heading and speed are held."""
    MISSION = 3
    SURFACE = 4


class Arming(enum.IntEnum):
    """A word on arming; most ticks say nothing."""

    KEEP = 0
    ARM = 1
    DISARM = 2


class Setpoint(NamedTuple):
    """Depth (m), heading (rad) and speed (m/s) to hold; NaN leaves what is there."""

    z_d: float
    psi_d: float
    u_d: float


class Sticks(NamedTuple):
    """Manual control: stern plane and rudder angle (rad), propeller speed (rev/s)."""

    delta_s: float
    delta_r: float
    n: float


KEEP_SETPOINT = Setpoint(math.nan, math.nan, math.nan)
CENTRED_STICKS = Sticks(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Order:
    """What was asked in one tick. `mode` None asks for no change; `t_sticks` is when the sticks were last heard, s."""

    arming: Arming = Arming.KEEP
    mode: Mode | None = None
    setpoint: Setpoint = KEEP_SETPOINT
    sticks: Sticks = CENTRED_STICKS
    t_sticks: float = -math.inf


NO_ORDER = Order()


class Waypoint(NamedTuple):
    """A place to pass: x, y (m, local NED), depth z (m, or altitude), speed u (m/s)."""

    x: float
    y: float
    z: float
    u: float


@dataclass(frozen=True, slots=True)
class Mission:
    """Waypoints in order; at the end the vehicle surfaces."""

    waypoints: tuple[Waypoint, ...] = ()
