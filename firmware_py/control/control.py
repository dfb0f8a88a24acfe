"""Depth, heading and speed control: from reference and state to a demand."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from firmware_py.control.adoption_params import AdoptionParams
from firmware_py.control.ascent import AscentControlMemory, AscentControlParams, PitchControl
from firmware_py.control.axis_law import AxisLaw
from firmware_py.control.depth import DepthControl, DepthControlMemory
from firmware_py.control.feed_forward import attitude_rates
from firmware_py.control.fin_demand import fin_demand
from firmware_py.control.heading import HeadingControl, HeadingControlMemory
from firmware_py.control.own_law import Law, Steering, steering
from firmware_py.control.pid import DepthPidGains, DepthPidLaw, HeadingPidLaw, PidGains
from firmware_py.control.sliding_mode_law import SlidingModeLaw
from firmware_py.control.sliding_mode_params import (
    PAPER_DEPTH_GAINS,
    PAPER_HEADING_GAINS,
    S_LAST_DEPTH,
    S_LAST_HEADING,
    DepthSlidingGains,
    GainSet,
    HeadingSlidingGains,
)
from firmware_py.control.speed import SpeedControl, SpeedParams
from firmware_py.marine import clip
from firmware_py.own_part import Guard, GuardMemory
from firmware_py.params import ParamError, TakesEffect, named_values, param, table
from firmware_py.part_name import PartName
from firmware_py.records.adoption import Adopted
from firmware_py.records.command import AscentStage, Demand, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.event import Event
from firmware_py.records.order import Mode, Order
from firmware_py.tick import Rate, Tick
from firmware_py.vehicle.linear_models import DivingCoefficients, SteeringCoefficients, diving_model, steering_model
from firmware_py.vehicle.vehicle import Vehicle

_STEERS, _CLIMBS, _DRIVES = 0.6, 0.9, 0.8
"""Share of the desired speed that is made through the water: in flight, and while SURFACE has its bow up. There the
propeller turns with so much of its trim at least: the current may not be known, or the DVL lie."""
NO_DEMAND = Demand(delta_s=0.0, delta_r=0.0, n=0.0, sigma_z=0.0, sigma_psi=0.0)


class LawKind(enum.Enum):
    """Control law of depth and heading."""

    SLIDING = enum.auto()
    PID = enum.auto()


@dataclass(frozen=True, slots=True)
class ControlParams:
    """Choice of the laws, their gains, and the speeds that they are scheduled over."""

    law: LawKind | PartName = param(
        LawKind.SLIDING,
        doc="Law of depth and heading: sliding mode, or the PID baseline with the same references and feed-forward.",
        mav="LAW",
        when=TakesEffect.DISARMED,
    )
    gains: GainSet = param(
        GainSet.CONFIGURED,
        doc="Gains of the sliding-mode laws: those configured here, or the paper's poles and boundary layers. Either"
        " way the laws are designed from the coefficients of vehicle.toml, so s and k are not the printed ones.",
        mav="GAINS",
        when=TakesEffect.DISARMED,
    )
    u_min: float = param(
        0.5,
        unit="m/s",
        low=0.05,
        high=5.0,
        doc="Lowest speed the laws are designed for. Below it fin angles are reduced in proportion to the speed.",
        mav="U_MIN",
    )
    u_max: float = param(
        4.0,
        unit="m/s",
        low=0.1,
        high=20.0,
        doc="Highest speed the laws are designed for. Above it the design of this speed is kept.",
        mav="U_MAX",
    )
    sticks_age_max: float = param(
        0.5,
        unit="s",
        low=0.0,
        high=10.0,
        doc="MANUAL: stick positions older than this are ignored; fins go to centre, the propeller stops.",
        mav="STICKS_AGE",
    )
    depth: DepthSlidingGains = table(DepthSlidingGains, mav="Z_")
    heading: HeadingSlidingGains = table(HeadingSlidingGains, mav="PSI_")
    depth_pid: DepthPidGains = table(DepthPidGains, mav="ZPID_")
    heading_pid: PidGains = table(PidGains, mav="PPID_")
    speed: SpeedParams = table(SpeedParams, mav="SPD_")
    ascent: AscentControlParams = table(AscentControlParams, mav="ASC_")
    adoption: AdoptionParams = table(AdoptionParams, mav="ADO_")
    own: Mapping[str, Any] = named_values("Parameters of a law of one's own.")

    @property
    def poles(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the poles of the sliding-mode laws of depth and heading at the trim speed, 1/s."""
        if self.gains is GainSet.PAPER:
            return PAPER_DEPTH_GAINS.poles, PAPER_HEADING_GAINS.poles
        return self.depth.poles, self.heading.poles

    def __post_init__(self) -> None:
        if not self.u_min < self.u_max:
            raise ParamError(f"u_min_m_s = {self.u_min:g}: must be below u_max_m_s = {self.u_max:g}")


class ControlMemory(NamedTuple):
    """Memory of the laws: depth, heading, the integral of the speed controller, rev/s, pitch in SURFACE, one's own."""

    depth: DepthControlMemory
    heading: HeadingControlMemory
    speed: float
    pitch: AscentControlMemory
    own: GuardMemory | None = None


class Control:
    """Depth, heading and speed control with the laws that the configuration chose.

    Raises:
        ParamError: no law can be designed for the vehicle's coefficients.
    """

    def __init__(self, params: ControlParams, vehicle: Vehicle, own: Guard[Law] | None = None) -> None:
        """Make the laws; `own` is the one of one's own, if `params` chooses it."""
        self._own = own
        self._params = params
        self._n_max = vehicle.propeller.n_max
        effectiveness = vehicle.effectiveness
        self._delta_s_max, self._delta_r_max = effectiveness.delta_s_max, effectiveness.delta_r_max
        paper = params.gains is GainSet.PAPER
        depth_gains = PAPER_DEPTH_GAINS if paper else params.depth
        heading_gains = PAPER_HEADING_GAINS if paper else params.heading
        depth_law, heading_law = _make_laws(params, depth_gains, heading_gains, vehicle)
        self._depth = DepthControl(depth_law, vehicle, depth_gains.climb_bias_time)
        self._heading = HeadingControl(heading_law, vehicle)
        self._speed = SpeedControl(params.speed, vehicle.propeller)
        self._pitch = PitchControl(params.ascent, vehicle)

    def update(
        self,
        tick: Tick,
        mode: ModeState,
        order: Order,
        reference: Reference,
        state: StateEstimate,
        adopted: Adopted | None = None,
    ) -> Demand:
        """Return the demand of this tick: delta_s and delta_r (rad), n (rev/s), sigma_z (m), sigma_psi (rad).

        DISARMED: all zero; the memory is cleared. MANUAL: the sticks, limited; zero when they are too old.
        SURFACE: a pitch instead of a depth, and the propeller as the stage has it. Other modes: the laws. A state with
        a non-finite entry gives NaN fin angles, which the gate rejects, and leaves depth and heading memory as they
        are. Below u_min, through the water, the laws' fin angles are scaled by u / u_min, at rest and astern to zero;
        sticks, and the stern planes without attitude, are not. The excitation of a learning manoeuvre is part of the
        demand, so that the laws know of it and the gate limits the sum.
        """
        if mode.mode is Mode.DISARMED:
            self._reset()
            return NO_DEMAND
        eta, nu = state.eta, state.nu
        finite = math.isfinite(sum(nu) + eta.z + eta.phi + eta.theta + eta.psi)
        if finite and tick.every(Rate.HZ_10):
            self._schedule(state.through_water, adopted)
        if mode.mode is Mode.MANUAL:
            return self._manual(tick, order, state if finite else None)
        if not finite:
            return Demand(math.nan, math.nan, self._speed.update(reference.u_d, 0.0, False, tick.dt), 0.0, 0.0)
        dt = tick.dt
        theta_dot, psi_dot = attitude_rates(state)
        fade = clip(state.through_water / self._params.u_min, 0.0, 1.0)
        if mode.mode is Mode.SURFACE:
            return self._come_up(mode, reference, state, theta_dot, psi_dot, fade, dt)
        steered = None if self._own is None else steering(self._own, tick, reference, state)
        if steered is not None:
            return self._steer(steered, reference, state, psi_dot, fade, dt)
        delta_s, sigma_z = self._depth.update(reference, state, theta_dot, fade, dt)
        self._pitch.follow(delta_s, state, dt)
        delta_r, sigma_psi = self._heading.update(reference, state, psi_dot, fade, dt)
        n = self._speed.drive(reference.u_d, state, dt, _STEERS)
        return Demand(delta_s, delta_r, n, sigma_z, sigma_psi)

    def told(self) -> tuple[Event, ...]:
        """Return what happened since the last call: that a law of one's own has failed."""
        return () if self._own is None else self._own.told()

    def freeze(self) -> ControlMemory:
        """Return the whole memory."""
        own = None if self._own is None else self._own.freeze()
        return ControlMemory(
            self._depth.freeze(), self._heading.freeze(), self._speed.freeze(), self._pitch.freeze(), own
        )

    def thaw(self, memory: ControlMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._depth.thaw(memory.depth)
        self._heading.thaw(memory.heading)
        self._speed.thaw(memory.speed)
        self._pitch.adopt(memory.depth.coefficients)
        self._pitch.thaw(memory.pitch)
        if self._own is not None and memory.own is not None:
            self._own.thaw(memory.own)

    def _schedule(self, u: float, adopted: Adopted | None) -> None:
        """Redesign depth and heading for the speed u, m/s, kept in [u_min, u_max], from what is adopted."""
        if adopted is not None:
            diving = DivingCoefficients(*adopted.diving)
            self._depth.adopt(diving, adopted.caution)
            self._heading.adopt(SteeringCoefficients(*adopted.steering), adopted.caution)
            self._pitch.adopt(diving)
        u = clip(u, self._params.u_min, self._params.u_max)
        self._depth.schedule(u)
        self._heading.schedule(u)

    def _reset(self) -> None:
        self._depth.reset()
        self._heading.reset()
        self._speed.reset()
        self._pitch.reset()
        if self._own is not None:
            self._own.rest()

    def _steer(
        self, own: Steering, reference: Reference, state: StateEstimate, psi_dot: float, fade: float, dt: float
    ) -> Demand:
        """Return the demand of a law of one's own; the built-in ones follow, so that they can go on at any time."""
        excited, grip = (reference.delta_s, reference.delta_r), reference.grip
        delta_s = fin_demand(own.delta_s, excited[0], grip, self._delta_s_max, fade)
        delta_r = fin_demand(own.delta_r, excited[1], grip, self._delta_r_max, fade)
        self._depth.reset()
        self._heading.follow(psi_dot, delta_r, dt)
        self._pitch.follow(delta_s, state, dt)
        n = self._speed.drive(reference.u_d, state, dt, _STEERS)
        n = n if own.n is None else clip(own.n, -self._n_max, self._n_max)
        return Demand(delta_s, delta_r, n, own.sigma_z, own.sigma_psi)

    def _come_up(
        self,
        mode: ModeState,
        reference: Reference,
        state: StateEstimate,
        theta_dot: float,
        psi_dot: float,
        fade: float,
        dt: float,
    ) -> Demand:
        """Return the demand of a stage of SURFACE; a tilt that is doubted is not used, without attitude no heading."""
        drives = mode.ascent not in (AscentStage.REVERSE, AscentStage.STOPPED)
        least, floor = (_CLIMBS, _DRIVES) if state.attitude_ok and state.eta.theta > 0.0 else (0.0, 0.0)
        n = self._speed.drive(reference.u_d if drives else 0.0, state, dt, least, floor)
        if mode.ascent is AscentStage.REVERSE:
            n = -min(self._params.ascent.n_reverse, self._n_max)
        elif mode.ascent is AscentStage.FULL:
            n = self._n_max
        if not state.attitude_ok or state.sensors.ahrs.tilt_doubted:
            delta_s = self._pitch.update_blind(mode.pitch, state, reference.u_d, dt) if drives else 0.0
        else:
            design = clip(state.through_water, self._params.u_min, self._params.u_max)
            delta_s = fade * self._pitch.update(mode.pitch, state, theta_dot, design, dt)
        if not (drives and state.attitude_ok):
            return Demand(delta_s, 0.0, n, 0.0, 0.0)
        delta_r, sigma_psi = self._heading.update(reference, state, psi_dot, fade, dt)
        return Demand(delta_s, delta_r, n, 0.0, sigma_psi)

    def _manual(self, tick: Tick, order: Order, state: StateEstimate | None) -> Demand:
        """Return the sticks as a demand; a finite `state` keeps the sway of heading control up to date."""
        recent = tick.t - order.t_sticks <= self._params.sticks_age_max
        delta_s, delta_r, n = order.sticks if recent and math.isfinite(sum(order.sticks)) else (0.0, 0.0, 0.0)
        delta_s = clip(delta_s, -self._delta_s_max, self._delta_s_max)
        delta_r = clip(delta_r, -self._delta_r_max, self._delta_r_max)
        self._depth.reset()
        self._speed.reset()
        if state is not None:
            self._heading.follow(attitude_rates(state).psi_dot, delta_r, tick.dt)
        return Demand(delta_s, delta_r, clip(n, -self._n_max, self._n_max), 0.0, 0.0)


def _make_laws(
    params: ControlParams, depth: DepthSlidingGains, heading: HeadingSlidingGains, vehicle: Vehicle
) -> tuple[AxisLaw, AxisLaw]:
    """Return the laws of depth and of heading; the sliding-mode ones start with the design for the trim speed."""
    if params.law is LawKind.PID:
        return DepthPidLaw(params.depth_pid), HeadingPidLaw(params.heading_pid)
    u = vehicle.propeller.u_trim
    return (
        SlidingModeLaw(depth, diving_model(vehicle, u), S_LAST_DEPTH),
        SlidingModeLaw(heading, steering_model(vehicle, u), S_LAST_HEADING),
    )
