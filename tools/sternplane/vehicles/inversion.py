"""The speed below which stern planes act the wrong way on the depth, and whether a configuration stays clear of it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from firmware_py.vehicle.vehicle import Vehicle
from sternplane.vehicles.finding import Finding, Grade
from sternplane.vehicles.limits import Files
from sternplane.vehicles.stability import righting

CLEAR = 1.4
"""Speed over that of inversion from which on planes have half of their effect on the depth: 1 - 1 / 1.4^2."""
_HARDLY = 1.15
"""Up to here they have less than a quarter of it: what buoyancy and waves do is more."""


def inversion_speed(vehicle: Vehicle) -> float:
    """Return the speed below which stern planes act the wrong way, m/s; 0 where there is none.

    The pitch that the righting moment allows makes less vertical velocity than the planes' own force, which points
    the other way. In steady motion Z_w w + Z_ds u delta = 0 and rho/2 L^3 u (M_w w + M_ds u delta) = righting theta;
    at this speed z_dot = w - u theta is 0 whatever delta is (of submarines: the critical speed, Burcher and Rydill).
    """
    c, hull = vehicle.coefficients, vehicle.hull
    moment = 0.5 * hull.density * hull.length**3 * (c.M_w * c.Z_ds - c.M_ds * c.Z_w)
    force = righting(vehicle) * c.Z_ds
    return math.sqrt(force / moment) if force * moment > 0.0 else 0.0


def judged(files: Files) -> Iterator[Finding]:
    """Yield whether the speeds that the autopilot chooses by itself are clear of it."""
    inverted = inversion_speed(files.vehicle)
    if not inverted:
        yield Finding("inversion", Grade.PASS, "stern planes act the right way at every speed")
        return
    guidance, u_min = files.autopilot.guidance, files.autopilot.control.u_min
    text = (
        f"below {inverted:.2f} m/s stern planes act the wrong way: their own force outweighs the pitch that they make"
    )
    named = ("cruise_speed", "surface_speed", "failsafe_speed")
    speeds = {f"guidance.{name}_m_s": getattr(guidance, name) for name in named}
    close = {key: speed for key, speed in speeds.items() if speed < CLEAR * inverted}
    for key, speed in close.items():
        mend = "so close to it depth is hardly held, and it hardly comes up: "
        mend += f"raise it to {CLEAR * inverted:.2f}, or check z_G, M_ds and Z_ds"
        grade = Grade.FAIL if speed < _HARDLY * inverted else Grade.WARN
        yield Finding("inversion", grade, f"{text}; {key} = {speed:g}: {mend}")
    if u_min < inverted:
        mend = f"raise it to {inverted:.2f}, below which planes then fade"
        yield Finding("inversion", Grade.WARN, f"{text}; control.u_min_m_s = {u_min:g}: {mend}")
    elif not close:
        slowest = min(speeds.values())
        yield Finding("inversion", Grade.PASS, f"{text}; slowest speed of guidance {slowest:g}, u_min_m_s = {u_min:g}")
