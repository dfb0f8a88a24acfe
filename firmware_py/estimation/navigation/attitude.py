"""Attitude: the gyro carries the angles from one report to the next, the AHRS angles pull them back.

A complementary filter (Mahony 2008, in Euler angles): white noise sigma of angles that arrive every T comes out as
sigma sqrt(T / 2 tau); a gyro bias b stays as an angle b tau. All of it happens at the report's time of validity; the
answer for a tick is extrapolated with the body rates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.freshness import is_fresh
from firmware_py.marine import clip, euler_rates, wrap
from firmware_py.params import param
from firmware_py.records.sensing import Ahrs, Heard

_VERTICAL = math.cos(math.radians(84.0))
"""Nearer to the vertical than this, differences of phi and psi mean nothing: the AHRS is taken as it is."""


@dataclass(frozen=True)
class AttitudeParams:
    """How much to trust gyro and AHRS."""

    tau: float = param(
        0.5, unit="s", low=0.0, high=10.0, doc="Time constant with which AHRS angles correct the gyro.", mav="TAU"
    )
    tau_rate: float = param(
        0.02, unit="s", low=0.0, high=0.5, doc="Low-pass of p, q, r, and so their delay; 0 is off.", mav="TAU_RATE"
    )
    timeout: float = param(
        0.5, unit="s", low=0.02, high=5.0, doc="Attitude is lost when not heard for so long.", mav="TIMEOUT"
    )
    rate_max: float = param(
        180.0, unit="deg/s", low=10.0, high=2000.0, doc="A report that turns faster is ignored.", mav="RATE_MAX"
    )


class AttitudeMemory(NamedTuple):
    """Angles and smoothed rates at the time of validity `t` of the last good report, and the report itself."""

    t: float
    phi: float
    theta: float
    psi: float
    p: float
    q: float
    r: float
    report: Ahrs


START = AttitudeMemory(-math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


def update(params: AttitudeParams, memory: AttitudeMemory, heard: Heard[Ahrs], t: float) -> AttitudeMemory:
    """Takes one report in, if it is good and new; t is the time now, s."""
    if not is_fresh(heard, memory.t, t):
        return memory
    now = heard.value
    phi, theta, psi, p, q, r = now
    if not (math.isfinite(phi) and math.isfinite(psi) and abs(theta) <= math.pi / 2):
        return memory
    if not (abs(p) <= params.rate_max and abs(q) <= params.rate_max and abs(r) <= params.rate_max):
        return memory
    dt = heard.t_valid - memory.t
    if dt > params.timeout or math.cos(theta) < _VERTICAL or math.cos(memory.theta) < _VERTICAL:
        return AttitudeMemory(heard.t_valid, wrap(phi), theta, wrap(psi), p, q, r, now)

    was = memory.report
    phi_dot, theta_dot, psi_dot = euler_rates(
        memory.phi, memory.theta, 0.5 * (was.p + p), 0.5 * (was.q + q), 0.5 * (was.r + r)
    )
    phi_hat = memory.phi + phi_dot * dt
    theta_hat = memory.theta + theta_dot * dt
    psi_hat = memory.psi + psi_dot * dt
    gain = dt / (params.tau + dt)
    smooth = dt / (params.tau_rate + dt)
    return AttitudeMemory(
        heard.t_valid,
        wrap(phi_hat + gain * wrap(phi - phi_hat)),
        theta_hat + gain * (theta - theta_hat),
        wrap(psi_hat + gain * wrap(psi - psi_hat)),
        memory.p + smooth * (p - memory.p),
        memory.q + smooth * (q - memory.q),
        memory.r + smooth * (r - memory.r),
        now,
    )


def angles(params: AttitudeParams, memory: AttitudeMemory, t: float) -> tuple[float, float, float]:
    """(phi, theta, psi) at the time t, carried on with the last rates for at most the time-out, rad."""
    age = min(t - memory.t, params.timeout)
    phi_dot, theta_dot, psi_dot = euler_rates(memory.phi, memory.theta, memory.p, memory.q, memory.r)
    return (
        wrap(memory.phi + phi_dot * age),
        clip(memory.theta + theta_dot * age, -math.pi / 2, math.pi / 2),
        wrap(memory.psi + psi_dot * age),
    )
