"""The hull heaves, and the depth law does not know: outside the boundary layer, where only k acts, pitch fades too."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_py import config_files
from firmware_py.adapters.installation import configs
from firmware_py.control.sliding_mode_design import sliding_surface
from firmware_py.control.sliding_mode_params import S_LAST_DEPTH
from firmware_py.vehicle.linear_models import diving_model

FADES = 0.15
"""At least so quickly, 1/s."""


@pytest.mark.parametrize("share", [0.5, 0.75, 1.0, 1.25])
@pytest.mark.parametrize("name", ["npsauv2", "remus100", "torpedo_x"])
def test_pitch_and_heave_fade_under_the_law_s_feedback_alone(name: str, share: float) -> None:
    """With poles of -0.8 and -0.9 1/s REMUS 100 grew by 0.09 1/s: a step beyond the layer could leave it swinging."""
    configuration = config_files.read_configuration(configs() / name)
    vehicle, gains = config_files.vehicle(configuration), config_files.autopilot_params(configuration).control.depth
    hull, body, c = vehicle.hull, vehicle.body, vehicle.coefficients
    u, L, half = share * vehicle.propeller.u_trim, hull.length, 0.5 * hull.density * hull.length**2
    scale = max(share, 1.0) if gains.scaled else 1.0
    _, k, _ = sliding_surface(diving_model(vehicle, u), (scale * gains.poles[0], scale * gains.poles[1]), S_LAST_DEPTH)
    inertia = np.array(
        [
            [body.mass - half * L * c.Z_wdot, -body.mass * body.x_G - half * L**2 * c.Z_qdot],
            [-body.mass * body.x_G - half * L**2 * c.M_wdot, body.I_y - half * L**3 * c.M_qdot],
        ]
    )
    righting = body.z_G * body.weight - body.z_B * body.buoyancy
    force = np.array(  # of w, q, theta
        [
            [half * u * c.Z_w, (half * L * c.Z_q + body.mass) * u, 0.0],
            [half * L * u * c.M_w, (half * L**2 * c.M_q - body.mass * body.x_G) * u, -righting],
        ]
    )
    planes = half * u * u * np.array([c.Z_ds, L * c.M_ds])
    under_k = np.linalg.solve(inertia, force - np.outer(planes, (0.0, k[0], k[1])))
    fades = -np.linalg.eigvals(np.vstack([under_k, [0.0, 1.0, 0.0]])).real.max()
    assert fades > FADES
