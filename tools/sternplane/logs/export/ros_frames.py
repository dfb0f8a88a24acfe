"""From our frames to those of ROS (REP 103): the world from NED to ENU, the body from FRD to FLU.

The world's x becomes north -> east, the body's y starboard -> port. In Euler angles (zyx) that is: roll stays, pitch
changes its sign, and yaw counts from east to the left instead of from north to the right. Depth becomes -z.
"""

from __future__ import annotations

import math

from firmware_py.marine import quaternion_from_euler

WORLD, BODY, TRUE_BODY = "map", "base_link", "base_link_truth"
"""Frames by their names in REP 105; the last is where a simulated vehicle really is."""

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def world_vector(north: float, east: float, down: float) -> Vector:
    """Return a vector in ENU, of NED."""
    return east, north, -down


def body_vector(forward: float, starboard: float, down: float) -> Vector:
    """Return a vector in FLU, of FRD."""
    return forward, -starboard, -down


def orientation(phi: float, theta: float, psi: float) -> Quaternion:
    """Return the unit quaternion (x, y, z, w) from FLU to ENU, of the Euler angles from FRD to NED, rad."""
    return quaternion_from_euler(phi, -theta, 0.5 * math.pi - psi)


def diagonal(*variances: float) -> tuple[float, ...]:
    """Return a covariance, row by row, with these on its diagonal."""
    n = len(variances)
    return tuple([variances[i // n] if i % (n + 1) == 0 else 0.0 for i in range(n * n)])
