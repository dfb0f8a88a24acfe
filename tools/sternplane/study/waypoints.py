"""A waypoint as a scenario writes it."""

from __future__ import annotations


def waypoint(place: tuple[float, float, float], speed: float) -> str:
    """Return the table of a waypoint: north, east, depth, m; speed, m/s."""
    north, east, depth = place
    return f"[[waypoints]]\nx_m = {north}\ny_m = {east}\ndepth_m = {depth}\nspeed_m_s = {speed}\n"
