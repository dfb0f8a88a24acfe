"""From reference and state to a demand: depth, heading and speed, each under its own law."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.control.depth import Axis, Depth, DepthMemory
from firmware_py.control.sliding_mode_gains import PAPER_DEPTH, PAPER_HEADING, DepthGains, HeadingGains, Preset
from firmware_py.control.heading import Heading, HeadingMemory
from firmware_py.control.pid import DepthPidAxis, DepthPidGains, PidAxis, PidGains
from firmware_py.control.sliding_mode_law import SlidingAxis
from firmware_py.control.speed import Speed, SpeedParams
from firmware_py.control.feed_forward import rates
from firmware_py.marine import clip
from firmware_py.params import ParamError, When, param, table
from firmware_py.records.command import Demand, ModeState, Reference
from firmware_py.records.estimate import StateEstimate
from firmware_py.records.order import Mode, Order
from firmware_py.schedule import Rate, Tick
from firmware_py.vehicle.linear_models import diving, steering
from firmware_py.vehicle.vehicle import Vehicle


class LawKind(enum.Enum):
    """The laws to choose from."""

    SLIDING = enum.auto()
    PID = enum.auto()


@dataclass(frozen=True, slots=True)
class ControlParams:
    """Which laws, their gains, and the speeds they are scheduled over."""

    law: LawKind = param(LawKind.SLIDING, mav="LAW", when=When.DISARMED)
    gains: Preset = param(Preset.OWN, mav="GAINS", when=When.DISARMED)
    u_min: float = param(
        0.5,
        unit="m/s",
        low=0.05,
        high=5.0,
        doc="Slowest speed the laws are designed for; below it the fins fade out.",
        mav="U_MIN",
    )
    u_max: float = param(
        4.0, unit="m/s", low=0.1, high=20.0, doc="Fastest speed the laws are designed for.", mav="U_MAX"
    )
    sticks_age_max: float = param(
        0.5, unit="s", low=0.0, high=10.0, doc="Older sticks count as let go.", mav="STICKS_AGE"
    )
    depth: DepthGains = table(DepthGains, mav="Z_")
    heading: HeadingGains = table(HeadingGains, mav="PSI_")
    depth_pid: DepthPidGains = table(DepthPidGains, mav="ZPID_")
    heading_pid: PidGains = table(PidGains, mav="PPID_")
    speed: SpeedParams = table(SpeedParams, mav="SPD_")

    def __post_init__(self) -> None:
        if not self.u_min < self.u_max:
            raise ParamError(f"u_min_m_s = {self.u_min:g}: must be below u_max_m_s = {self.u_max:g}")


class ControlMemory(NamedTuple):
    """Everything the laws remember."""

    depth: DepthMemory
    heading: HeadingMemory
    speed: float


class Control:
    """The laws that the configuration chose.

    Raises:
        ParamError: coefficients that no law can be designed for.
    """

    def __init__(self, params: ControlParams, vehicle: Vehicle) -> None:
        self._params = params
        self._n_max = vehicle.propeller.n_max
        effect = vehicle.effectiveness
        self._delta_s_max, self._delta_r_max = effect.delta_s_max, effect.delta_r_max
        paper = params.gains is Preset.PAPER
        depth_gains = PAPER_DEPTH if paper else params.depth
        dive, steer = _axes(params, depth_gains, PAPER_HEADING if paper else params.heading, vehicle)
        self._depth = Depth(dive, vehicle, depth_gains.drift_time)
        self._heading = Heading(steer, vehicle)
        self._speed = Speed(params.speed, vehicle.propeller)

    def update(self, tick: Tick, mode: ModeState, order: Order, reference: Reference, state: StateEstimate) -> Demand:
        """The demand of this tick.

        MANUAL passes the sticks on, bounded, and centres them when they are old; DISARMED asks for nothing and forgets.
        While the state is not finite the fins' demand is NaN, for the gate to judge, and nothing is learned from it.
        Below u_min the fins fade out: at rest and going astern they are centred. What a learning manoeuvre does with
        the fins is added here, so that the laws know of it and the gate judges the sum.
        """
        if mode.mode is Mode.DISARMED:
            self._reset()
            return Demand(0.0, 0.0, 0.0, 0.0, 0.0)
        eta, nu = state.eta, state.nu
        finite = math.isfinite(sum(nu) + eta.z + eta.phi + eta.theta + eta.psi)
        if finite and tick.every(Rate.HZ_10):
            self._schedule(nu.u)
        if mode.mode is Mode.MANUAL:
            return self._manual(tick, order, state if finite else None)
        if not finite:
            return Demand(math.nan, math.nan, self._speed.update(reference.u_d, 0.0, False, tick.dt), 0.0, 0.0)
        dt = tick.dt
        theta_dot, psi_dot = rates(state)
        share = clip(nu.u / self._params.u_min, 0.0, 1.0)
        delta_s, sigma_z = self._depth.update(reference, state, theta_dot, dt)
        delta_r, sigma_psi = self._heading.update(reference, state, psi_dot, share, dt)
        n = self._speed.update(reference.u_d, nu.u, state.velocity_ok, dt)
        delta_s = clip(reference.grip * delta_s + reference.delta_s, -self._delta_s_max, self._delta_s_max)
        delta_r = clip(reference.grip * delta_r + reference.delta_r, -self._delta_r_max, self._delta_r_max)
        return Demand(share * delta_s, share * delta_r, n, sigma_z, sigma_psi)

    def freeze(self) -> ControlMemory:
        """All it remembers."""
        return ControlMemory(self._depth.freeze(), self._heading.freeze(), self._speed.freeze())

    def thaw(self, memory: ControlMemory) -> None:
        """Takes up again what `freeze` gave."""
        self._depth.thaw(memory.depth)
        self._heading.thaw(memory.heading)
        self._speed.thaw(memory.speed)

    def _schedule(self, u: float) -> None:
        u = clip(u, self._params.u_min, self._params.u_max)
        self._depth.schedule(u)
        self._heading.schedule(u)

    def _reset(self) -> None:
        self._depth.reset()
        self._heading.reset()
        self._speed.reset()

    def _manual(self, tick: Tick, order: Order, state: StateEstimate | None) -> Demand:
        held = tick.t - order.t_sticks <= self._params.sticks_age_max
        delta_s, delta_r, n = order.sticks if held and math.isfinite(sum(order.sticks)) else (0.0, 0.0, 0.0)
        delta_s = clip(delta_s, -self._delta_s_max, self._delta_s_max)
        delta_r = clip(delta_r, -self._delta_r_max, self._delta_r_max)
        self._depth.reset()
        self._speed.reset()
        if state is not None:
            self._heading.follow(rates(state).psi_dot, delta_r, tick.dt)
        return Demand(delta_s, delta_r, clip(n, -self._n_max, self._n_max), 0.0, 0.0)


def _axes(params: ControlParams, depth: DepthGains, heading: HeadingGains, vehicle: Vehicle) -> tuple[Axis, Axis]:
    if params.law is LawKind.PID:
        return DepthPidAxis(params.depth_pid), PidAxis(params.heading_pid, rate=1, angle=2)
    u = vehicle.propeller.u_trim
    dive, steer = diving(vehicle, u), steering(vehicle, u)
    return SlidingAxis(depth, dive, last=-1.0), SlidingAxis(heading, steer, last=1.0)
