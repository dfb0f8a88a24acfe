"""Actuator watch: fins and propeller, by what they report and by what the vehicle does, against what was commanded."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import (
    SOUND_FIN,
    ActuatorFault,
    ActuatorHealth,
    AxisDoubt,
    FinEvidence,
    FinHealth,
    SourceState,
    sound,
)
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.crossed_watch import CrossedWatch
from firmware_py.safety.actuators.drop_weight import DropWeightMemory, DropWeightWatch
from firmware_py.safety.actuators.feedback import PERIOD, FeedbackLimits, FeedbackMemory, FeedbackWatch
from firmware_py.safety.actuators.hull_memory import HullMemory
from firmware_py.safety.actuators.hull_watch import HullWatch
from firmware_py.safety.actuators.share_watch import ShareWatch
from firmware_py.safety.actuators.thrust import Ping, ThrustMemory, ThrustWatch
from firmware_py.tick import Tick
from firmware_py.vehicle.vehicle import Vehicle

__all__ = ["ActuatorParams", "ActuatorWatch", "ActuatorWatchMemory"]

_DEPTH_MIN = 2.5
"""Nearer to the surface, where it may be out of the water, m, the propeller is not judged."""
_PITCH_MAX = math.radians(30.0)
"""Nor is it in a steeper dive, which slows the vehicle."""
_STUCK = (ActuatorFault.JAMMED, ActuatorFault.HARD_OVER)
_CREPT = math.radians(0.25)
"""A stuck fin is elsewhere when it reports an angle that differs by so much."""
_UNSEEN = (ActuatorFault.NONE, ActuatorFault.SILENT)
"""What reports make of an actuator that works no longer, but does not show it."""


class ActuatorWatchMemory(NamedTuple):
    """What the watch remembers."""

    feedback: tuple[FeedbackMemory, ...]
    """Of the fins, then of the propeller."""
    hull: HullMemory
    thrust: ThrustMemory
    drop_weight: DropWeightMemory
    health: ActuatorHealth


class ActuatorWatch:
    """Names what is wrong with each fin and with the propeller, and says where the drop weight is."""

    def __init__(
        self, params: ActuatorParams, vehicle: Vehicle, n_rate: float, watch: type[ShareWatch] = ShareWatch
    ) -> None:
        """`n_rate` is the rate limit of the propeller's commands, rev/s^2; `watch` says what is left of an axis.

        Raises:
            ParamError: the vehicle has no inertia.
        """
        times = params.latency, params.timeout, params.time
        share, fins = params.rate_share, vehicle.fins
        limits = [
            FeedbackLimits(
                fin.rate_max, share * fin.rate_max, params.rate_needed, params.tolerance, fin.delta_max, *times
            )
            for fin in fins
        ]
        limits.append(FeedbackLimits(n_rate, share * n_rate, 0.0, params.n_tolerance, math.inf, *times, turns=True))
        self._params = params
        self._feedback = tuple([FeedbackWatch(limit) for limit in limits])
        self._hull = (CrossedWatch if vehicle.fins_crossed else HullWatch)(params, vehicle, watch)
        self._thrust = ThrustWatch(vehicle, params.evidence, params.current, params.eddies)
        self._rows = vehicle.deflection_rows
        weight = vehicle.drop_weight
        self._drop_weight = DropWeightWatch(params, weight.weight if weight is not None else math.nan)
        self._health = sound(len(fins))

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        state: StateEstimate,
        adopted: Adopted | None = None,
    ) -> ActuatorHealth:
        """Return the health of all actuators at this tick; `applied` and `adopted` are those of one tick ago."""
        t, feedback = tick.t, self._feedback
        turns = max(1, round(PERIOD / tick.dt))
        count = len(feedback)
        water, propeller = self._thrust.water(t), self._health.propeller
        changed = self._hull.update(tick, frame, applied, state, water, adopted, propeller)
        for i in range(tick.k % turns, count, turns):  # each in its own tick, so that all ticks cost the same
            heard, command = (frame.fins[i], applied.fins[i]) if i < count - 1 else (frame.n, applied.n)
            watch = feedback[i]
            before = watch.fault
            changed |= watch.update(t, heard, command, applied.armed) is not before
            if i < count - 1 and watch.fault in _STUCK and heard.usable(t, self._params.timeout):
                changed |= not abs(heard.value - self._health.left[i].stuck) < _CREPT
        if frame.dvl.fresh:
            changed |= self._judge_thrust(frame, applied, state, t)
        where = self._drop_weight.state
        changed |= self._drop_weight.update(t, frame.hardpoint, applied.drop) is not where
        if changed:
            self._health = self._judged(frame)
        return self._health

    @property
    def doubts(self) -> tuple[AxisDoubt, ...]:
        """Return what the motion says of planes and rudders."""
        return self._hull.doubts

    def freeze(self) -> ActuatorWatchMemory:
        """Return the whole memory."""
        feedback = tuple([watch.freeze() for watch in self._feedback])
        hull, thrust = self._hull.freeze(), self._thrust.freeze()
        return ActuatorWatchMemory(feedback, hull, thrust, self._drop_weight.memory, self._health)

    def thaw(self, memory: ActuatorWatchMemory) -> None:
        """Restore the memory that `freeze` returned."""
        for watch, remembered in zip(self._feedback, memory.feedback, strict=True):
            watch.thaw(remembered)
        self._hull.thaw(memory.hull)
        self._thrust.thaw(memory.thrust)
        self._drop_weight.memory = memory.drop_weight
        self._health = memory.health

    def _judge_thrust(self, frame: SensorFrame, applied: Applied, state: StateEstimate, t: float) -> bool:
        dvl, n, thrust, eta, nu = frame.dvl, frame.n, self._thrust, state.eta, state.nu
        if not (dvl.ok and state.velocity_ok and state.sensors.dvl.state is SourceState.GOOD and state.attitude_ok):
            return False
        reported = n.usable(t, self._params.timeout)
        turns = n.value if reported else applied.n
        judged = (
            applied.armed
            and state.depth_ok
            and eta.z > _DEPTH_MIN
            and abs(eta.theta) < _PITCH_MAX
            and (turns > 0.0 or (turns == 0.0 and not reported))
            and (reported or not applied.drop)  # without its weight it is driven by buoyancy too
        )
        rudder = planes = 0.0
        for i, (heard, told) in enumerate(zip(frame.fins, applied.fins, strict=True)):
            angle = heard.value if heard.usable(t, self._params.timeout) else told
            planes, rudder = planes + self._rows[0][i] * angle, rudder + self._rows[1][i] * angle
        u, v = dvl.value.u, dvl.value.v
        before = thrust.fault
        ping = Ping(dvl.t_valid, u, v, eta.psi, eta.theta, nu.q, nu.r, rudder, planes, turns, reported, judged)
        return thrust.update(ping) is not before

    def _judged(self, frame: SensorFrame) -> ActuatorHealth:
        """Return the health: what reports show comes first; what moves and has no effect is lost, or weak.

        Where a fin reports nothing, what its axis lacks is its own fault: one beside it that reports, and obeys, is
        not called faulty. But nobody knows what it does, so no more is left of it than of the axis.
        """
        *fins, propeller = [watch.fault for watch in self._feedback]
        if propeller in _UNSEEN and self._thrust.fault is not ActuatorFault.NONE:
            propeller = self._thrust.fault
        for i, (watch, fault) in enumerate(zip(self._feedback[:-1], fins, strict=True)):
            acts = self._hull.fault(i)
            if fault in _UNSEEN and self._hull.stuck(i) == self._hull.stuck(i):
                fins[i] = ActuatorFault.JAMMED
            elif fault in _UNSEEN and acts is not ActuatorFault.NONE and not (watch.reports and self._beside_silent(i)):
                stays = acts is ActuatorFault.LOST and not watch.reports
                fins[i] = ActuatorFault.JAMMED if stays else acts
        left = tuple([self._left(i, fault, frame) for i, fault in enumerate(fins)])
        return ActuatorHealth(tuple(fins), propeller, self._drop_weight.state, left)

    def _beside_silent(self, i: int) -> bool:
        """Return whether a fin that reports nothing acts on an axis of a fin."""
        rows = [row for row in self._rows if row[i]]
        return any(row[j] and not watch.reports for row in rows for j, watch in enumerate(self._feedback[:-1]))

    def _left(self, i: int, fault: ActuatorFault, frame: SensorFrame) -> FinHealth:
        """Return what is left of a fin."""
        if self._feedback[i].fault in _STUCK:
            heard = frame.fins[i]
            known = heard.value if heard.ok else self._health.left[i].stuck  # what is not vouched for is no angle
            return FinHealth(1.0, known, FinEvidence.FEEDBACK)
        if i in self._hull.resting:
            return FinHealth(self._hull.left(i), 0.0, FinEvidence.MOTION)
        stuck = self._hull.stuck(i)
        if stuck == stuck and fault is ActuatorFault.JAMMED:
            return FinHealth(1.0, stuck, FinEvidence.MOTION)
        unnamed = fault is ActuatorFault.NONE and self._hull.fault(i) is not ActuatorFault.NONE
        if unnamed or fault in (ActuatorFault.LOST, ActuatorFault.WEAK, ActuatorFault.JAMMED):
            return FinHealth(self._hull.left(i), source=FinEvidence.MOTION)
        return SOUND_FIN
