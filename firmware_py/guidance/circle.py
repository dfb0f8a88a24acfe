"""A circle around a place: what a fin vehicle does that is to stay somewhere, since it cannot stand.

The circle is given to the line of sight as the leg that touches it where the boat is, with the boat's distance from
it, so far away the boat steers for the centre, and near it joins the circle. The tangent turns while the boat goes on:
the heading reference, which comes a `lag` later, is told so beforehand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.guidance.line_of_sight import Leg


class Circle(NamedTuple):
    """Centre, m, and radius, m: positive to be turned to starboard, negative to port."""

    x: float
    y: float
    radius: float


class Tangent(NamedTuple):
    """The leg that touches the circle abeam of the boat, and how far the heading shall be ahead of it, rad."""

    way: Leg
    ahead: float


def circle_through(x: float, y: float, psi: float, radius: float) -> Circle:
    """The circle on which a boat at (x, y), m, is that goes along psi, rad."""
    return Circle(x - radius * math.sin(psi), y + radius * math.cos(psi), radius)


def tangent(circle: Circle, x: float, y: float, lag: float) -> Tangent:
    """The circle as it looks from (x, y), m; what is asked of the heading comes `lag`, m, later.

    `across` of the leg is positive to starboard of the circle's way. Off the circle the turn ahead fades out: whoever
    steers for the centre goes straight.
    """
    dx, dy = x - circle.x, y - circle.y
    radius, side = abs(circle.radius), math.copysign(1.0, circle.radius)
    off = math.hypot(dx, dy) - radius
    course = math.atan2(dy, dx) + side * 0.5 * math.pi
    ahead = lag / radius * max(0.0, 1.0 - abs(off) / radius)
    return Tangent(Leg(math.inf, course, 0.0, -side * off, abs(off)), side * ahead)
