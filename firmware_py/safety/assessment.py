"""From what was heard, estimated and ordered to what the rules look at."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from firmware_py.records.command import Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Cause
from firmware_py.records.fence import WITHIN, Fence
from firmware_py.records.health import (
    ActuatorFault,
    ActuatorHealth,
    FinEvidence,
    SourceFault,
    SourceHealth,
    SourceState,
    WeightState,
)
from firmware_py.records.manoeuvrability import UNLIMITED, Manoeuvrability
from firmware_py.records.order import Mode, Order
from firmware_py.records.sensing import Heard, SensorFrame
from firmware_py.safety.conditions import NO_FAULTS, ActuatorFaults, Conditions, Faulty
from firmware_py.safety.mode_orders import in_hand
from firmware_py.safety.safety_params import SafetyParams
from firmware_py.safety.supervisor_memory import SupervisorMemory, VehicleFin
from firmware_py.tick import Tick

_RECENT = 5.0
"""What was last heard longer ago, s, of battery and leak sensor is not heard; they report about once a second."""
_GOOD, _NO_FAULT = SourceState.GOOD, SourceFault.NONE
_HANGS = (WeightState.HELD, WeightState.STUCK)
_STUCK = (ActuatorFault.JAMMED, ActuatorFault.HARD_OVER, ActuatorFault.LOST)
_DAMAGED = (*_STUCK, ActuatorFault.WEAK)
_STEERS = (ActuatorFault.NONE, ActuatorFault.SLOW, ActuatorFault.LOOSE, ActuatorFault.WEAK)
_TOO_SLOW = (ActuatorFault.SLOW, ActuatorFault.LAGGING)
_WORN = (*_TOO_SLOW, ActuatorFault.LOOSE)
_BY_MOTION = 0.5
"""Of the reserve. 10 deg of angle are 22 % of the control that two fins of 23 deg have; 4 deg too many are 9 %."""
_STEERED = 2.0
"""For so long, s, a dive is one by hand after MANUAL: whoever changes modes more often than limits have to be passed to
count would pass them in none."""
_SLOW = 0.5
"""Slower than this, m/s, the way down is no dive that is pulled up from."""
_SLOWEST = 0.3
"""Through the water it is never counted as slower than this, m/s: the way up is made through it, and a bottom comes as
fast as the vehicle moves over the ground."""
_RISES = 0.05
"""A bottom that rises more slowly than this, m/s, is level: the noise of the sensors is as much."""
_CLIMBS = 0.9
"""The way up is as steep as this share of the pitch: the hull has an angle of attack."""


class Seen(NamedTuple):
    """What the supervisor is given in one tick; `reference` is of the last one, None before the first."""

    tick: Tick
    frame: SensorFrame
    state: StateEstimate
    actuators: ActuatorHealth
    order: Order
    reference: Reference | None
    left: Manoeuvrability = UNLIMITED


def conditions(
    params: SafetyParams,
    fence: Fence,
    was: SupervisorMemory,
    seen: Seen,
    faults: ActuatorFaults,
    wanted: Mode,
    late: int,
    mission_done: bool,
) -> Conditions:
    """Return what the rules look at in this tick, in which the mode `wanted` is in force or ordered."""
    tick, frame, state, _, order, reference, left = seen
    t, eta, z_dot = tick.t, state.eta, state.z_dot
    watched = was.watched and not in_hand(order)
    sensors, battery, leak = state.sensors, frame.battery, frame.leak
    charge = battery.value.remaining if battery.ok else math.nan
    breach, weight = fence.breach_at(eta.x, eta.y), was.actuators.drop_weight
    attitude_age, depth_age = t - frame.ahrs.t_valid, t - frame.pressure.t_valid
    attitude_ok = state.attitude_ok and attitude_age <= params.attitude_timeout
    depth_ok = state.depth_ok and depth_age <= params.depth_timeout
    rise = was.bottom.rise if was.bottom.rise > _RISES else 0.0
    u = max(state.nu.u, _SLOW)
    through = max(min(u, state.through_water, state.through_water_sure), _SLOWEST)
    fix_heard = sensors.fix.state is _GOOD and frame.fix.usable(t, params.fix_timeout)
    if sensors.fix.fault is SourceFault.CONTRADICTED:  # it lies about the place, and hears satellites
        fix_heard = t - frame.fix.t_valid <= params.fix_timeout
    return Conditions(
        wanted=wanted,
        attitude_ok=attitude_ok,
        depth_ok=depth_ok,
        depth=eta.z,
        altitude=state.altitude,
        z_dot=z_dot,
        fix_heard=fix_heard,
        leak=state.leak,
        charge=charge,
        late=late,
        mission_done=mission_done,
        roll=abs(eta.phi),
        pitch=abs(eta.theta),
        fins_heard=wanted is was.mode or fins_heard(tick, frame, params),  # it matters on arming alone
        breach=breach,
        steered=t - was.t_manual <= _STEERED,
        returning=was.returning and breach != WITHIN and wanted is Mode.MANUAL,
        charge_silent=was.charge_known
        and (math.isnan(charge) or t - battery.t_valid > _RECENT or sensors.battery.state is not _GOOD),
        leak_silent=leak.t_valid > -math.inf
        and not (leak.ok and t - leak.t_valid <= _RECENT and leak.value >= 0.0 and sensors.leak.state is _GOOD),
        bus_silent=attitude_age > params.bus_time and params.bus_time < t - _newest(frame) < math.inf,
        wanted_depth=math.nan if reference is None else reference.z_d,
        above=reference is not None and reference.above,
        leg_left=was.progress.leg_left(params),
        charge_home=was.progress.charge_home,
        surfacing=was.surfacing * tick.dt,
        sensors=sensors,
        attitude_fault=_NO_FAULT if attitude_ok else _lost_by(sensors.ahrs, frame.ahrs, t, params.attitude_timeout),
        depth_fault=_NO_FAULT if depth_ok else _lost_by(sensors.pressure, frame.pressure, t, params.depth_timeout),
        faults=faults,
        station_silence=t - order.t_station if order.t_station > -math.inf else math.nan,
        sticks_silence=t - order.t_sticks,
        watched=watched,
        brought_up=was.brought_up,
        done_with=was.mode is Mode.DISARMED and was.cause is not Cause.NONE and not watched,
        sunk_by=was.altitude_up - state.altitude,
        left=left,
        slope=math.atan2(z_dot, u),
        rise=rise,
        rise_slope=math.atan2(rise, through),
        too_steep=max(0.0, rise - through * math.tan(_CLIMBS * params.ascent.pitch)),
        while_it_stops=rise * (1.0 - 0.5 * through / u) if rise > through * math.tan(params.ascent.pitch) else 0.0,
        start=was.start,
        weight_gone=weight not in _HANGS and (was.drop or was.weight_gone or weight is WeightState.GONE),
    )


def _lost_by(health: SourceHealth, heard: Heard[Any], t: float, timeout: float) -> SourceFault:
    """Return what is wrong with a sensor whose quantity is lost; the integrity may take a moment longer to say so."""
    if health.fault is not _NO_FAULT or t - heard.t_valid <= timeout:
        return health.fault
    return SourceFault.SILENT if heard.ok or heard.t_valid == -math.inf else SourceFault.UNHEALTHY


def fins_heard(tick: Tick, frame: SensorFrame, params: SafetyParams) -> bool:
    """Return whether every fin reports its angle."""
    return all(fin.usable(tick.t, params.fin_timeout) and math.isfinite(fin.value) for fin in frame.fins)


def actuator_faults(
    health: ActuatorHealth, vehicle_fins: Sequence[VehicleFin], left: Manoeuvrability, reserve: float
) -> ActuatorFaults:
    """Return the faults by kind; fins are damaged while at least `reserve` of a sound vehicle's control is left.

    A fin of an X is a plane and a rudder: it is damaged while enough is left of both axes. Where only the motion tells
    the angle at which a fin stays, less will do: it is some degrees off at first.
    """
    if health.faultless:
        return NO_FAULTS
    fins = list(zip(health.fins, vehicle_fins, strict=True))
    both = any(fin.s and fin.r for fin in vehicle_fins)
    axes = ("fins", "fins") if both else ("stern planes", "rudders")
    planes = _together([Faulty(fault, fin.name) for fault, fin in fins if fin.is_plane], axes[0])
    rudders = _together([Faulty(fault, fin.name) for fault, fin in fins if fin.r], axes[1])
    reach_s = [abs(fin.s) * fin.limit for fin in vehicle_fins if fin.is_plane]
    reach_r = [abs(fin.r) * fin.limit for fin in vehicle_fins if fin.r]
    by_motion = any(fin.is_stuck and fin.source is FinEvidence.MOTION for fin in health.left)
    enough = reserve * _BY_MOTION if by_motion else reserve
    dives, turns = left.dive_left >= enough, left.turn_left >= enough
    damaged = [*(planes if dives else ()), *(rudders if turns else ())] if (dives and turns) or not both else []
    propeller = [Faulty(health.propeller, "propeller")]
    everything = [*planes, *rudders, *propeller]
    if health.drop_weight is WeightState.SILENT:
        everything.append(Faulty(ActuatorFault.SILENT, "drop weight"))
    return ActuatorFaults(
        plane=_too_slow(planes, reach_s, reserve) if dives else _first(planes, _DAMAGED),
        rudder=_too_slow(rudders, reach_r, reserve) if turns else _first(rudders, _DAMAGED),
        propeller=_first(propeller, _STUCK),
        runaway=_first(propeller, (ActuatorFault.RUNAWAY,)),
        silent=_first(everything, (ActuatorFault.SILENT,)),
        worn=_first(everything, _WORN) or _first(propeller, (ActuatorFault.WEAK,)),
        damaged=_first(damaged, _DAMAGED),
        slow=_first(planes, _TOO_SLOW),
    )


def _together(fins: list[Faulty], name: str) -> list[Faulty]:
    """Return the fins of an axis, weak ones by its name: nothing tells which of several it is."""
    alone = len(fins) == 1
    return [fin if alone or fin.fault is not ActuatorFault.WEAK else fin._replace(name=name) for fin in fins]


def _too_slow(fins: list[Faulty], reach: list[float], reserve: float) -> Faulty | None:
    """Return the first fin that is too slow, of an axis of which no more than `reserve` is known to be quick.

    `reach` is what each fin can do.
    """
    quick = sum([far for fin, far in zip(fins, reach, strict=True) if fin.fault in _STEERS])
    return _first(fins, (ActuatorFault.LAGGING,)) if quick <= reserve * sum(reach) else None


def _first(actuators: Iterable[Faulty], of: tuple[ActuatorFault, ...]) -> Faulty | None:
    return next((actuator for actuator in actuators if actuator.fault in of), None)


def _newest(frame: SensorFrame) -> float:
    """Return when the newest measurement of any device was true, s."""
    sensors = (frame.ahrs.t_valid, frame.dvl.t_valid, frame.pressure.t_valid, frame.altitude.t_valid)
    others = (frame.fix.t_valid, frame.n.t_valid, frame.battery.t_valid, frame.leak.t_valid, frame.hardpoint.t_valid)
    return max(*sensors, *others, *(fin.t_valid for fin in frame.fins))
