"""The fins by what the vehicle does: one `AxisWatch` each for pitch and yaw, and when they may judge."""

from __future__ import annotations

import math
from dataclasses import replace

from firmware_py.marine import clip
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import Applied
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.health import ActuatorFault, AxisDoubt, SourceFault, SourceState
from firmware_py.records.sensing import SensorFrame
from firmware_py.safety.actuators.actuator_params import ActuatorParams
from firmware_py.safety.actuators.attitude_witness import AttitudeWitness
from firmware_py.safety.actuators.cross_flow import CrossFlow
from firmware_py.safety.actuators.fin_angles import FinAngles
from firmware_py.safety.actuators.fin_effect import FinEffect, Seen
from firmware_py.safety.actuators.hull_memory import HullMemory, Values
from firmware_py.safety.actuators.hull_reference import CRUISE, HullReference
from firmware_py.safety.actuators.hull_response import PERIOD, AxisWatch
from firmware_py.safety.actuators.share_watch import LEFT, ShareWatch
from firmware_py.safety.actuators.single_fin import Step
from firmware_py.safety.actuators.stuck_watch import StuckWatch
from firmware_py.safety.actuators.water_motion import current_across, least_speed
from firmware_py.safety.actuators.water_speed import WaterSpeed
from firmware_py.tick import Tick
from firmware_py.vehicle.linear_models import diving_coefficients, steering_coefficients
from firmware_py.vehicle.turning import damped_share, heaved_axis
from firmware_py.vehicle.vehicle import Vehicle

_DEPTH_MIN, _SPEED_MIN = 2.5, 0.8
"""Near the surface (m), where fins may be out of the water, and slower (m/s), the model does not hold."""
_BRAKES = 0.6
"""A propeller that turns for less than this share of the speed is slowed, stopped or turned round: its race, which fins
and hull feel, changes faster than the model says."""
NOTHING = 0.201
"""Fins that do no more than this share of what vehicle.toml says make no force; adoption holds values at 0.2."""
_HELD_STD = 0.1
"""1 sigma of what fins do by coefficients that held in flight."""
_FAR = 0.1
"""Where what fins do, the last coefficient, differs by more than this share, it is another vehicle."""


class HullWatch:
    """Judges pitch (axis 0) and yaw (axis 1), each once a period, in turns."""

    def __init__(self, params: ActuatorParams, vehicle: Vehicle, watch: type[ShareWatch] = ShareWatch) -> None:
        """Take the models of the vehicle; `watch` says what is left of each axis.

        Raises:
            ParamError: the vehicle has no inertia.
        """
        self._params, self._reference = params, HullReference(vehicle, params.eddies)
        self._files = diving_coefficients(vehicle), steering_coefficients(vehicle)
        self._advance = vehicle.propeller.u_trim / vehicle.propeller.n_trim
        self._travel = tuple([fin.delta_max for fin in vehicle.fins])
        shares = vehicle.effectiveness.s, vehicle.effectiveness.r
        self._fins = tuple([[i for i, share in enumerate(row) if share] for row in shares])
        self._effects = [FinEffect(row, self._travel) for row in shares]
        eddies = self._reference.eddies
        self._axes = tuple([AxisWatch(params.evidence, one, PERIOD) for one in eddies])
        self._left = [watch(params.evidence, one, PERIOD) for one in eddies]
        self._stuck = [StuckWatch(params.evidence, one, PERIOD) for one in eddies]
        self._heaved, self._flow, self._attitude = heaved_axis(vehicle), CrossFlow(PERIOD), AttitudeWitness()
        self._sums, self._speeds = [(0.0, 0), (0.0, 0)], [math.nan, math.nan]
        self._explained = False  # by a single fin, what an axis seems to lack
        self.resting: tuple[int, ...] = ()  # fins that stay at 0, for they are lost, or may be
        self._angles = [FinAngles(params, len(vehicle.fins)) for _ in eddies]  # fins of an X tail act on both axes

    def update(
        self,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        state: StateEstimate,
        water: tuple[WaterSpeed, ...],
        adopted: Adopted | None = None,
        propeller: ActuatorFault = ActuatorFault.NONE,
    ) -> bool:
        """Take what one tick tells; return whether the fault of an axis is another one now.

        `water` is what speed and current may be (`ThrustWatch.water`): fins are held to the least speed of them.
        `adopted` says what held so far, by which they are judged; None: vehicle.toml does. What was learned speaks of
        fins only if sensors taught it that are believed, behind a `propeller` with nothing wrong.
        """
        ahrs, sums = frame.ahrs, self._sums
        if ahrs.fresh and ahrs.ok:
            (q, i), (r, j) = sums
            sums[0], sums[1] = (q + ahrs.value.q, i + 1), (r + ahrs.value.r, j + 1)
        if frame.dvl.fresh and frame.dvl.ok and water:
            self._flow.hear(frame.dvl, water[0].across(state.eta.psi))
        self._attitude.hear(tick.t, state, applied.armed)
        steps = max(1, round(PERIOD / tick.dt))
        axis = int(tick.k % steps != 0)
        if axis and tick.k % steps != steps // 2:
            return False
        speaks = self._attitude.speaks(tick.t, frame, state)
        believed = speaks and state.sensors.dvl.state is not SourceState.SUSPECT
        if adopted and any(adopted.halved) and not (believed and propeller is ActuatorFault.NONE):
            adopted = replace(adopted, halved=(False, False))
        changed = self._judge(axis, tick, frame, applied, state, water, adopted, speaks)
        if steps == 1:
            changed |= self._judge(1, tick, frame, applied, state, water, adopted, speaks)
        return changed

    def fault(self, fin: int) -> ActuatorFault:
        """Return the worst that is wrong with an axis that a fin acts on: LOST, WEAK or NONE."""
        faults = [self._fault(axis) for axis, fins in enumerate(self._fins) if fin in fins]
        return next((f for f in (ActuatorFault.LOST, ActuatorFault.WEAK) if f in faults), ActuatorFault.NONE)

    def left(self, fin: int) -> float:
        """Return the share of its effect that a fin has left, as the worst axis that it acts on shows."""
        return min([LEFT[self._fault(axis)] for axis, fins in enumerate(self._fins) if fin in fins], default=1.0)

    def stuck(self, fin: int) -> float:
        """Return the angle, rad, at which a fin stays that does not report it; NaN: none, or nobody knows."""
        for fins, watch in zip(self._fins, self._stuck, strict=True):
            place, angle = watch.stuck
            if place >= 0 and fins[place] == fin:
                return clip(angle, -self._travel[fin], self._travel[fin])
        return math.nan

    @property
    def doubts(self) -> tuple[AxisDoubt, ...]:
        """Return what the motion says of the fins, by axis."""
        return tuple([AxisDoubt(x.doubt, self._fault(i) is not ActuatorFault.NONE) for i, x in enumerate(self._stuck)])

    def _fault(self, axis: int) -> ActuatorFault:
        """Return what is wrong with an axis, as either of its watches has found."""
        fault, left = self._axes[axis].fault, self._left[axis].left
        if fault is ActuatorFault.LOST or left == 0.0:
            return ActuatorFault.LOST
        return ActuatorFault.WEAK if left < 1.0 else fault

    def freeze(self) -> HullMemory:
        """Return the whole memory."""
        axes, left = tuple([axis.freeze() for axis in self._axes]), tuple([left.freeze() for left in self._left])
        held = tuple(self._sums), tuple(self._speeds), tuple([angles.freeze() for angles in self._angles])
        stuck = tuple([stuck.freeze() for stuck in self._stuck])
        values, cross = tuple(self._reference.values), self._flow.memory
        return HullMemory(values, axes, *held, left, cross, stuck, self._attitude.t_away)

    def thaw(self, memory: HullMemory) -> None:
        """Restore the memory that `freeze` returned."""
        for i, (values, remembered) in enumerate(zip(memory.references, memory.axes, strict=True)):
            self._refer(i, values)
            self._axes[i].thaw(remembered)
            self._left[i].thaw(memory.left[i])
            self._stuck[i].thaw(memory.stuck[i])
            self._angles[i].thaw(memory.angles[i])
        self._sums, self._speeds, self._flow.memory = list(memory.sums), list(memory.speeds), memory.cross
        self._attitude.t_away = memory.t_away

    def _refer(self, axis: int, values: Values) -> None:
        """Judge an axis by these coefficients from now on; by vehicle.toml if there are none."""
        if self._reference.refer(axis, values):
            for watch in (self._axes[axis], self._left[axis], self._stuck[axis]):
                watch.design(self._reference.eddies[axis])

    def _follow(self, axis: int, adopted: Adopted) -> bool:
        """Judge an axis by what held in adoption; return whether it can be judged.

        While fins are at fault, also by adoption, what held before does, or a fault would become what is usual. Where
        nothing held and the motion refutes vehicle.toml only fins that do hardly anything by what is learned are named.
        """
        watch, left, stuck = self._axes[axis], self._left[axis], self._stuck[axis]
        held = (adopted.held_diving, adopted.held_steering)[axis]
        if adopted.halved[axis] and self._fault(axis) is ActuatorFault.NONE:
            self._refer(axis, held)
            watch.begin(_HELD_STD)
            left.begin(LEFT[ActuatorFault.WEAK])
            stuck.pause()
            return True
        if held and held[0] == held[0]:
            sound = self._fault(axis) is ActuatorFault.NONE and not any(one.suspects for one in (watch, left, stuck))
            if held != self._reference.values[axis] and sound and (adopted.caution == 0.0 or adopted.proven[axis]):
                before = self._reference.values[axis]
                if not before or abs(held[-1] - before[-1]) > _FAR * abs(before[-1]):
                    watch.begin(_HELD_STD)
                    left.pause()
                    stuck.pause()
                self._refer(axis, held)
            return True
        if not adopted.refuted[axis]:
            return True
        in_force = (adopted.diving, adopted.steering)[axis][-1]
        if in_force / self._files[axis][-1] < NOTHING:
            watch.give_up()
        return False

    def _judge(
        self,
        axis: int,
        tick: Tick,
        frame: SensorFrame,
        applied: Applied,
        state: StateEstimate,
        water: tuple[WaterSpeed, ...],
        adopted: Adopted | None,
        speaks: bool,
    ) -> bool:
        """Take one step of an axis; return whether its fault, or a fin that stays, is another one now."""
        t, was, stuck = tick.t, self._fault(axis), self._stuck[axis]
        known = adopted is None or self._follow(axis, adopted)
        total, count = self._sums[axis]
        self._sums[axis] = (0.0, 0)
        told = self._angles[axis].update(self._fins[axis], t, frame, applied, PERIOD)
        if stuck.stuck[0] >= 0 and stuck.stuck[0] not in told.mute:
            stuck.forget()
        n = frame.n.value if frame.n.usable(t, self._params.timeout) else applied.n
        before, self._speeds[axis], driven = self._speeds[axis], math.nan, self._advance * n
        u = least_speed(driven, before, state, water)
        fast = max(u, water[0].u) if water else u
        across, steady = current_across(state, water) if axis else (0.0, True)
        if axis and self._flow.jumped(across):
            self._axes[axis].pause()
        judged = count and steady and applied.armed and speaks and state.depth_ok and state.eta.z > _DEPTH_MIN
        if judged and u > _SPEED_MIN and (n == 0.0 or driven > _BRAKES * fast):
            cross = ((state.nu.v if axis else state.nu.w) if state.velocity_ok else 0.0) - across
            seen = Seen(t, u, cross, total / count, told, water)
            if not known:
                self._hold(axis, seen, state)
            else:
                self._speeds[axis] = u
                if self._weigh(axis, seen, state):
                    return True
        else:
            self._pause(axis)
        return self._fault(axis) is not was

    def _pause(self, axis: int) -> None:
        """Judge nothing of an axis."""
        for one in (self._axes[axis], self._left[axis], self._stuck[axis]):
            one.pause()

    def _hold(self, axis: int, seen: Seen, state: StateEstimate) -> None:
        """Judge an axis of which the model is refuted: only whether its fins hold in vain.

        Fins that jam without a report before anything has held refute the model, too.
        """
        model = self._reference.models[axis]
        _, angles, over = self._effects[axis].of(model.control, seen.told.angles)
        hull = seen.u * seen.cross * model.crosswise + model.restoring * math.sin(state.eta.theta)
        self._left[axis].pause()
        self._stuck[axis].pause()
        self._axes[axis].hold(seen.rate, hull, seen.u * seen.u * angles, over)

    def _weigh_fins(self, axis: int, step: Step, seen: Seen, steady: bool) -> None:
        """Lay a step before what judges single fins: nothing does where none acts on both axes."""

    def _weigh(self, axis: int, seen: Seen, state: StateEstimate) -> bool:
        """Lay one step before the three that judge an axis: effect or none, how much of it, and a fin that stays.

        Return whether the last one has found another fin, or another angle.
        """
        t, u, cross, rate, (told, mute), water = seen
        watch, left, stuck, model = self._axes[axis], self._left[axis], self._stuck[axis], self._reference.models[axis]
        pinged, (units, angles, over) = bool(water), self._effects[axis].of(model.control, told)
        share = damped_share(u * model.damping, PERIOD)  # 0.98 for a hull of 5.3 m, 0.87 for one of 1.1 m
        damping, force = share * u * model.damping, share * u * u
        restoring = model.restoring * math.sin(state.eta.theta)
        moment, hull = force * angles, share * (u * cross * model.crosswise + restoring)
        steady = not (axis and (self._flow.changes or state.sensors.dvl.fault is SourceFault.CURRENT))
        # the angle of a fin that stays unreported is not known well enough to judge the others
        alone = stuck.stuck[0] < 0 and not self._explained
        if alone:
            watch.update(rate, damping, hull, moment, over, u / CRUISE, steady, pinged)
        else:
            watch.pause()
            left.pause()
        motion = self._reference.models[1].sway if axis else self._heaved.heave
        heard = cross if state.velocity_ok and pinged else math.nan
        cross = self._flow.carry(axis, t, motion, u, (rate, angles / model.control), heard)
        if axis == 0:
            (a, b, c), v = self._heaved.turning, self._flow.memory.velocities[1]
            restoring += a * state.nu.r * state.nu.r + b * v * state.nu.r + c * v * v
        hull = share * (u * cross * model.crosswise + restoring)
        each = [force * unit * angle for unit, angle in zip(units, told, strict=True)]
        self._weigh_fins(axis, Step(rate, damping, share * restoring, hull, each), seen, steady)
        if not self._reference.values[axis]:
            left.pause()
            stuck.pause()
            return False
        if alone:
            left.update(rate, damping, hull, moment, steady, pinged)
        if not mute:
            stuck.pause()
        elif stuck.update(rate, damping, hull, [force * unit for unit in units], told, mute):
            watch.begin(_HELD_STD, ActuatorFault.NONE)
            left.begin(1.0)
            return True
        return False
