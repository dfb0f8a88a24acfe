"""Circles around a position: a fin vehicle cannot stand still.

Line of sight gets a circle as the leg that touches it abeam of the vehicle, and the distance from it as cross-track
error: far away the vehicle steers for the centre, near the circle it joins it. The tangent turns while the vehicle
moves on, so the heading is led by the `lag` of its reference model.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.line_of_sight import Leg


class Circle(NamedTuple):
    """Centre, m, and radius, m: positive to turn to starboard, negative to port."""

    x: float
    y: float
    radius: float


class Tangent(NamedTuple):
    """The leg that touches the circle abeam of the vehicle, and the lead of the heading, rad."""

    way: Leg
    ahead: float


def circle_through(x: float, y: float, psi: float, radius: float) -> Circle:
    """Return the circle of a vehicle at (x, y), m, with heading psi, rad."""
    return Circle(x - radius * math.sin(psi), y + radius * math.cos(psi), radius)


def tangent(circle: Circle, x: float, y: float, lag: float) -> Tangent:
    """Return the tangent for a vehicle at (x, y), m, whose heading lags by the distance `lag`, m.

    `across` of the leg is positive to starboard. Off the circle the lead fades out: towards the centre the vehicle
    goes straight.
    """
    dx, dy = x - circle.x, y - circle.y
    radius, side = abs(circle.radius), math.copysign(1.0, circle.radius)
    off = math.hypot(dx, dy) - radius
    course = math.atan2(dy, dx) + side * 0.5 * math.pi
    ahead = lag / radius * max(0.0, 1.0 - abs(off) / radius)
    return Tangent(Leg(math.inf, course, 0.0, -side * off, abs(off)), side * ahead)
