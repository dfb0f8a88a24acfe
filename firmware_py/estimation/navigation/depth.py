"""Depth: the pressure, carried from one reading to the next by the vertical velocity.

A first-order complementary filter: noise of readings that arrive every T is reduced by sqrt(T / 2 tau), and an error e
of the vertical velocity stays as e tau.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from firmware_py.estimation.freshness import is_fresh
from firmware_py.marine import depth_of_pressure
from firmware_py.params import TakesEffect, param
from firmware_py.records.sensing import Heard

_LOWEST = -5.0
"""A reading that stands for less than this depth, m, is no air pressure at sea."""


@dataclass(frozen=True)
class DepthParams:
    """Water, air, and the filter."""

    density: float = param(
        1000.0,
        unit="kg/m^3",
        low=900.0,
        high=1100.0,
        doc="Density of the water.",
        mav="DENSITY",
        when=TakesEffect.DISARMED,
    )
    surface_pressure: float = param(
        101325.0,
        unit="Pa",
        low=5e4,
        high=1.1e5,
        doc="Air pressure at the surface.",
        mav="P_SURF",
        when=TakesEffect.DISARMED,
    )
    zero_window: float = param(
        2000.0,
        unit="Pa",
        low=0.0,
        high=1e4,
        doc="Until first armed, a reading so near is taken for the air; 0 never.",
        mav="P_ZERO",
    )
    tau_zero: float = param(
        1.0,
        unit="s",
        low=0.1,
        high=60.0,
        doc="Time constant of the zero that is taken from the air until first armed.",
        mav="TAU_ZERO",
    )
    tau: float = param(
        0.3, unit="s", low=0.0, high=10.0, doc="Time constant with which pressure corrects the depth.", mav="TAU"
    )
    timeout: float = param(
        1.0, unit="s", low=0.1, high=10.0, doc="Depth is lost when not heard for so long.", mav="TIMEOUT"
    )
    std: float = param(
        0.03, unit="m", low=1e-3, high=5.0, doc="1 sigma of the depth while pressure is heard.", mav="STD"
    )
    lost_std: float = param(
        0.05, unit="m/s", low=0.0, high=1.0, doc="Growth of that sigma without pressure.", mav="LOST_STD"
    )
    range: float = param(
        500.0, unit="m", low=1.0, high=12000.0, doc="A reading deeper than this is ignored.", mav="RANGE"
    )


class DepthMemory(NamedTuple):
    """Depth z now, time of validity `t` of the last good reading, the zero (Pa), and whether it may still move.

    `drift`, m, is what its 1 sigma has grown by since then beside `lost_std`.
    """

    t: float
    z: float
    zero: float
    zeroing: bool
    drift: float = 0.0


def start(params: DepthParams) -> DepthMemory:
    """The memory of a vehicle that has heard no pressure."""
    return DepthMemory(-math.inf, 0.0, params.surface_pressure, params.zero_window > 0.0)


def update(
    params: DepthParams,
    memory: DepthMemory,
    heard: Heard[float],
    t: float,
    dt: float,
    z_dot: float,
    z_dot_std: float,
    armed: bool,
    port: float = 0.0,
) -> DepthMemory:
    """One tick of dt, s, at the vertical velocity z_dot, m/s; its 1 sigma is z_dot_std more than `lost_std`.

    The zero rests once the vehicle has been armed: from then on it may float awash, which reads like weather. It is
    that of the port: what was taken off its reading for where it sits, which air has not, is `port`, Pa.
    """
    t_last, z, zero, zeroing, drift = memory
    zeroing = zeroing and not armed
    z += z_dot * dt
    if is_fresh(heard, t_last, t):
        pressure = heard.value
        if _LOWEST <= depth_of_pressure(pressure, params.surface_pressure, params.density) <= params.range:
            gap = heard.t_valid - t_last
            known = gap <= params.timeout
            air = pressure + port
            if zeroing and abs(air - params.surface_pressure) <= params.zero_window:
                zero += (gap / (params.tau_zero + gap) if known else 1.0) * (air - zero)
            reading = depth_of_pressure(pressure, zero, params.density) + z_dot * (t - heard.t_valid)
            z += (gap / (params.tau + gap) if known else 1.0) * (reading - z)
            t_last, drift = heard.t_valid, 0.0
    if t - t_last > params.timeout:
        z = max(0.0, z)  # it floats; nothing carries it higher
        drift += z_dot_std * dt
    return DepthMemory(t_last, z, zero, zeroing, drift)


def std(params: DepthParams, memory: DepthMemory, t: float, z_dot_std: float = 0.0) -> float:
    """1 sigma of z at the time t, m; without pressure it grows, up to the sensor's range, which it is before any.

    What the vertical velocity is off by, `z_dot_std`, m/s, stays in the depth for the filter's time constant.
    """
    if memory.t == -math.inf:
        return params.range
    lost = max(0.0, t - memory.t - params.timeout)
    return min(math.hypot(params.std, z_dot_std * params.tau, params.lost_std * lost + memory.drift), params.range)
