"""Where sensors sit: brings what they measure there to the body's origin, before anybody looks at it.

A DVL at r sees omega x r besides the velocity of the origin, a pressure sensor or an echo sounder is deeper than it by
the third row of R r, an antenna north and east of it by the first two (Fossen 2011, Sec. 11.1).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from firmware_py.estimation.freshness import is_fresh
from firmware_py.estimation.navigation.navigation import PITCHED
from firmware_py.marine import GRAVITY, Origin, body_to_ned, local_to_geodetic
from firmware_py.records.sensing import Ahrs, Dvl, Fix, Heard, SensorFrame
from firmware_py.vehicle.vehicle import Place, SensorPlaces, Vehicle

T = TypeVar("T")
_KEPT = 64
"""So many AHRS reports are kept: a ping is 0.1 s late, and 64 reports at 100 Hz are 0.6 s."""
_RIGHTS = 5.0
"""A hull whose attitude is lost is taken to right itself with this time constant, s. At once would be a step of the
depth by a port in the bow, of which a sound pressure sensor would be accused."""
_SEEN = 2.0
"""What DVL and altimeter measured in so many s tells that they are in the water."""

_ORIGIN: Place = (0.0, 0.0, 0.0)
_LEVEL = Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

LeverArmsMemory = tuple[tuple[float, Ahrs], ...]
"""The last believed AHRS reports with their times of validity, s."""


class LeverArms:
    """Brings frames to the origin; where every sensor sits there, they are left as they are."""

    def __init__(self, vehicle: Vehicle, timeout: float) -> None:
        """Take the places of the vehicle's sensors; an attitude that is older than `timeout`, s, is lost."""
        self._places, self._density, self._timeout = vehicle.sensors, vehicle.hull.density, timeout
        self._none = vehicle.sensors == SensorPlaces()
        ports = (vehicle.sensors.pressure, *vehicle.sensors.spare_pressure)
        self._reach = max([math.hypot(x, y) for x, y, _ in ports])
        self._reports: list[tuple[float, Ahrs]] = []

    def at_origin(self, frame: SensorFrame) -> SensorFrame:
        """Return the frame as sensors at the origin would have measured it at the times of validity."""
        if self._none:
            return frame
        places = self._places
        return replace(
            frame,
            dvl=self._ping(frame.dvl, places.dvl),
            pressure=self._pressure(frame.pressure, places.pressure),
            altitude=self._echo(frame.altitude, places.altimeter),
            fix=self._fix(frame.fix, places.fix),
            spare_dvl=_each(self._ping, frame.spare_dvl, places.spare_dvl),
            spare_pressure=_each(self._pressure, frame.spare_pressure, places.spare_pressure),
            spare_altitude=_each(self._echo, frame.spare_altitude, places.spare_altimeter),
            spare_fix=_each(self._fix, frame.spare_fix, places.spare_fix),
        )

    def hear(self, ahrs: Heard[Ahrs], t: float) -> None:
        """Take the attitude that is believed at the time t, s, or what stands in for it; for the frames that follow."""
        if self._none:
            return
        reports = self._reports
        if is_fresh(ahrs, reports[-1][0] if reports else -math.inf, t) and sum(ahrs.value) * 0.0 == 0.0:
            reports.append((ahrs.t_valid, ahrs.value))
            del reports[:-_KEPT]

    def in_air(self, heard: SensorFrame, placed: SensorFrame, t: float) -> SensorFrame:
        """Return the frame `heard` with what pressure sensors show, or would show, in air, if it is at the surface.

        On deck it is what they show. Afloat, where DVL or altimeter see a bottom at t, s, it is what they would show
        at the origin, as they are in the frame `placed`; but a port above it may be dry.
        """
        if self._none or not _in_water(heard, t):
            return heard
        pairs = zip(heard.spare_pressure, placed.spare_pressure, strict=True)
        spares = tuple([_lesser(one, other) for one, other in pairs])
        return replace(heard, pressure=_lesser(heard.pressure, placed.pressure), spare_pressure=spares)

    def depth_std(self, t: float) -> float:
        """Return 1 sigma of what an attitude that is lost at t, s, makes of the depth by a port off the origin, m."""
        if self._reach == 0.0 or (self._reports and t - self._reports[-1][0] <= self._timeout):
            return 0.0
        return PITCHED * self._reach

    def freeze(self) -> LeverArmsMemory:
        """Return the whole memory."""
        return tuple(self._reports)

    def thaw(self, memory: LeverArmsMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._reports = list(memory)

    def _attitude(self, t: float) -> Ahrs:
        """Return the report whose time of validity is the last one not after t, s, else the oldest.

        Past the time-out nothing turns the hull, and it rights itself.
        """
        first = self._reports[0] if self._reports else (-math.inf, _LEVEL)
        then, report = next((one for one in reversed(self._reports) if one[0] <= t), first)
        lost = t - then - self._timeout
        if not lost > 0.0:
            return report
        left = math.exp(-lost / _RIGHTS)
        return Ahrs(left * report.phi, left * report.theta, report.psi, 0.0, 0.0, 0.0)

    def _offset(self, place: Place, t: float) -> tuple[float, float, float]:
        """Return where a place in the body lies, north, east and down of the origin, m."""
        phi, theta, psi, *_ = self._attitude(t)
        return body_to_ned(phi, theta, psi, *place)

    def _ping(self, heard: Heard[Dvl], place: Place) -> Heard[Dvl]:
        x, y, z = place
        if x == y == z == 0.0:
            return heard
        u, v, w, fom, altitude = heard.value
        _, _, _, p, q, r = self._attitude(heard.t_valid)
        there = self._offset(place, heard.t_valid)
        ping = Dvl(u - (q * z - r * y), v - (r * x - p * z), w - (p * y - q * x), fom, altitude + there[2])
        return replace(heard, value=ping)

    def _pressure(self, heard: Heard[float], place: Place) -> Heard[float]:
        if place == _ORIGIN:
            return heard
        _, _, deeper = self._offset(place, heard.t_valid)
        return replace(heard, value=heard.value - deeper * self._density * GRAVITY)

    def _echo(self, heard: Heard[float], place: Place) -> Heard[float]:
        if place == _ORIGIN or not heard.value > 0.0:  # 0: too near
            return heard
        return replace(heard, value=heard.value + self._offset(place, heard.t_valid)[2])

    def _fix(self, heard: Heard[Fix], place: Place) -> Heard[Fix]:
        latitude, longitude, std = heard.value
        if place == _ORIGIN or not (heard.ok and abs(latitude) < 1.5):
            return heard
        north, east, _ = self._offset(place, heard.t_valid)
        return replace(heard, value=Fix(*local_to_geodetic(Origin(latitude, longitude), -north, -east), std))


def _in_water(frame: SensorFrame, t: float) -> bool:
    """Return whether something tells that the vehicle is in the water at t, s: in air nothing sees a bottom."""
    dvl, altitude = frame.dvl, frame.altitude
    pinged = dvl.usable(t, _SEEN) and math.isfinite(dvl.value.u)
    return pinged or (altitude.usable(t, _SEEN) and altitude.value > 0.0)


def _lesser(one: Heard[float], other: Heard[float]) -> Heard[float]:
    return other if other.value < one.value else one


def _each(
    bring: Callable[[Heard[T], Place], Heard[T]], heard: tuple[Heard[T], ...], places: tuple[Place, ...]
) -> tuple[Heard[T], ...]:
    """Bring what further devices measure to the origin; those without a place sit there."""
    at = (*places, *(_ORIGIN,) * len(heard))
    return tuple([bring(one, place) for one, place in zip(heard, at, strict=False)]) if places else heard
