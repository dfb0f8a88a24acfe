"""The plant flown without a bus: fin demands in; true motion, true inputs and measurements out."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_py.marine import Eta, Nu, clip
from firmware_py.run.usage_error import UsageError
from sim_bridge.plant.environment import Environment, EnvironmentParams
from sim_bridge.plant.packing import S
from sim_bridge.plant.plant import Plant
from sim_bridge.plant.truth import Truth
from sternplane.logs.tracking import Array

Hold = Callable[[Eta, Nu], tuple[float, float]]
Current = tuple[float, float, float]
"""What is added to the demands (delta_s, delta_r), rad, at a true state."""

N_TRIM = 500.0 / 60.0
"""Shaft speed, rev/s, at which NPS AUV II trims at `U_TRIM`."""
U_TRIM = 1.8288
"""m/s."""
DVL, GYRO = 0.01, math.radians(0.05)
"""Noise, 1 sigma: m/s, rad/s."""
SENSOR_STD = np.array([DVL] * 3 + [GYRO] * 3 + [math.radians(0.3)] * 2 + [math.radians(0.5)])
"""Noise of u v w p q r phi theta psi, 1 sigma: a DVL's and an AHRS's."""
_PARTS = 4
"""Steps of the plant within one of ours, where the fins lag: so finely their mean is taken."""


class Start(NamedTuple):
    """Where a trial begins: position and attitude, velocity over ground, shaft speed (rev/s)."""

    eta: Eta = Eta(0.0, 0.0, 100.0, 0.0, 0.0, 0.0)
    nu: Nu = Nu(U_TRIM, 0.0, 0.0, 0.0, 0.0, 0.0)
    n: float = N_TRIM


class BuslessFlight(NamedTuple):
    """What was really the case at t_k = k h, and in the K steps between."""

    t: Array
    """(K + 1,), s."""
    x: Array
    """(K + 1, 9): u v w p q r over ground, phi theta psi; psi in [-pi, pi]."""
    eta: Array
    """(K + 1, 6): position and attitude, NED."""
    inputs: Array
    """(K, 4): delta_s, delta_r, delta_b (rad), n (rev/s): means over each step of what fins and shaft really did."""
    water: Array
    """(K, 3): velocity of the water in each step, NED, m/s."""


class _Ideal(Plant):
    """A plant whose fins and shaft stand at their commands from the first moment of a step."""

    def step(self, fins: Sequence[float], n: float) -> None:
        self._state[S.n :] = (n, *fins, *fins)
        super().step(fins, n)


def fly(
    truth: Truth,
    demands: Array,
    n: float,
    h: float,
    seed: int = 0,
    current: Current | Callable[[float], Current] = (0.0, 0.0, 0.0),
    turbulence: float = 0.0,
    start: Start | None = None,
    ideal_fins: bool = True,
    hold: Hold | None = None,
) -> BuslessFlight:
    """Flies the plant for one step per row of `demands`.

    Args:
        truth: the plant; its own hydrodynamics, nothing of the observer's.
        demands: (K, 2): delta_s, delta_r, rad, each held for a step and kept within the servos' travel.
        n: shaft speed asked for, rev/s.
        h: step, s.
        seed: of the turbulence.
        current: NED, m/s; or a function of the time, s, that returns it.
        turbulence: 1 sigma on each axis, m/s; it is held within a (sub)step of the plant.
        start: where it begins, None being 100 m deep in trim.
        ideal_fins: fins and shaft at the demand at once; else with the lag, rate and play of the truth's servos.
        hold: a feedback from the true state, added to the demands.

    Raises:
        PlantError: the plant's state has left the numbers.
    """
    parts = 1 if ideal_fins else _PARTS
    first = current(0.0) if callable(current) else current
    sea = Environment(EnvironmentParams(first, turbulence), np.random.SeedSequence([seed, *b"trial"]), h / parts)
    begin = start or Start()
    plant = (_Ideal if ideal_fins else Plant)(truth, sea, h / parts, 1, begin.eta, begin.nu, begin.n)
    shares = np.array([fin.share for fin in truth.fins])
    to_fins, limit, steps = np.linalg.pinv(shares.T)[:, :2].tolist(), truth.servo.limit, len(demands)
    motion, acts, flow = [(*plant.nu, *plant.eta)], [(*plant.fins, plant.n)], []
    for k, (delta_s, delta_r) in enumerate(demands.tolist()):
        if callable(current):
            sea.mean = current(k * h)
        if hold is not None:
            more_s, more_r = hold(plant.eta, plant.nu)
            delta_s, delta_r = delta_s + more_s, delta_r + more_r
        fins = [clip(s * delta_s + r * delta_r, -limit, limit) for s, r in to_fins]
        for _ in range(parts):
            plant.step(fins, n)
            acts.append((*plant.fins, plant.n))
            flow.append(plant.current_ned)
        motion.append((*plant.nu, *plant.eta))
    held, moved = np.array(acts), np.array(motion)
    mean = held[1:] if ideal_fins else 0.5 * (held[:-1] + held[1:])
    mean = mean.reshape(steps, parts, len(to_fins) + 1).mean(axis=1)
    return BuslessFlight(
        h * np.arange(steps + 1),
        moved[:, [0, 1, 2, 3, 4, 5, 9, 10, 11]],
        moved[:, 6:],
        np.column_stack([mean[:, :-1] @ shares, mean[:, -1]]),
        np.array(flow).reshape(steps, parts, 3).mean(axis=1),
    )


def held_level(depth: float = 100.0, gain: float = 0.3, pitch_max: float = math.radians(15.0)) -> Hold:
    """Stern planes that hold depth and pitch softly under an excitation: a long run stays upright and in the sea.

    Args:
        depth: where to stay about, m.
        gain: stern plane per pitch error, rad per rad.
        pitch_max: the pitch asked for is 0.02 rad per metre of depth error, at most this, rad.
    """

    def hold(eta: Eta, nu: Nu) -> tuple[float, float]:
        theta_d = clip(0.02 * (eta.z - depth), -pitch_max, pitch_max)
        return gain * (eta.theta - theta_d + nu.q), 0.0

    return hold


def decimation(rate: float, h: float) -> int:
    """Every how many steps of h (s) a sensor of that rate (Hz) measures.

    Raises:
        UsageError: it does not measure at the end of steps.
    """
    steps = 1.0 / (rate * h)
    if not math.isfinite(steps) or round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
        raise UsageError(f"a sensor of {rate:g} Hz does not fit steps of {h:g} s; give a rate that divides {1 / h:g}")
    return round(steps)


def measurement_mask(steps: int, h: float, rates: Sequence[float]) -> NDArray[np.bool_]:
    """(K, 9): which of u v w p q r phi theta psi come at the end of each step; a rate (Hz) of 0 is never."""
    came = np.zeros((steps, 9), dtype=np.bool_)
    for i, rate in enumerate(rates):
        if rate:
            every = decimation(rate, h)
            came[every - 1 :: every, i] = True
    return came


def measure(trial: BuslessFlight, std: Array, rates: Sequence[float], seed: int) -> Array:
    """z (K, 9): what sensors say at the end of each step; NaN where nothing came.

    Args:
        trial: what was really the case.
        std: (9,) white noise, 1 sigma.
        rates: (9,) Hz; 0 is never.
        seed: of the noise.

    Raises:
        UsageError: a rate that does not divide the trial's.
    """
    steps = len(trial.inputs)
    noise = np.random.default_rng([seed, *b"measure"]).standard_normal((steps, 9))
    z = trial.x[1:] + noise * std
    z[:, 8] = (z[:, 8] + math.pi) % math.tau - math.pi
    return np.where(measurement_mask(steps, trial.t[1] - trial.t[0], rates), z, np.nan)


def scaled_truth(truth: Truth, factors: dict[str, float]) -> Truth:
    """Return the plant with coefficients (C_d0, C_dy, C_dz among them) multiplied by factors."""
    hull = {name: getattr(truth.hull, name) * factors[name] for name in ("C_dy", "C_dz") if name in factors}
    screw = {name: truth.propeller.C_d0 * factors[name] for name in ("C_d0",) if name in factors}
    c = {k: getattr(truth.coefficients, k) * f for k, f in factors.items() if k not in (*hull, *screw)}
    return dataclasses.replace(
        truth,
        hull=dataclasses.replace(truth.hull, **hull),
        propeller=dataclasses.replace(truth.propeller, **screw),
        coefficients=dataclasses.replace(truth.coefficients, **c),
    )
