"""Servos and shaft. Each step is exact for a held command, so the result does not depend on the substep."""

from __future__ import annotations

import math

from firmware_py.compiled import kernel
from sim_bridge.plant.packing import Array, C, F, S


@kernel("f8(f8,f8,f8,f8,f8)")
def lag(value: float, target: float, tau: float, rate: float, dt: float) -> float:
    """A first-order lag `tau` (s) that moves at most at `rate`: return `value` after `dt` (s).

    Far from the target it slews, within rate * tau of it it decays; both parts in closed form.
    """
    error = target - value
    slewing = (abs(error) - rate * tau) / rate
    if slewing >= dt:
        return value + math.copysign(rate * dt, error)
    if slewing > 0.0:
        error = math.copysign(rate * tau, error)
        dt -= slewing
    return target - error * math.exp(-dt / tau)


@kernel("f8(f8,f8,f8)")
def play(follower: float, leader: float, half: float) -> float:
    """Return the follower of a backlash: it stays until the leader has taken up the play of `half` to either side."""
    return min(max(follower, leader - half), leader + half)


@kernel("void(f8[::1],f8[:,::1],f8[::1],f8[::1],f8)")
def actuate(c: Array, table: Array, command: Array, state: Array, dt: float) -> None:
    """Move shaft, servos and fins in `state` over `dt` (s) towards `command` (fin angles, then n; rad, rev/s).

    A jammed fin stays, with its servo, where it is.
    """
    count = len(table)
    limit = c[C.shaft_limit]
    target = min(max(command[count], -limit), limit)
    state[S.n] = lag(state[S.n], target, c[C.shaft_tau], c[C.shaft_rate], dt)
    servo, fin = len(S), len(S) + count
    limit = c[C.servo_limit]
    for i in range(count):
        if table[i, F.jammed] == 0.0:
            target = min(max(command[i], -limit), limit)
            state[servo + i] = lag(state[servo + i], target, c[C.servo_tau], table[i, F.rate], dt)
            state[fin + i] = play(state[fin + i], state[servo + i], table[i, F.half_play])


@kernel("f8(f8[::1],f8,f8)")
def shaft_acceleration(c: Array, n: float, command: float) -> float:
    """Return n_dot, rev/s^2, of the shaft at speed n under a command (rev/s)."""
    limit, rate = c[C.shaft_limit], c[C.shaft_rate]
    target = min(max(command, -limit), limit)
    n_dot: float = min(max((target - n) / c[C.shaft_tau], -rate), rate)
    return n_dot
