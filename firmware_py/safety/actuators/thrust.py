"""The propeller's thrust: does the vehicle gain speed as its propeller's speed says?

Along the hull, u_dot = k (u_n |u_n| - u |u|), where u_n is the speed that belongs to the propeller's. Over each window
the DVL tells u_dot; what is not drag is thrust. The cumulative sum of the log-likelihood ratio of "no thrust" against
"what is left at least" decides.

A propeller that reports nothing may also turn faster than it is told. Then the thrust is that of a speed far above the
commanded one, as a following current makes it seem too, for the DVL measures over the bottom. So the same sum decides
between a speed that is higher by the strongest current and one that is higher by half a metre per second more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.health import ActuatorFault
from firmware_py.vehicle.vehicle import Vehicle

_WINDOW = 2.0
"""s"""
_STD = 0.025
"""1 sigma of a gain of speed over a window that thrust and drag do not explain, m/s: DVL, eddies."""
_LEAST = 0.6
"""Share of the thrust that a sound propeller makes at least, also in a turn or a current."""
_EXCESS = 0.5
"""What a propeller that runs away adds to the strongest current, m/s; more is seen sooner."""
_CLIP = 2.0
"""No window counts for more, nats."""
_STRAIGHT = math.radians(4.0)
"""In faster turns the hull brakes, rad/s."""
_GAP = 1.0
"""Between two pings at most, s."""


class ThrustMemory(NamedTuple):
    """What is remembered.

    Attributes:
        fault: NONE, LOST or RUNAWAY.
        t_last: time of validity of the last ping, s.
        u_first: speed at the begin of the window, m/s.
        duration: of the window so far, s.
        drag: speed that drag took in it, m/s.
        thrust: speed that a sound propeller would have added, m/s.
        lost: evidence for LOST, nats.
        good: evidence that it is over.
        runaway: evidence for RUNAWAY, nats.
    """

    fault: ActuatorFault
    t_last: float
    u_first: float
    duration: float
    drag: float
    thrust: float
    lost: float
    good: float
    runaway: float = 0.0


_FRESH = ThrustMemory(ActuatorFault.NONE, -math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class ThrustWatch:
    """Judges the propeller by the vehicle's speed."""

    def __init__(self, vehicle: Vehicle, evidence: float, current: float = math.inf) -> None:
        """Make a watch.

        Args:
            vehicle: its hull and its propeller.
            evidence: the log-likelihood ratio, nats, at which a fault is named.
            current: how much faster than through the water a following current makes the vehicle at most, m/s.
        """
        hull, body, propeller = vehicle.hull, vehicle.body, vehicle.propeller
        inertia = body.mass - 0.5 * hull.density * hull.length**3 * vehicle.coefficients.X_udot
        self._k = 0.5 * hull.density * hull.length**2 * propeller.C_d0 / inertia
        self._advance = propeller.u_trim / propeller.n_trim
        self._evidence = evidence
        self._current = current
        self._memory = _FRESH

    @property
    def fault(self) -> ActuatorFault:
        """NONE, LOST or RUNAWAY."""
        return self._memory.fault

    def update(
        self, t: float, u: float, n: float, turning: float, judged: bool, reported: bool = True
    ) -> ActuatorFault:
        """Return the propeller's fault after a ping of the DVL.

        Args:
            t: its time of validity, s.
            u: speed over the bottom ahead, m/s.
            n: speed of the propeller, rev/s: as reported, else as commanded.
            turning: rate of turn, rad/s.
            judged: False where the model does not hold.
            reported: whether `n` is; if not, it may turn faster.
        """
        m, dt = self._memory, t - self._memory.t_last
        if not judged or turning > _STRAIGHT or not 0.0 < dt <= _GAP:
            self._memory = m._replace(t_last=t, u_first=u, duration=0.0, drag=0.0, thrust=0.0)
            return m.fault
        u_n = self._advance * n
        drag, thrust = m.drag + self._k * dt * u * abs(u), m.thrust + self._k * dt * u_n * abs(u_n)
        if m.duration + dt < _WINDOW:
            self._memory = m._replace(t_last=t, duration=m.duration + dt, drag=drag, thrust=thrust)
            return m.fault
        made, duration = u - m.u_first + drag, m.duration + dt
        ratio = _LEAST * thrust * (0.5 * _LEAST * thrust - made) / (_STD * _STD)
        ratio = min(max(ratio, -_CLIP), _CLIP)
        faster = -_CLIP if reported else self._ratio_of_runaway(made, thrust, duration)
        fault, lost, runaway = m.fault, max(0.0, m.lost + ratio), max(0.0, m.runaway + faster)
        good = max(0.0, m.good - (faster if fault is ActuatorFault.RUNAWAY else ratio))
        if fault is ActuatorFault.NONE and max(lost, runaway) > self._evidence:
            fault, good = ActuatorFault.LOST if lost > runaway else ActuatorFault.RUNAWAY, 0.0
        elif fault is not ActuatorFault.NONE and good > self._evidence:
            fault, lost, runaway = ActuatorFault.NONE, 0.0, 0.0
        lost, good, runaway = (min(sum_, self._evidence) for sum_ in (lost, good, runaway))
        self._memory = ThrustMemory(fault, t, u, 0.0, 0.0, 0.0, lost, good, runaway)
        return fault

    def _ratio_of_runaway(self, made: float, thrust: float, duration: float) -> float:
        """Return the log-likelihood ratio of a propeller that runs away to one in a following current, nats."""
        if self._current == math.inf:
            return -_CLIP
        k = self._k * duration
        u = math.sqrt(max(thrust, 0.0) / k) + self._current
        sound, fast = k * u * u, k * (u + _EXCESS) ** 2
        ratio = (fast - sound) * (made - 0.5 * (fast + sound)) / (_STD * _STD)
        return min(max(ratio, -_CLIP), _CLIP)

    def freeze(self) -> ThrustMemory:
        """Return the whole memory."""
        return self._memory

    def thaw(self, memory: ThrustMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._memory = memory
