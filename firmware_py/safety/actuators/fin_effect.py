"""What one step shows of an axis, and what the fins that act on it should make of their angles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from firmware_py.safety.actuators.fin_angles import Told
from firmware_py.safety.actuators.water_speed import WaterSpeed


class Seen(NamedTuple):
    """What one step shows of an axis.

    Attributes:
        t: when, s.
        u: speed to which fins are held, m/s.
        cross: that across the hull, m/s, known by the DVL if `water` is.
        rate: mean rate of turn, rad/s.
        told: where its fins were.
        water: what speed and current may be.
    """

    t: float
    u: float
    cross: float
    rate: float
    told: Told
    water: tuple[WaterSpeed, ...]


class FinEffect:
    """The fins of one axis: `shares` of all fins in it, the others 0, and how far each can turn, rad."""

    def __init__(self, shares: Sequence[float], travel: Sequence[float]) -> None:
        self._fins = [(share, most) for share, most in zip(shares, travel, strict=True) if share]

    def of(self, control: float, angles: Sequence[float]) -> tuple[list[float], float, float]:
        """Return the angular accelerations at 1 m/s that 1 rad of each fin makes and that `angles` make, rad/s^2.

        The third is what the latter are of the most that the fins could make. `control` is that of 1 rad of all.
        """
        units = [control * share for share, _ in self._fins]
        total = sum([unit * angle for unit, angle in zip(units, angles, strict=True)])
        most = sum([abs(unit) * travel for unit, (_, travel) in zip(units, self._fins, strict=True)])
        return units, total, abs(total) / most if most else math.inf  # opposed to each other they hold against nothing
