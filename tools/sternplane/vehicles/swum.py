"""The simulated vehicle swum under held fins: its steady speed, its turning circle, its pitch after a step."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from firmware_py.marine import Eta, Nu
from sim_bridge.plant.truth import Truth
from sternplane.logs.tracking import Array
from sternplane.sitl.busless_flight import BuslessFlight, Hold, Start, fly, held_level

DEPTH = 500.0
"""m: far from the surface."""
_TICK = 0.01


class Turn(NamedTuple):
    """A steady turn under a held rudder.

    Attributes:
        radius: m; infinite where it goes straight.
        rate: of the heading, rad/s, to starboard positive.
        speed: m/s.
        roll: rad.
        drift: angle between course and heading, rad.
        track: (K, 2) north and east, m, from where the rudder was put over.
        diverged: it did not come to a steady turn.
    """

    radius: float
    rate: float
    speed: float
    roll: float
    drift: float
    track: Array
    diverged: bool


def swum(
    truth: Truth, delta_s: float, delta_r: float, n: float, seconds: float, u: float, hold: Hold | None = None
) -> BuslessFlight:
    """Return the motion under held angles, rad, and shaft speed, rev/s, from speed u, m/s; a `hold` steers beside them.

    Raises:
        PlantError: the plant's state has left the numbers.
    """
    h = _TICK / truth.substeps
    demands = np.tile([delta_s, delta_r], (math.ceil(seconds / h), 1))
    start = Start(Eta(0.0, 0.0, DEPTH, 0.0, 0.0, 0.0), Nu(u, 0.0, 0.0, 0.0, 0.0, 0.0), n)
    return fly(truth, demands, n, h, start=start, hold=hold)


def neutral(truth: Truth) -> Truth:
    """Return the same vehicle with its buoyancy made equal to its weight."""
    return dataclasses.replace(truth, body=dataclasses.replace(truth.body, B=truth.body.W))


def held_straight(eta: Eta, nu: Nu) -> tuple[float, float]:
    """Return stern planes and rudder, rad, that hold depth, pitch and heading softly: a hull may turn by itself."""
    return held_level(DEPTH)(eta, nu)[0], 0.3 * (eta.psi + nu.r)


def steady_speed(truth: Truth, n: float, u: float) -> float:
    """Return the speed that a shaft speed (rev/s) leads to, m/s; begins at u."""
    seconds = max(20.0, 30.0 * truth.hull.L / max(u, 0.1))
    return float(swum(neutral(truth), 0.0, 0.0, n, seconds, u, held_straight).x[-1, 0])


def steady_turn(truth: Truth, delta_r: float, n: float, u: float) -> Turn:
    """Return the steady turn under a rudder, rad, from a straight course at speed u, m/s."""
    seconds = max(40.0, 60.0 * truth.hull.L / max(u, 0.1))
    flight = swum(truth, 0.0, delta_r, n, seconds, u, held_level(DEPTH))
    last, before = flight.x[-len(flight.x) // 8 :], flight.x[-len(flight.x) // 4 : -len(flight.x) // 8]
    v_u, v_v, rate = (float(last[:, i].mean()) for i in (0, 1, 5))
    speed = math.hypot(v_u, v_v)
    steady = abs(rate - float(before[:, 5].mean())) < 0.05 * abs(rate) + 1e-4
    radius = speed / abs(rate) if abs(rate) > 1e-6 else math.inf
    roll = float(np.abs(last[:, 6]).max())
    return Turn(radius, rate, speed, roll, math.atan2(v_v, v_u), flight.eta[:, :2], not (steady and v_u > 0.0))


def pitch_step(truth: Truth, delta_s: float, n: float, u: float, seconds: float) -> BuslessFlight:
    """Return the motion after a step of the stern planes, rad, that nothing else holds."""
    return swum(truth, delta_s, 0.0, n, seconds, u)
