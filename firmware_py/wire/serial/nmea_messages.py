"""What sentences of NMEA 0183 mean: one type per meaning. Angles in rad, all else in SI units; NaN is unknown.

Each message names the sentence that it came from. `nmea0183.encode` writes that one, and a driver whose receiver tells
one fix in several sentences believes one of them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

UNKNOWN = -1
"""A whole number that was not told."""
_UNKNOWN = math.nan
_FEWEST = 3
"""Satellites of a position at sea level."""


class Position(NamedTuple):
    """A position (GGA, GNS), with the velocity over ground (RMC).

    Attributes:
        sentence: "GGA", "GNS" or "RMC".
        time: UTC of the fix, s since midnight.
        latitude: positive north.
        longitude: positive east.
        quality: as in GGA: 0 none, 1 autonomous, 2 differential, 3 precise, 4 RTK fixed, 5 RTK float, 6 dead reckoning,
            7 entered by hand, 8 simulated.
        satellites: how many are used; UNKNOWN in RMC.
        hdop: horizontal dilution of precision.
        altitude: of the antenna above mean sea level, m.
        separation: of mean sea level above the ellipsoid WGS 84, m.
        speed: over ground, m/s.
        course: over ground, from true north; unknown at rest.
        variation: magnetic, positive east: true = magnetic + variation.
    """

    sentence: str
    time: float
    latitude: float
    longitude: float
    quality: int
    satellites: int = UNKNOWN
    hdop: float = _UNKNOWN
    altitude: float = _UNKNOWN
    separation: float = _UNKNOWN
    speed: float = _UNKNOWN
    course: float = _UNKNOWN
    variation: float = _UNKNOWN

    @property
    def usable(self) -> bool:
        """Return True if satellites gave this position: not if it was reckoned, entered or simulated.

        Fewer than three satellites give none, whatever the quality says.
        """
        enough = self.satellites == UNKNOWN or self.satellites >= _FEWEST
        return 1 <= self.quality <= 5 and enough and math.isfinite(self.latitude + self.longitude)


class PositionSigma(NamedTuple):
    """Standard deviations of a position to the north, to the east and upward, m (GST); `time` as in Position."""

    time: float
    north: float
    east: float
    up: float

    @property
    def usable(self) -> bool:
        """Return True if the horizontal ones are known and positive."""
        return 0.0 < self.north < math.inf and 0.0 < self.east < math.inf


class OverGround(NamedTuple):
    """Course from true north and speed over ground (VTG); `quality` as in Position."""

    course: float
    speed: float
    quality: int

    @property
    def usable(self) -> bool:
        """Return True if satellites gave this speed."""
        return 1 <= self.quality <= 5 and math.isfinite(self.speed)


class Heading(NamedTuple):
    """A heading.

    Attributes:
        sentence: "HDT" or "THS" (true), "HDM" (magnetic), "HDG" (as the compass shows it).
        heading: clockwise from north, as sent.
        deviation: error of the compass, positive east: magnetic = compass + deviation.
        variation: positive east: true = magnetic + variation.
        valid: False where a THS says that it is estimated, entered, simulated or invalid.
    """

    sentence: str
    heading: float
    deviation: float = _UNKNOWN
    variation: float = _UNKNOWN
    valid: bool = True

    @property
    def true(self) -> float:
        """Return the heading from true north; NaN if a magnetic one came without variation."""
        if self.sentence in ("HDT", "THS"):
            return self.heading
        return (self.magnetic + self.variation) % math.tau

    @property
    def magnetic(self) -> float:
        """Return the heading from magnetic north; NaN if the sentence tells the true one. No deviation is none."""
        if self.sentence in ("HDT", "THS"):
            return _UNKNOWN
        return (self.heading + (0.0 if math.isnan(self.deviation) else self.deviation)) % math.tau

    @property
    def usable(self) -> bool:
        """Return True if the device vouches for it."""
        return self.valid and math.isfinite(self.heading)


class TurnRate(NamedTuple):
    """Rate of turn, rad/s, positive to starboard (ROT)."""

    rate: float
    valid: bool

    @property
    def usable(self) -> bool:
        """Return True if the device vouches for it."""
        return self.valid and math.isfinite(self.rate)


class Attitude(NamedTuple):
    """Attitude of an inertial system (PASHR).

    Attributes:
        time: UTC, s since midnight.
        heading: from true north.
        roll: positive port side up.
        pitch: positive bow up.
        heave: m, positive up.
        sigma: standard deviations of roll, pitch and heading.
        aiding: 0 without satellites; other numbers by maker.
        inertial: 0 inertial unit out or not aligned; other numbers by maker; UNKNOWN where the maker does not send it.
    """

    time: float
    heading: float
    roll: float
    pitch: float
    heave: float
    sigma: tuple[float, float, float]
    aiding: int
    inertial: int

    @property
    def usable(self) -> bool:
        """Return True if all three angles are known and the inertial unit works."""
        return self.inertial != 0 and math.isfinite(self.heading + self.roll + self.pitch)


class BelowTransducer(NamedTuple):
    """Distance from a sounder's transducer to the bottom, m (DPT, DBT): under way, altitude rather than depth.

    Attributes:
        sentence: "DPT" or "DBT".
        distance: m.
        offset: of the transducer, m: positive to the waterline above it, negative to the keel below it.
    """

    sentence: str
    distance: float
    offset: float = _UNKNOWN

    @property
    def usable(self) -> bool:
        """Return True if a bottom was found; sounders send nothing or 0 without."""
        return 0.0 < self.distance < math.inf


Message = Position | PositionSigma | OverGround | Heading | TurnRate | Attitude | BelowTransducer
