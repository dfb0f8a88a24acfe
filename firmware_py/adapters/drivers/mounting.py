"""How an instrument is mounted: turns what it measures in its own axes into the body's.

Where it sits, the lever arm, belongs to the vehicle ([sensors] in vehicle.toml): the core brings what it measures to
the origin, see `estimation/lever_arms.py`. An instrument that sits straight is given as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from firmware_py.adapters.drivers.attitude import product
from firmware_py.adapters.drivers.driver import Reading
from firmware_py.marine import body_to_ned, euler_from_quaternion, quaternion_from_euler, wrap
from firmware_py.params import param
from firmware_py.records.sensing import Ahrs, Dvl, Heard

LEVER_ARMS: Mapping[str, str] = dict.fromkeys(
    ("at", "at_m", "x_m", "y_m", "z_m", "x", "y", "z"),
    "is no key of an io file: lever arms stand in [sensors] of vehicle.toml, as dvl_m, and those of a simulated "
    "vehicle in sensors.toml, as at_m",
)
"""Where lever arms belong, by the keys under which they are looked for beside the mounting."""


@dataclass(frozen=True, slots=True)
class Mounting:
    """The attitude of an instrument in the body, turned yaw first, then pitch, then roll; and what north it knows."""

    ELSEWHERE: ClassVar[Mapping[str, str]] = LEVER_ARMS

    roll: float = param(0.0, unit="deg", low=-180.0, high=180.0, doc="About the body's x axis; 180 is upside down.")
    pitch: float = param(0.0, unit="deg", low=-90.0, high=90.0, doc="Positive where the instrument's x axis looks up.")
    yaw: float = param(0.0, unit="deg", low=-180.0, high=180.0, doc="Positive where its x axis looks to starboard.")
    declination: float = param(
        0.0,
        unit="deg",
        low=-180.0,
        high=180.0,
        doc="True less magnetic north, for a compass that knows the magnetic one.",
    )

    def turn(self) -> Callable[[Reading], Reading]:
        """Return what turns the readings of such an instrument: attitude and rates of an AHRS, velocities of a DVL."""
        if self == STRAIGHT:
            return lambda reading: reading
        angles, declination = (self.roll, self.pitch, self.yaw), self.declination
        x, y, z, w = quaternion_from_euler(*angles)

        def ahrs(value: Ahrs) -> Ahrs:
            there = quaternion_from_euler(value.phi, value.theta, value.psi)
            phi, theta, psi = euler_from_quaternion(*product(there, (-x, -y, -z, w)))
            return Ahrs(phi, theta, wrap(psi + declination), *body_to_ned(*angles, value.p, value.q, value.r))

        def dvl(value: Dvl) -> Dvl:
            return Dvl(*body_to_ned(*angles, value.u, value.v, value.w), value.fom, value.altitude)

        by_role: dict[str, Callable[..., object]] = {"ahrs": ahrs, "dvl": dvl}

        def turned(reading: Reading) -> Reading:
            make, heard = by_role.get(reading.role), reading.heard
            if make is None:
                return reading
            return reading._replace(heard=Heard(make(heard.value), heard.t_valid, heard.fresh, heard.ok))

        return turned


STRAIGHT = Mounting()
