"""Heading and DVL u against the hull's model: what drifts with its own gyro, and what creeps farther than a current.

**Heading.** A yaw that drifts together with its gyro shows in how the hull answers the rudder. The measured rate of
turn is regressed on that of the model, over 100 s: the slope is the gain that the rudder really has, the intercept is
what the gyro says beyond the rudder. As far as the slope is not known, for the rudder rests, the intercept is not.
Where heading and gyro contradict each other, the one is believed that has turned as the rudder since.
The model's speed is that through the water: it begins at rest, or where the coefficient filter is when it is first
believed; else with the DVL's, over the ground, and is asked nothing until drag has made it forget that.

The model is that of the vehicle in force: coefficients that are adopted, and those of vehicle.toml for the others.
Where its steady turn changes by a tenth the regression begins anew. Two doubts widen what the rudder may explain. Where
the gain has not shown, it is as unsure as the steady turn by the coefficients' own sigmas (`steady_turn`); of a hull
that may not hold its course by itself nothing is said. And what the model leaves unexplained in turns it may be off by
in the mean: a spread s, correlated for 5 s, leaves s sqrt(5 s / T (2 - w) / w) to a mean over T with so much, w, of its
weight.

**DVL.** What u and v differ by from the model is the current, north and east, averaged over ten minutes. What u leaves
that by is a current that changes, or a DVL that creeps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from firmware_py.estimation.integrity.integrity_params import IntegrityParams
from firmware_py.estimation.integrity.motion_model import MotionMemory, MotionModel
from firmware_py.estimation.integrity.steady_turn import steady_turn_std
from firmware_py.estimation.navigation.velocity import Current, FilterVelocity, HullVelocity
from firmware_py.records.sensing import Dvl
from firmware_py.vehicle.linear_models import SteeringCoefficients, steering_coefficients
from firmware_py.vehicle.turning import steady_turn, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

_TIME = 100.0
"""Time constant of the regression, s."""
_PART = 0.3
"""It tells when so much of its weight is there: after 36 s."""
_ACTIVITY = math.radians(0.3) ** 2
"""Variance of the model's rate of turn, rad^2/s^2, at which half of the gain is known."""
_GAIN_STD = 0.06
"""What the gain is off by where it is known: eddies, cross-flow."""
_SIGMAS = 2.0
"""So many sigmas may the steady turn be off by, as far as it has not shown."""
_UNEXPLAINED = 4.0
"""So many sigmas of its mean is what the model leaves unexplained in turns no drift."""
_CORRELATED, _SLOW = 5.0, 10.0
"""It is correlated for so long, s; what is slower than the other is no turn, and may be the heading's own."""
_KNOWN = 0.2
"""A steady turn of which the logarithm has this 1 sigma is known."""
_FAR = 0.1
"""A steady turn that differs by more than this share is that of another vehicle."""
_SETTLES, _FORGETS = 15.0, 60.0
"""So long after it began to drive the model has forgotten its sway and its turn, s; and so long after, at full speed, a
speed that was not known: two time constants of its drag."""
_ADRIFT = 0.05
"""Slower than this, m/s, it drifts with the water."""
_STD, _FIRST_STD, _FIRST_TIME = 0.05, 0.3, 5.0
"""1 sigma of the averaged current, m/s: in the end, and in the beginning, when it falls with the root of time (s)."""
_CURRENT_TIME = 600.0
_SLIP_TIME = 20.0
_AFLOAT = 0.45
"""What u and v are off by, m/s, with the bow out of the water or in a turn at the surface, and soon after."""
_LEARNS = 60.0
"""For so long the current is only averaged, s."""


@dataclass(slots=True)
class ModelCheckMemory:
    """The model's motion; what was heard since its last step; regression; current (m/s), and what u leaves it by.

    `unknown` is for how long, s, the model's speed is still not to be relied on; `dived` since when it is judged by, s;
    `steering` are the coefficients that the model turns by, `turns` their steady turn, 1/m, to a tenth, `followed` for
    how long it has been that, s, and `unsure` 1 sigma of its logarithm; `driven` and `pinged` are for how long
    propeller and DVL have told of the motion; `weight` and what follows are running means of 1, r, the model's r, its
    square and their product. `slow` is what the model leaves unexplained, rad/s, over 10 s, and `spread` the mean
    square of what is faster. `gyro`, `rudder` and `way` are how far, rad, gyro, model, and the model to and fro, have
    turned since the heading contradicts its gyro.
    """

    motion: MotionMemory
    steering: tuple[float, ...]
    turns: float
    unknown: float = math.inf
    followed: float = math.inf
    unsure: float = 0.0
    driven: float = 0.0
    dived: float = 0.0
    turned: float = 0.0
    reports: int = 0
    weight: float = 0.0
    r: float = 0.0
    model: float = 0.0
    square: float = 0.0
    product: float = 0.0
    slow: float = 0.0
    spread: float = 0.0
    gyro: float = 0.0
    rudder: float = 0.0
    way: float = 0.0
    pinged: float = 0.0
    t_ping: float = -math.inf
    north: float = 0.0
    east: float = 0.0
    slip: float = 0.0


class ModelCheck:
    """Follows the model beside the sensors."""

    def __init__(self, params: IntegrityParams, vehicle: Vehicle) -> None:
        self._params, self._vehicle = params, vehicle
        self._motion = MotionModel(vehicle)
        steering = steering_coefficients(vehicle)
        self.memory = ModelCheckMemory(self._motion.memory, steering, abs(steady_turn(yaw_axis(vehicle, steering))))

    def doubt(self, std: Sequence[float]) -> None:
        """Take note that the coefficients in use are known to 1 sigma `std`; vehicle.toml is taken at its word else."""
        self.memory.unsure = steady_turn_std(self._vehicle, SteeringCoefficients(*self.memory.steering), std)

    def follow(self, steering: SteeringCoefficients, std: Sequence[float]) -> None:
        """Judge by these coefficients, known to 1 sigma `std`, from now on, unless those of before are known better."""
        m, unsure = self.memory, steady_turn_std(self._vehicle, steering, std)
        if unsure > max(m.unsure, _KNOWN):
            return
        turns, m.steering = abs(steady_turn(yaw_axis(self._vehicle, steering))), tuple(steering)
        self._motion.follow(steering)
        if unsure < 0.5 * m.unsure or not abs(turns - m.turns) <= _FAR * m.turns:
            m.turns, m.followed = turns, 0.0
            m.weight = m.r = m.model = m.square = m.product = m.slow = m.spread = 0.0
        m.unsure = unsure

    def hear_rate(self, r: float) -> None:
        """Take a rate of turn, rad/s."""
        self.memory.turned += r
        self.memory.reports += 1

    def hear_ping(self, ping: Dvl, t: float, psi: float, believed: bool) -> None:
        """Take the velocities of a ping at t, s, under the heading psi, rad.

        A DVL that is not `believed` makes no current: its fault would be one, and the vehicle would fly by it.
        """
        m, motion = self.memory, self._motion.memory
        gap, m.t_ping = t - m.t_ping, t
        if m.unknown == math.inf:
            motion.u, m.unknown = ping.u, _FORGETS
        if not (self._settled and m.dived) or gap > 1.0:
            return
        s, c = math.sin(psi), math.cos(psi)
        ahead, aside = ping.u - motion.u, ping.v - motion.v
        if believed:
            m.pinged += gap
        if believed and not self.dvl_creeps:
            share = gap / min(m.pinged, _CURRENT_TIME)
            m.north += share * (ahead * c - aside * s - m.north)
            m.east += share * (ahead * s + aside * c - m.east)
        if m.pinged > _LEARNS:
            m.slip += gap / _SLIP_TIME * (ahead - m.north * c - m.east * s - m.slip)

    @property
    def _settled(self) -> bool:
        return self.memory.driven >= _SETTLES and self.memory.unknown <= 0.0

    @property
    def speed(self) -> float:
        """Return the speed ahead through the water that thrust and drag make, m/s."""
        return self._motion.memory.u

    def hear_speed(self, known: FilterVelocity, psi: float, theta: float) -> None:
        """Take what the filter knows of the speed through the water under these angles, rad, if the model does not."""
        m = self.memory
        if m.unknown > 0.0:
            s, c = math.sin(psi), math.cos(psi)
            north, east = known.current.north + known.eddy[0], known.current.east + known.eddy[1]
            m.motion.u = known.u - (north * c + east * s) * math.cos(theta)
            m.motion.v, m.unknown = known.v - east * c + north * s, 0.0

    def rest(self) -> None:
        """Take note that the vehicle drifts with the water, but for way that it is known to have: drag takes that."""
        m = self.memory
        if m.unknown <= 0.0 and abs(m.motion.u) > _ADRIFT:
            return
        m.motion.u, m.motion.v, m.motion.r, m.unknown = 0.0, 0.0, 0.0, 0.0
        m.motion.braked = m.motion.unweighed = m.motion.brakes = 0.0

    def step(
        self, dt: float, n: float, theta: float, fins: list[float], steered: bool, driven: bool, deep: bool
    ) -> None:
        """Go on by dt, s, at the propeller speed n, rev/s, pitch and fin angles, rad.

        `steered`: the rudder is known and turns the hull; `driven`: thrust and drag make its speed, but for a glide of
        less than `current_change`; else the model moves straight on. Only `deep` under water anything is judged by it.
        """
        m, motion = self.memory, self._motion
        rate, heard = (m.turned / m.reports, steered) if m.reports else (0.0, False)
        m.turned, m.reports, m.dived = 0.0, 0, m.dived + dt if deep else 0.0
        if m.unknown == math.inf:
            motion.memory.u, m.unknown = motion.speed(n), _FORGETS
        if not driven:
            motion.memory.v, motion.memory.r, m.driven, m.slip = 0.0, 0.0, 0.0, 0.0
            motion.step(dt, n, theta, 0.0, 0.0)
            return
        m.driven += dt
        m.followed += dt
        m.unknown -= dt * motion.memory.u / motion.trim
        motion.step(dt, n, theta, *motion.deflections(fins))
        if not (self._settled and heard and deep):
            return
        share, modelled = dt / _TIME, motion.memory.r
        m.gyro += dt * rate
        m.rudder += dt * modelled
        m.way += dt * abs(modelled)
        if m.followed < _SETTLES:
            return
        m.weight += share * (1.0 - m.weight)
        m.r += share * (rate - m.r)
        m.model += share * (modelled - m.model)
        m.square += share * (modelled * modelled - m.square)
        m.product += share * (modelled * rate - m.product)
        unexplained = rate - self._regression()[2] * modelled
        m.slow += dt / _SLOW * (unexplained - m.slow)
        m.spread += share * ((unexplained - m.slow) ** 2 - m.spread)

    @property
    def velocity(self) -> HullVelocity | None:
        """Return the model's velocity through the water, and the current by pings; None: the model does not hold."""
        m = self.memory
        if m.driven <= 0.0 or m.unknown > 0.5 * _FORGETS:
            return None
        std = math.inf if m.pinged <= 0.0 else math.hypot(_STD, _FIRST_STD / math.sqrt(1.0 + m.pinged / _FIRST_TIME))
        v = m.motion.v if m.dived else 0.0  # at the surface rudders do half of what they should
        off = _AFLOAT if m.dived < _SETTLES else 0.0
        high = m.motion.unweighed + off
        current = Current(m.north, m.east, std, m.t_ping)
        return HullVelocity(m.motion.u, v, current, 0.0, m.motion.braked + m.motion.unweighed, high, off)

    def _regression(self) -> tuple[float, float, float, float]:
        """Return the means of the measured rate and of the model's, rad/s, the gain, and what that is off by."""
        m, weight = self.memory, self.memory.weight
        mean, model = m.r / weight, m.model / weight
        variance = m.square / weight - model * model + _ACTIVITY
        gain = (m.product / weight - mean * model + _ACTIVITY) / variance
        return mean, model, gain, _ACTIVITY / variance + _GAIN_STD

    @property
    def turning(self) -> float:
        """Return how fast the heading surely turns beyond what the rudder does, rad/s, to either side."""
        if self.memory.weight < _PART or self.memory.unsure == math.inf:
            return 0.0
        mean, model, gain, off = self._regression()
        ratio = math.exp(_SIGMAS * self.memory.unsure * (off - _GAIN_STD))
        least, most = sorted((gain / ratio, gain * ratio))
        low, high = sorted(((least - off) * model, (most + off) * model))
        return max(low - mean, mean - high)

    @property
    def _mean_std(self) -> float:
        """Return 1 sigma of the mean of what the model leaves unexplained, rad/s; needs a regression."""
        weight, spread = self.memory.weight, self.memory.spread
        return math.sqrt(spread / weight * _CORRELATED / _TIME * (2.0 - weight) / weight)

    def part(self) -> None:
        """Take note that from now on the heading contradicts its gyro."""
        m = self.memory
        m.gyro = m.rudder = m.way = 0.0

    def refutes_gyro(self, off: float) -> bool:
        """Return whether the heading has turned as the rudder turns the hull, and not the gyro.

        `off` is how far, rad, the heading has left the gyro since `part`.
        """
        m = self.memory
        if m.weight <= 0.0:
            return False
        _, _, gain, unsure = self._regression()
        beyond, slack = m.gyro - gain * m.rudder, unsure * m.way
        return abs(beyond) - slack > abs(beyond + off) + slack + self._params.heading

    @property
    def heading_drifts(self) -> bool:
        """Return whether heading and gyro turn otherwise than the rudder turns the hull."""
        turning = self.turning
        return turning > self._params.turn_drift and turning > _UNEXPLAINED * self._mean_std

    @property
    def dvl_creeps(self) -> bool:
        """Return whether no current explains what u is off by; between 0 and the model thrust may be lost."""
        slip, limit = self.memory.slip, self._params.current_change
        return slip > limit or slip < -max(limit, self._motion.memory.u)

    def freeze(self) -> ModelCheckMemory:
        """Return the whole memory."""
        return replace(self.memory, motion=self._motion.freeze())

    def thaw(self, memory: ModelCheckMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._motion.thaw(memory.motion)
        self._motion.follow(SteeringCoefficients(*memory.steering))
        self.memory = replace(memory, motion=self._motion.memory)
