"""Where sensors sit: brings what they measure there to the body's origin, before anybody looks at it.

A DVL at r sees omega x r besides the velocity of the origin, a pressure sensor or an echo sounder is deeper than it by
the third row of R r, an antenna north and east of it by the first two (Fossen 2011, Sec. 11.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from firmware_py.estimation.freshness import is_fresh
from firmware_py.marine import Origin, body_to_ned, local_to_geodetic, pressure_of_depth
from firmware_py.records.sensing import Ahrs, Dvl, Fix, Heard, SensorFrame
from firmware_py.vehicle.vehicle import Place, SensorPlaces, Vehicle

T = TypeVar("T")
_KEPT = 64
"""So many AHRS reports are kept: a ping is 0.1 s late, and 64 reports at 100 Hz are 0.6 s."""

_ORIGIN: Place = (0.0, 0.0, 0.0)

LeverArmsMemory = tuple[tuple[float, Ahrs], ...]
"""The last AHRS reports with their times of validity, s."""


class LeverArms:
    """Brings frames to the origin; where every sensor sits there, they are left as they are."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._places, self._density = vehicle.sensors, vehicle.hull.density
        self._none = vehicle.sensors == SensorPlaces()
        self._reports: list[tuple[float, Ahrs]] = []

    def at_origin(self, frame: SensorFrame, t: float, ahrs: Heard[Ahrs] | None = None) -> SensorFrame:
        """Return the frame as sensors at the origin would have measured it at the times of validity; t is now, s.

        `ahrs` is the attitude that is believed, of several; None: the first one.
        """
        if self._none:
            return frame
        reports, places, ahrs = self._reports, self._places, ahrs or frame.ahrs
        if is_fresh(ahrs, reports[-1][0] if reports else -1.0, t) and sum(ahrs.value) * 0.0 == 0.0:
            reports.append((ahrs.t_valid, ahrs.value))
            del reports[:-_KEPT]
        if not reports:
            return frame
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

    def freeze(self) -> LeverArmsMemory:
        """Return the whole memory."""
        return tuple(self._reports)

    def thaw(self, memory: LeverArmsMemory) -> None:
        """Restore the memory that `freeze` returned."""
        self._reports = list(memory)

    def _attitude(self, t: float) -> Ahrs:
        """Return the report whose time of validity is the last one not after t, s, else the oldest."""
        for t_valid, report in reversed(self._reports):
            if t_valid <= t:
                return report
        return self._reports[0][1]

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
        return replace(heard, value=heard.value - pressure_of_depth(deeper, 0.0, self._density))

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


def _each(
    bring: Callable[[Heard[T], Place], Heard[T]], heard: tuple[Heard[T], ...], places: tuple[Place, ...]
) -> tuple[Heard[T], ...]:
    """Bring what further devices measure to the origin; those without a place sit there."""
    at = (*places, *(_ORIGIN,) * len(heard))
    return tuple([bring(one, place) for one, place in zip(heard, at, strict=False)]) if places else heard
