"""What process noise is measured in: scales of a vehicle's motion by its length and speed, and its fins' resolution.

A small vehicle is quick: REMUS 100 (1.33 m, 1.54 m/s) turns 6 times as violently as NPS AUV II (5.3 m, 1.83 m/s) under
coefficients that are as wrong. So what covers such errors is told in these scales, and one set of numbers serves both.

**Wrong coefficients.** With L the length and U the speed a force is of order U^2 / L by mass, a moment of order
U^2 / L^2 by inertia: so large is the error of an acceleration whose coefficient is wrong by its own size. It lasts for
about the time that the flow needs along the hull, L / U. Taken for white noise, an acceleration a that lasts for a time
T has the intensity a sqrt(T), so that the velocity walks by

    speed_noise = U^2 / L   sqrt(L / U) = U sqrt(U / L)       m/s by sqrt(s)
    rate_noise  = U^2 / L^2 sqrt(L / U) = (U / L)^1.5         rad/s by sqrt(s)

**Unknown water.** Where the water's velocity V is what is unknown, one U of the force is a V: by m/s of it

    eddy_speed_noise = sqrt(U / L)        eddy_rate_noise = sqrt(U) / L^1.5

**Fins' resolution.** Angles travel as float16, in steps of e (2^-12 rad from 14 deg on), so a report is off by up to
e / 2 to either side: 1 sigma of e / sqrt(12). The acceleration by a radian of a fin is

    rho/2 L^3 U^2 |M_ds| / (I_y + added)  in pitch, likewise |N_dr| in yaw; rho/2 L^2 U^2 |Z_ds| / (m + added) in heave,
    likewise |Y_dr| in sway

and the error lasts for as long as the fin is reported at one angle, T. Again a sqrt(T) is its walk.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firmware_py.vehicle.vehicle import Vehicle

FIN_HOLD = 1.0
"""s for which a fin is reported at one angle: held while an excitation holds it."""


class VehicleScales(NamedTuple):
    """See above."""

    speed_noise: float
    rate_noise: float
    eddy_speed_noise: float
    eddy_rate_noise: float
    fins: tuple[float, float, float, float]
    """Accelerations by a radian of the fins: sway, heave (m/s^2), pitch, yaw (rad/s^2)."""

    def fin_noise(self, resolution: float) -> tuple[float, float, float, float]:
        """Return the walk of v, w (m/s) and q, r (rad/s), by sqrt(s), that angles in such steps (rad) cause."""
        sway, heave, pitch, yaw = (a * resolution / math.sqrt(12.0) * math.sqrt(FIN_HOLD) for a in self.fins)
        return sway, heave, pitch, yaw


def vehicle_scales(vehicle: Vehicle) -> VehicleScales:
    """Return the scales of a vehicle at the speed that its propeller is trimmed for."""
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    U, L, force = vehicle.propeller.u_trim, hull.length, 0.5 * hull.density * hull.length**2
    mass = force * L
    return VehicleScales(
        speed_noise=U * math.sqrt(U / L),
        rate_noise=(U / L) ** 1.5,
        eddy_speed_noise=math.sqrt(U / L),
        eddy_rate_noise=math.sqrt(U) / L**1.5,
        fins=(
            force * U * U * abs(c.Y_dr) / (body.mass - mass * c.Y_vdot),
            force * U * U * abs(c.Z_ds) / (body.mass - mass * c.Z_wdot),
            mass * U * U * abs(c.M_ds) / (body.I_y - mass * L * L * c.M_qdot),
            mass * U * U * abs(c.N_dr) / (body.I_z - mass * L * L * c.N_rdot),
        ),
    )
