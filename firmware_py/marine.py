"""Marine kinematics: angles, frames, water pressure, and the SNAME vectors eta and nu (Fossen 2011, ch. 2)."""

from __future__ import annotations

import math
from typing import NamedTuple

GRAVITY = 9.80665
"""Standard gravity, m/s^2."""
EARTH_RADIUS = 6_378_137.0
"""WGS-84 equatorial radius, m."""
EARTH_FLATTENING = 1.0 / 298.257223563
"""WGS-84 flattening."""
EDDY_TIME = 10.0
"""Correlation time of eddies, s."""
_COS_THETA_MIN = 0.01
"""Least size of cos(theta) in the Euler rates, which are singular at theta = 90 deg."""


class Eta(NamedTuple):
    """Position (m, NED, z down) and Euler angles (rad, zyx) of the vehicle in the local frame."""

    x: float
    y: float
    z: float
    phi: float
    theta: float
    psi: float


class Nu(NamedTuple):
    """Body-fixed velocity: surge, sway, heave (m/s); roll, pitch, yaw rate (rad/s)."""

    u: float
    v: float
    w: float
    p: float
    q: float
    r: float


class Origin(NamedTuple):
    """Origin of the local frame: latitude and longitude, rad."""

    latitude: float
    longitude: float


NULL_ISLAND = Origin(0.0, 0.0)
"""A place before one is known."""


def wrap(angle: float) -> float:
    """Return the equal angle in [-pi, pi), rad."""
    return (angle + math.pi) % math.tau - math.pi


def clip(value: float, low: float, high: float) -> float:
    """Return `value` limited to [low, high]; NaN stays NaN."""
    return low if value < low else high if value > high else value


INERTIA_IMPOSSIBLE = (
    "no body has these moments and products of inertia: each moment must be less than the two others together"
)


def is_inertia_tensor(x: float, y: float, z: float, xy: float, yz: float, xz: float) -> bool:
    """Return whether a rigid body can have these moments and products of inertia, kg m^2.

    The matrix of its second moments of mass, the integrals of x x, x y and so on, must be positive definite
    (Sylvester's criterion). This is stricter than a positive definite inertia matrix, by the triangle inequalities.
    """
    a, b, c = 0.5 * (y + z - x), 0.5 * (x + z - y), 0.5 * (x + y - z)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    return a > 0.0 and a * b > xy * xy and determinant > 0.0


def body_to_ned(phi: float, theta: float, psi: float, u: float, v: float, w: float) -> tuple[float, float, float]:
    """Return R_zyx(phi, theta, psi) [u v w]': a body-fixed vector in NED (Fossen 2011, Eq. 2.18)."""
    c_phi, s_phi = math.cos(phi), math.sin(phi)
    c_theta, s_theta = math.cos(theta), math.sin(theta)
    c_psi, s_psi = math.cos(psi), math.sin(psi)
    a = v * s_phi + w * c_phi
    b = v * c_phi - w * s_phi
    forward = u * c_theta + a * s_theta
    return forward * c_psi - b * s_psi, forward * s_psi + b * c_psi, -u * s_theta + a * c_theta


def ned_to_body(phi: float, theta: float, psi: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return R_zyx(phi, theta, psi)' [x y z]': an NED vector in body axes; the inverse of `body_to_ned`."""
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    forward, right, down = (body_to_ned(phi, theta, psi, *axis) for axis in axes)
    return (
        forward[0] * x + forward[1] * y + forward[2] * z,
        right[0] * x + right[1] * y + right[2] * z,
        down[0] * x + down[1] * y + down[2] * z,
    )


def euler_rates(phi: float, theta: float, p: float, q: float, r: float) -> tuple[float, float, float]:
    """Return (phi_dot, theta_dot, psi_dot), rad/s, from body rates (Fossen 2011, Eq. 2.28).

    |cos(theta)| is kept at _COS_THETA_MIN or above, so that the rates stay finite near theta = 90 deg.
    """
    c_theta = math.cos(theta)
    if abs(c_theta) < _COS_THETA_MIN:
        c_theta = math.copysign(_COS_THETA_MIN, c_theta)
    lateral = q * math.sin(phi) + r * math.cos(phi)
    psi_dot = lateral / c_theta
    return p + psi_dot * math.sin(theta), q * math.cos(phi) - r * math.sin(phi), psi_dot


def quaternion_from_euler(phi: float, theta: float, psi: float) -> tuple[float, float, float, float]:
    """Return the unit quaternion (x, y, z, w), body to NED; w is last, as in DroneCAN."""
    c1, s1 = math.cos(phi / 2), math.sin(phi / 2)
    c2, s2 = math.cos(theta / 2), math.sin(theta / 2)
    c3, s3 = math.cos(psi / 2), math.sin(psi / 2)
    return (
        s1 * c2 * c3 - c1 * s2 * s3,
        c1 * s2 * c3 + s1 * c2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
        c1 * c2 * c3 + s1 * s2 * s3,
    )


def euler_from_quaternion(x: float, y: float, z: float, w: float) -> tuple[float, float, float]:
    """Return (phi, theta, psi), rad, of a quaternion (x, y, z, w) of any positive length; NaN if it has no length."""
    norm = x * x + y * y + z * z + w * w
    if not norm > 0.0:
        return math.nan, math.nan, math.nan
    phi = math.atan2(2.0 * (w * x + y * z), norm - 2.0 * (x * x + y * y))
    theta = math.asin(clip(2.0 * (w * y - z * x) / norm, -1.0, 1.0))
    psi = math.atan2(2.0 * (w * z + x * y), norm - 2.0 * (y * y + z * z))
    return phi, theta, psi


def _curvature_radii(latitude: float) -> tuple[float, float]:
    """Return the radii of curvature along the meridian and across it (prime vertical), m."""
    e2 = EARTH_FLATTENING * (2.0 - EARTH_FLATTENING)
    d = 1.0 - e2 * math.sin(latitude) ** 2
    across = EARTH_RADIUS / math.sqrt(d)
    return across * (1.0 - e2) / d, across


def geodetic_to_local(origin: Origin, latitude: float, longitude: float) -> tuple[float, float]:
    """Return (x, y), m north and east of the origin, in the plane tangent there."""
    meridian, across = _curvature_radii(origin.latitude)
    return (
        (latitude - origin.latitude) * meridian,
        wrap(longitude - origin.longitude) * across * math.cos(origin.latitude),
    )


def local_to_geodetic(origin: Origin, x: float, y: float) -> tuple[float, float]:
    """Return (latitude, longitude), rad: the inverse of `geodetic_to_local`."""
    meridian, across = _curvature_radii(origin.latitude)
    return origin.latitude + x / meridian, wrap(origin.longitude + y / (across * math.cos(origin.latitude)))


def depth_of_pressure(pressure: float, surface_pressure: float, density: float) -> float:
    """Return the depth, m, at an absolute pressure, Pa, in water of constant density, kg/m^3."""
    return (pressure - surface_pressure) / (density * GRAVITY)


def pressure_of_depth(depth: float, surface_pressure: float, density: float) -> float:
    """Return the absolute pressure, Pa, at a depth, m; above the water that of the surface."""
    return surface_pressure + max(depth, 0.0) * density * GRAVITY
