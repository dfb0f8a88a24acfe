"""The velocities of vehicle and water in the state of the coefficient filter, as navigation takes them."""

from __future__ import annotations

from firmware_py.estimation.model.state import EDDIES, EDDY_EAST, EDDY_NORTH, MOVING, STILL
from firmware_py.estimation.navigation.velocity import Current, FilterVelocity


def filter_velocity(t: float, mean: list[float], std: list[float], water: int, turbulence: float) -> FilterVelocity:
    """Return the velocities at the time t, s.

    Args:
        t: of validity, s.
        mean: of the filter's state, (n,).
        std: its 1 sigma, (n,).
        water: how many states the water has, see `model.state`.
        turbulence: intensity of the eddies, m/s.
    """
    u, v, w = mean[:3]
    north = east = north_std = east_std = eddy_north = eddy_east = 0.0
    if water != STILL:
        north, east, north_std, east_std = *mean[MOVING:EDDY_NORTH], *std[MOVING:EDDY_NORTH]
    if water == EDDIES:
        eddy_north, eddy_east = mean[EDDY_NORTH], mean[EDDY_EAST]
    current = Current(north, east, max(north_std, east_std), t)
    return FilterVelocity(t, u, v, w, max(std[:2]), current, (eddy_north, eddy_east), turbulence)
