"""The estimated state, and what was learned of vehicle and water."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

from firmware_py.marine import Eta, Nu
from firmware_py.records.event import Event
from firmware_py.records.health import ALL_GOOD, Candidate, SensorHealth
from firmware_py.records.order import BESIDE
from firmware_py.records.sensing import PayloadReading


@dataclass(frozen=True, slots=True)
class Learned:
    """What was learned of the vehicle and its water up to one tick; the lists are empty where nobody learns.

    `value`, `std` (1 sigma), `valid` and `excited` have an entry for each name of the configuration's
    estimation.coefficients.names, in its order: a nondimensional coefficient, or the scale of a group. `valid` says
    that a law may rely on the value, `excited` that the motion tells something about it. `current` is the water's
    velocity north and east, m/s, with `current_std`; `turbulence` the intensity of its eddies, m/s. `nis` is the
    running mean of the normalised innovations squared of DVL, gyros and attitude, per degree of freedom: 1 where the
    filter is consistent. `rejected` counts the measurements that the gate kept out, `dropped` those that the fixed-lag
    buffer did not take (too late, from the future, repeated, not finite or out of range), `resets` how often the filter
    began anew. `horizon` is the time that all this is true for, s. NaN means unknown. `report` says what was learned
    and what was not (`estimation.identifiability.report`), no older than a second; a log has it as the events that end
    a learning manoeuvre.
    """

    value: tuple[float, ...]
    std: tuple[float, ...]
    valid: tuple[bool, ...]
    excited: tuple[bool, ...]
    current: tuple[float, float]
    current_std: tuple[float, float]
    turbulence: float
    nis: tuple[float, float, float]
    rejected: int
    dropped: int
    resets: int
    horizon: float
    report: tuple[Event, ...] = field(default=(), metadata={BESIDE: True})


NOTHING_LEARNED = Learned(
    value=(),
    std=(),
    valid=(),
    excited=(),
    current=(math.nan, math.nan),
    current_std=(math.nan, math.nan),
    turbulence=math.nan,
    nis=(math.nan, math.nan, math.nan),
    rejected=0,
    dropped=0,
    resets=0,
    horizon=math.nan,
)
"""Of an estimator that does not learn."""


class VelocitySource(enum.IntEnum):
    """What the velocity over the ground rests on."""

    NONE = 0
    """Nothing: how fast the propeller turns, in water that stands still."""
    DVL = 1
    """Pings, the last one held."""
    FILTER = 2
    """The coefficient filter, which has the pings, as long as there are any, and the hull's model."""
    HULL_MODEL = 3
    """What propeller and rudder do to the hull by the vehicle file, and the current that was known last."""


@dataclass(frozen=True, slots=True)
class StateEstimate:
    """The estimators' answer for one tick.

    `eta` and `nu` as in SNAME (`nu` over the ground); `position_std` 1 sigma of (x, y) together, m; `depth_std`
    of z, m; `velocity_std` of u and v, m/s; `altitude` above the bottom, m, NaN when unknown. The `*_ok` flags say
    whether attitude, depth and velocity rest on measurements that are fresh enough to steer by, the velocity also on
    the coefficient filter where it goes on without DVL; `leak` that water was found; `sensors` which sensors are
    believed; `learned` what is known of vehicle and water beyond their files. `velocity_source` is what the velocity
    rests on, `water` the water's velocity north and east, eddies included, m/s, with 1 sigma `water_std` of each; NaN:
    not known. `current_ahead` is as much of the current along the hull, the last one that was known, as is sure, m/s; 0
    where none is. `fix_jump` is by how much fixes that contradicted the position put it right in this tick, m.
    `candidates` are the devices of every role that has more than one, the first in priority first. `payload` is that of
    the frame. `refused` is how many values of each sensor of `SensorHealth` were left out one by one so far.
    """

    eta: Eta
    nu: Nu
    position_std: float
    depth_std: float
    velocity_std: float
    altitude: float
    attitude_ok: bool
    depth_ok: bool
    velocity_ok: bool
    leak: bool
    sensors: SensorHealth = ALL_GOOD
    velocity_source: VelocitySource = VelocitySource.DVL
    water: tuple[float, float] = (math.nan, math.nan)
    water_std: float = math.nan
    current_ahead: float = 0.0
    fix_jump: float = 0.0
    candidates: tuple[Candidate, ...] = ()
    payload: tuple[PayloadReading, ...] = field(default=(), metadata={BESIDE: True})
    refused: tuple[int, ...] = field(default=(), metadata={BESIDE: True})
    learned: Learned = NOTHING_LEARNED

    @property
    def through_water(self) -> float:
        """Return the speed ahead through the water, m/s, by which fins act; over the ground where no water is known."""
        north, east = self.water
        if not math.isfinite(north + east):
            return self.nu.u
        _, _, _, _, theta, psi = self.eta
        return self.nu.u - (north * math.cos(psi) + east * math.sin(psi)) * math.cos(theta)

    @property
    def through_water_sure(self) -> float:
        """Return the speed ahead over the ground, m/s, less as much of the current as is sure."""
        return self.nu.u - self.current_ahead

    @property
    def z_dot(self) -> float:
        """Return the vertical velocity, m/s, down positive (Fossen 2011, third row of Eq. 2.18); NaN: unknown."""
        _, _, _, phi, theta, _ = self.eta
        if not math.isfinite(phi + theta):
            return math.nan
        u, v, w, _, _, _ = self.nu
        return -u * math.sin(theta) + math.cos(theta) * (v * math.sin(phi) + w * math.cos(phi))
