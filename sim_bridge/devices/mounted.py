"""What an instrument measures in its own axes, as it is mounted: the inverse of what its driver does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from firmware_py.adapters.drivers.attitude import product
from firmware_py.adapters.drivers.mounting import STRAIGHT, Mounting
from firmware_py.marine import euler_from_quaternion, ned_to_body, quaternion_from_euler, wrap
from firmware_py.records.sensing import Ahrs, Dvl


def mounted(mounting: Mounting) -> Callable[[Any], Any]:
    """Return what an instrument mounted so makes of a value in the axes of the body; of other roles the same."""
    if mounting == STRAIGHT:
        return lambda value: value
    angles = mounting.roll, mounting.pitch, mounting.yaw
    turn = quaternion_from_euler(*angles)

    def seen(value: Any) -> Any:
        match value:
            case Ahrs(phi, theta, psi, p, q, r):
                body = quaternion_from_euler(phi, theta, psi - mounting.declination)
                phi, theta, psi = euler_from_quaternion(*product(body, turn))
                return Ahrs(phi, theta, wrap(psi), *ned_to_body(*angles, p, q, r))
            case Dvl(u, v, w, fom, altitude):
                return Dvl(*ned_to_body(*angles, u, v, w), fom, altitude)
        return value

    return seen
