"""The fins by what the vehicle does: one `AxisWatch` each for pitch and yaw, and when they may judge."""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ActuatorFault, SourceState
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.hull_response import PERIOD, AxisMemory, AxisWatch
from firmware_py.safety.actuators.water_speed import WaterSpeed
from firmware_py.tick import Tick
from firmware_py.vehicle.turning import pitch_axis, yaw_axis
from firmware_py.vehicle.vehicle import Vehicle

_CRUISE = 1.8
"""Speed for which the eddies' moment is computed, m/s; it grows in proportion."""
_SERVO_TIME = 0.12
"""Lag of a servo that reports nothing, s."""
_DEPTH_MIN, _SPEED_MIN = 2.5, 0.8
"""Near the surface (m), where fins may be out of the water, and slower (m/s), the model does not hold."""
_PITCH_MAX = math.radians(45.0)
"""Nor does it in a steeper dive."""
_ROLL_MAX = math.radians(30.0)
"""Rolled over farther, planes steer and rudders dive."""
_ACROSS_STD = 0.3
"""Nor is yaw judged while the current across the hull is not known better than this, m/s."""
_SPEED_RATE = 0.2
"""What speed may be can change at once, when the propeller is in doubt; fins are held to one that changes slowly, by so
much, m/s^2: else a step of it would look like an effect that the fins do not have."""
_BRAKED = 0.7
"""Without DVL nothing tells how much the hull brakes in its turns: at full rudder it keeps this share of its speed."""
_STALE = 0.1
"""An older attitude, s, is none."""


class HullMemory(NamedTuple):
    """What is remembered.

    Attributes:
        axes: of both axes.
        sums: of their gyros, with the numbers of samples.
        speeds: to which their fins were held in the last step, m/s; NaN if it was left out.
        modelled: fin angles, rad.
    """

    axes: tuple[AxisMemory, ...]
    sums: tuple[tuple[float, int], ...]
    speeds: tuple[float, ...]
    modelled: tuple[float, ...]


class HullWatch:
    """Judges pitch (axis 0) and yaw (axis 1), each once a period, in turns."""

    def __init__(self, params: ActuatorParams, vehicle: Vehicle) -> None:
        """Take the models of the vehicle.

        Raises:
            ParamError: the vehicle has no inertia.
        """
        self._params = params
        self._models = pitch_axis(vehicle), yaw_axis(vehicle)
        self._advance = vehicle.propeller.u_trim / vehicle.propeller.n_trim
        self._travel = tuple([fin.delta_max for fin in vehicle.fins])
        shares = vehicle.effectiveness.s, vehicle.effectiveness.r
        self._effects = tuple(
            [tuple([model.control * share for share in row]) for model, row in zip(self._models, shares, strict=True)]
        )
        self._fins = tuple([[i for i, share in enumerate(row) if share] for row in shares])
        self._axes = tuple(
            [AxisWatch(params.evidence, model.eddies(_CRUISE, params.eddies), PERIOD) for model in self._models]
        )
        self._sums = [(0.0, 0), (0.0, 0)]
        self._speeds = [math.nan, math.nan]
        self._modelled = [0.0] * len(vehicle.fins)

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        state: StateEstimate,
        water: tuple[WaterSpeed, ...],
    ) -> bool:
        """Take what one tick tells; return whether the fault of an axis is another one now.

        `water` is what speed and current may be (`ThrustWatch.water`): fins are held to the least speed of them.
        """
        ahrs, sums = frame.ahrs, self._sums
        if ahrs.fresh and ahrs.ok:
            (q, i), (r, j) = sums
            sums[0], sums[1] = (q + ahrs.value.q, i + 1), (r + ahrs.value.r, j + 1)
        steps = max(1, round(PERIOD / tick.dt))
        phase = tick.k % steps
        axis = 0 if phase == 0 else 1
        if axis and phase != steps // 2:
            return False
        changed = self._judge(axis, tick, frame, applied, state, water)
        if steps == 1:
            changed |= self._judge(1, tick, frame, applied, state, water)
        return changed

    def fault(self, fin: int) -> ActuatorFault:
        """Return the worst that is wrong with an axis that a fin acts on: LOST, WEAK or NONE."""
        faults = [axis.fault for axis, fins in zip(self._axes, self._fins, strict=True) if fin in fins]
        return next((f for f in (ActuatorFault.LOST, ActuatorFault.WEAK) if f in faults), ActuatorFault.NONE)

    def freeze(self) -> HullMemory:
        """Return the whole memory."""
        axes = tuple([axis.freeze() for axis in self._axes])
        return HullMemory(axes, tuple(self._sums), tuple(self._speeds), tuple(self._modelled))

    def thaw(self, memory: HullMemory) -> None:
        """Restore the memory that `freeze` returned."""
        for axis, remembered in zip(self._axes, memory.axes, strict=True):
            axis.thaw(remembered)
        self._sums, self._speeds, self._modelled = list(memory.sums), list(memory.speeds), list(memory.modelled)

    def _judge(
        self,
        axis: int,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        state: StateEstimate,
        water: tuple[WaterSpeed, ...],
    ) -> bool:
        watch, model, t, nu = self._axes[axis], self._models[axis], tick.t, state.nu
        total, count = self._sums[axis]
        self._sums[axis] = (0.0, 0)
        angles, over = self._angles(axis, t, frame, applied)
        n = frame.n.value if frame.n.usable(t, self._params.timeout) else applied.n
        u = min([self._advance * n, *[x.least for x in water]]) if water else _BRAKED * min(self._advance * n, nu.u)
        before, self._speeds[axis] = self._speeds[axis], math.nan
        if before == before:
            u = min(max(u, before - _SPEED_RATE * PERIOD), before + _SPEED_RATE * PERIOD)
        cross = (nu.v if axis else nu.w) if state.velocity_ok else 0.0
        steady = True
        if axis and water:
            cross -= water[0].across(state.eta.psi)
            steady = water[0].across_std(state.eta.psi) < _ACROSS_STD
        if not (
            count
            and steady
            and applied.armed
            and u > _SPEED_MIN
            and state.depth_ok
            and state.eta.z > _DEPTH_MIN
            and -_PITCH_MAX < state.eta.theta < _PITCH_MAX
            and -_ROLL_MAX < state.eta.phi < _ROLL_MAX
            and state.attitude_ok
            and t - frame.ahrs.t_valid < _STALE
            and state.sensors.ahrs.state is SourceState.GOOD
        ):
            watch.pause()
            return False
        self._speeds[axis] = u
        was = watch.fault
        hull = u * cross * model.crosswise + model.restoring * math.sin(state.eta.theta)
        return watch.update(total / count, u * model.damping, hull, u * u * angles, over, u / _CRUISE) is not was

    def _angles(self, axis: int, t: float, frame: SensorFrame, applied: Applied) -> tuple[float, float]:
        """Return the fins' angles times their effect, and the least share of their travel."""
        effects, latency, modelled = self._effects[axis], self._params.latency, self._modelled
        total, over = 0.0, math.inf
        for i in self._fins[axis]:
            heard = frame.fins[i]
            angle = modelled[i] = modelled[i] + (applied.fins[i] - modelled[i]) * (PERIOD / _SERVO_TIME)
            if heard.ok and t - heard.t_valid <= latency:
                angle = heard.value
            total += effects[i] * angle
            over = min(over, abs(angle) / self._travel[i])
        return total, over
