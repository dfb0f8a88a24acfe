"""The environment: current, turbulence, bottom, place on earth. All randomness follows from a given seed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firmware_py.marine import Origin
from firmware_py.params import ParamError, param

_BLOCK = 1024


@dataclass(frozen=True, slots=True)
class BottomPoint:
    """A corner of the bottom's profile, which runs north; east and west of it the depth is the same."""

    north: float = param(unit="m", low=-1e5, high=1e5, doc="Where.")
    depth: float = param(unit="m", low=0.0, high=12000.0, doc="Depth of the bottom there.")


@dataclass(frozen=True, slots=True)
class EnvironmentParams:
    """A scenario's [environment] table."""

    current_ned: tuple[float, float, float] = param((0.0, 0.0, 0.0), unit="m/s", low=-10.0, high=10.0, doc="Current.")
    turbulence: float = param(0.0, unit="m/s", low=0.0, high=5.0, doc="Turbulence, one sigma on each axis.")
    turbulence_time: float = param(10.0, unit="s", low=0.01, high=1e5, doc="Correlation time of the turbulence.")
    bottom_depth: float = param(100.0, unit="m", low=0.0, high=12000.0, doc="Depth of a flat bottom.")
    surface_pressure: float = param(101_325.0, unit="Pa", low=0.0, high=2e5, doc="Absolute pressure at z = 0.")
    latitude: float = param(36.8, unit="deg", low=-85.0, high=85.0, doc="Latitude of the local frame's origin.")
    longitude: float = param(-121.8, unit="deg", low=-180.0, high=180.0, doc="Longitude of the local frame's origin.")
    bottom: tuple[BottomPoint, ...] = ()

    def __post_init__(self) -> None:
        if any(a.north >= b.north for a, b in zip(self.bottom, self.bottom[1:], strict=False)):
            raise ParamError("bottom is not in order of north_m")

    def bottom_at(self, x: float) -> float:
        """Return the depth of the bottom at x m north: straight lines between the points of `bottom`."""
        points = self.bottom
        if not points:
            return self.bottom_depth
        return float(np.interp(x, [point.north for point in points], [point.depth for point in points]))

    @property
    def origin(self) -> Origin:
        """Return the geodetic position of the local frame's origin."""
        return Origin(self.latitude, self.longitude)


class Environment:
    """The current at every step: constant, plus an Ornstein-Uhlenbeck process on each NED axis.

    The process starts from its stationary distribution and is exact at the step: it has the given intensity and
    correlation time whatever the step. Intensity 0 draws nothing.
    """

    def __init__(self, params: EnvironmentParams, seed: int | np.random.SeedSequence, dt: float) -> None:
        self.params = params
        self.current: tuple[float, float, float] = params.current_ned
        """The velocity of the water, NED, m/s."""
        self._mean = params.current_ned
        self._keep = math.exp(-dt / params.turbulence_time)
        self._kick = params.turbulence * math.sqrt(1.0 - self._keep**2)
        self._generator = np.random.Generator(np.random.PCG64(seed))
        self._draws: list[list[float]] = []
        self._eddy = (0.0, 0.0, 0.0)
        if params.turbulence > 0.0:
            a, b, c = self._draw()
            self._flow(params.turbulence * a, params.turbulence * b, params.turbulence * c)

    @property
    def mean(self) -> tuple[float, float, float]:
        """Return the mean velocity of the water, NED, m/s: without turbulence."""
        return self._mean

    @mean.setter
    def mean(self, current_ned: tuple[float, float, float]) -> None:
        self._mean = current_ned
        self._flow(*self._eddy)

    def step(self) -> None:
        """Advance the turbulence by one step; it is held until the next."""
        if self.params.turbulence > 0.0:
            (x, y, z), (a, b, c) = self._eddy, self._draw()
            keep, kick = self._keep, self._kick
            self._flow(keep * x + kick * a, keep * y + kick * b, keep * z + kick * c)

    def _flow(self, x: float, y: float, z: float) -> None:
        self._eddy = (x, y, z)
        mean = self._mean
        self.current = (mean[0] + x, mean[1] + y, mean[2] + z)

    def _draw(self) -> list[float]:
        if not self._draws:
            self._draws = self._generator.standard_normal((_BLOCK, 3)).tolist()[::-1]
        return self._draws.pop()
