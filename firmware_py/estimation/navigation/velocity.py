"""Velocity over the bottom: the DVL, held between its pings; without it, what the propeller's speed makes likely."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.freshness import is_fresh
from firmware_py.marine import clip
from firmware_py.params import param
from firmware_py.records.sensing import Dvl, Heard


@dataclass(frozen=True)
class VelocityParams:
    """Which pings to believe, and what to believe without any."""

    timeout: float = param(
        2.0, unit="s", low=0.2, high=30.0, doc="Velocity is lost when not heard for so long.", mav="TIMEOUT"
    )
    std: float = param(
        0.01, unit="m/s", low=1e-4, high=1.0, doc="Noise of a ping that states no figure of merit.", mav="STD"
    )
    fom_max: float = param(
        0.2, unit="m/s", low=0.001, high=5.0, doc="A ping of a worse figure of merit is ignored.", mav="FOM_MAX"
    )
    u_max: float = param(10.0, unit="m/s", low=0.5, high=50.0, doc="A ping that is faster is ignored.", mav="U_MAX")
    accel_std: float = param(
        0.05, unit="m/s^2", low=0.0, high=2.0, doc="How fast a held velocity becomes wrong, 1 sigma.", mav="ACC_STD"
    )
    lost_std: float = param(
        0.3, unit="m/s", low=0.01, high=5.0, doc="1 sigma of the propeller's model, current included.", mav="LOST_STD"
    )
    tau_lost: float = param(
        3.0, unit="s", low=0.1, high=60.0, doc="Time constant from the last ping to that model.", mav="TAU_LOST"
    )
    u_trim: float = param(
        1.8288, unit="m/s", low=0.1, high=20.0, doc="Speed at the propeller's trim point.", mav="U_TRIM"
    )
    n_trim: float = param(500.0, unit="rpm", low=10.0, high=10000.0, doc="Propeller speed at that speed.", mav="N_TRIM")


class VelocityMemory(NamedTuple):
    """Body velocity (m/s), the 1 sigma of the last good ping and its time of validity `t`."""

    t: float
    u: float
    v: float
    w: float
    fom: float


START = VelocityMemory(-math.inf, 0.0, 0.0, 0.0, 0.0)


def update(
    params: VelocityParams, memory: VelocityMemory, heard: Heard[Dvl], t: float, dt: float, n: float
) -> VelocityMemory:
    """One tick of dt, s: takes a good new ping, else holds the last; long without, follows the propeller (n, rev/s)."""
    if is_fresh(heard, memory.t, t):
        u, v, w, fom, _ = heard.value
        fom = fom if math.isfinite(fom) and fom > 0.0 else params.std
        if abs(u) <= params.u_max and abs(v) <= params.u_max and abs(w) <= params.u_max and fom <= params.fom_max:
            return VelocityMemory(heard.t_valid, u, v, w, fom)
    if t - memory.t <= params.timeout:
        return memory
    follow = dt / (params.tau_lost + dt)
    u_model = clip(n * params.u_trim / params.n_trim, -params.u_max, params.u_max)
    return VelocityMemory(
        memory.t,
        memory.u + follow * (u_model - memory.u),
        memory.v - follow * memory.v,
        memory.w - follow * memory.w,
        memory.fom,
    )


def std(params: VelocityParams, memory: VelocityMemory, t: float) -> float:
    """1 sigma of u and of v at the time t, m/s: the ping's, growing with its age up to that of the model."""
    return min(math.hypot(memory.fom, params.accel_std * (t - memory.t)), params.lost_std)
