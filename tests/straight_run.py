"""Scenarios of a vehicle that goes straight ahead under water from its first moment, for faults to strike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

_NO_LEARNING = "[autopilot.estimation.learning]\nenabled = false\n"


def under_way(
    duration: float,
    depth: float,
    *orders: str,
    completes: str = "time",
    faults: Sequence[str] = (),
    bottom: float = 40.0,
    eddies: float = 0.0,
    rpm: float = 500.0,
    watch: float = 0.0,
    current: tuple[float, float] = (0.0, 0.0),
    learning: bool = False,
) -> str:
    """Return a scenario of so many seconds that begins in `depth`, m, at 1.8 m/s.

    Args:
        duration: s.
        depth: m.
        orders: as `hold`, `surface` and `mission` return them.
        completes: what the scenario means.
        faults: as a scenario lists them.
        bottom: depth of the water, m.
        eddies: 1 sigma, m/s.
        rpm: of the propeller at the start.
        watch: for how long it is watched after it surfaced and disarmed itself, s.
        current: north and east, m/s.
        learning: whether coefficients and current are learned.
    """
    listed = ", ".join(f'"{fault}"' for fault in faults)
    return f"""
description = "Straight ahead."
duration_s = {duration}
completes = "{completes}"
watch_s = {watch}
faults = [{listed}]
[environment]
bottom_depth_m = {bottom}
turbulence_m_s = {eddies}
current_ned_m_s = [{current[0]}, {current[1]}, 0.0]
[start]
depth_m = {depth}
u_m_s = 1.8
n_rpm = {rpm}
{"" if learning else _NO_LEARNING}{"".join(orders)}"""


def at_rest(duration: float, *orders: str, bottom: float = 40.0, current: tuple[float, float] = (0.0, 0.0)) -> str:
    """Return a scenario of so many seconds that begins at rest at the surface; arguments as `under_way`."""
    moving = under_way(duration, 0.0, *orders, bottom=bottom, current=current)
    return moving.replace("u_m_s = 1.8\nn_rpm = 500.0\n", "")


def hold(depth: float, heading: float | None = 0.0) -> str:
    """Return the order to arm and hold a depth, m, and a heading, deg; None is the present one."""
    course = "" if heading is None else f"heading_deg = {heading}\n"
    return f'[[orders]]\nt_s = 0.5\narming = "arm"\nmode = "hold"\ndepth_m = {depth}\n{course}speed_m_s = 1.8\n'


def surface(t: float) -> str:
    """Return the order to surface at a time, s."""
    return f'[[orders]]\nt_s = {t}\nmode = "surface"\n'


def mission(places: Iterable[tuple[float, float]]) -> str:
    """Return the orders to arm and fly to the north by these places: north and depth, m."""
    waypoints = [f"[[waypoints]]\nx_m = {x}\ny_m = 0.0\ndepth_m = {z}\nspeed_m_s = 1.8\n" for x, z in places]
    return '[[orders]]\nt_s = 0.5\narming = "arm"\n[[orders]]\nt_s = 1.0\nmode = "mission"\n' + "".join(waypoints)
