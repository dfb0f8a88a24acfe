"""Mode, reference, demand and commands: the outputs of a cycle, in their order."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from firmware_py.records.event import Cause
from firmware_py.records.fence import NOWHERE, WITHIN, Place
from firmware_py.records.order import Mode


class AscentStage(enum.IntEnum):
    """How the vehicle comes up in SURFACE."""

    NONE = 0
    """The mode is another."""
    POWERED = 1
    """The laws climb, at surface_speed."""
    BLIND = 2
    """Without attitude: stern planes by pitch from velocity and pressure, or at a fixed angle."""
    LEVEL = 3
    """Near the surface: with little pitch, so that the bow does not hang out of the water."""
    REVERSE = 4
    """It goes down or is far off: the healthy planes oppose, the propeller takes the way off."""
    STOPPED = 5
    """The propeller rests; what buoyancy there is brings the vehicle up."""
    WAITING = 6
    """Near the surface, as far as is known, but nothing tells of it: slowly on, and saying so."""
    FULL = 7
    """It sinks with its bow up, heavier than the water that it displaces: the laws climb, with full power."""


@dataclass(frozen=True, slots=True)
class ModeState:
    """What the supervisor decides: the mode, whether the mission is done, how many ticks of the last second were late.

    `ready` says that arming would be granted in this tick, or that it was; `cause` why the mode was entered, `failsafe`
    that a rule did so and nobody asked for it. `too_deep` and `breach` say what is wrong with the place: deeper than
    the limit, and beyond the fence as `Fence.breach_at` has it. `ascent` is the stage of SURFACE; `drop` that the drop
    weight shall be released; it stays so. `chosen` is the mode that arming leads to, unless another one is ordered.
    `pitch` is the desired pitch in SURFACE, rad.
    """

    mode: Mode
    mission_done: bool
    late: int
    ready: bool = False
    cause: Cause = Cause.NONE
    failsafe: bool = False
    too_deep: bool = False
    breach: int = WITHIN
    ascent: AscentStage = AscentStage.NONE
    drop: bool = False
    chosen: Mode = Mode.MANUAL
    pitch: float = 0.0


@dataclass(frozen=True, slots=True)
class Reference:
    """What the laws shall follow: depth, heading and speed with their derivatives (m, rad, s).

    `z_d` to `z_d_dddot` come from the depth reference model, `psi_d` to `psi_d_ddot` from the heading's; `waypoint` is
    the index of the leg being flown, `cross_track` the distance to starboard of it, m (NaN off a leg). In a learning
    manoeuvre `delta_s` and `delta_r` (rad) are fin angles to be added to the share `grip` of what the laws ask. `item`
    is the mission's item that is next or being flown, as many as there are once all are flown.

    `target` is the place that is flown to (NaN: none), `target_distance` (m) how far it is and `target_bearing` (rad)
    where. Without a place they are the distance to the circle that is flown, 0 off one, and the heading that is wanted.
    `rally` is the rally point that was chosen, or home (NaN: none). `above` is whether the depth is that of the bottom,
    less an altitude.
    """

    z_d: float
    z_d_dot: float
    z_d_ddot: float
    z_d_dddot: float
    psi_d: float
    psi_d_dot: float
    psi_d_ddot: float
    u_d: float
    waypoint: int
    cross_track: float
    delta_s: float = 0.0
    delta_r: float = 0.0
    grip: float = 1.0
    item: int = 0
    target: Place = NOWHERE
    target_distance: float = 0.0
    target_bearing: float = 0.0
    rally: Place = NOWHERE
    above: bool = False


@dataclass(frozen=True, slots=True)
class Demand:
    """What the laws ask: stern planes and rudder (rad), propeller (rev/s), and the sliding variables behind them."""

    delta_s: float
    delta_r: float
    n: float
    sigma_z: float
    sigma_psi: float


@dataclass(frozen=True, slots=True)
class FinCommand:
    """What the allocator makes of a demand: one angle (rad) per fin of the vehicle, and the propeller (rev/s)."""

    fins: tuple[float, ...]
    n: float


@dataclass(frozen=True, slots=True)
class Applied:
    """What the gate lets through to the actuators; `armed` False means centred fins and a stopped propeller."""

    fins: tuple[float, ...]
    n: float
    armed: bool
    limited: bool
    """True if the gate changed what it was given."""
    drop: bool = False
    """True from when the drop weight is released."""
