"""A plant on its own: commands in, motion out, without autopilot, sensors and bus."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

from sternplane.library.kernels import ready
from sternplane.library.scenarios import request_of, whole_number
from sternplane.library.vehicles import Settings

if TYPE_CHECKING:
    from sim_bridge.plant.plant import Plant

STILL_WATER: Mapping[str, Any] = {"description": "Still water.", "completes": "time", "duration_s": 1.0}


def make_plant(
    config: str | PathLike[str] = "npsauv2",
    scenario: str | PathLike[str] | Mapping[str, Any] = STILL_WATER,
    *,
    seed: int = 1,
    rate: int = 100,
    set: Settings | None = None,
) -> Plant:
    """Return the true vehicle in the water.

    `plant.step(fins, n)` advances it by 1 / rate s under held commands: `fins` are angles in rad, one for each of
    `plant.truth.fins`, in their order; `n` is the shaft speed in rev/s. Then `plant.eta` is (x, y, z, phi, theta, psi)
    in m and rad, `plant.nu` (u, v, w, p, q, r) over the ground in m/s and rad/s, `plant.nu_dot` its rate of change,
    `plant.nu_r` (u, v, w) through the water, `plant.fins` and `plant.n` what the actuators do, `plant.altitude` the
    height above the bottom, m.

    Args:
        config: a folder, or the name of a shipped one; its truth.toml is what moves.
        scenario: gives initial state and water: its tables `start` and `environment`; still water by default.
        seed: of the turbulence.
        rate: steps a second.
        set: single values laid upon the files, such as {"truth.M_q": -0.006, "truth.current": 0.2}.

    Raises:
        ParamError, UsageError: in one line, what is wrong, and what would be right.
        PlantError: from `step`: another number of fins, or a state that is no longer finite.
    """
    ready()
    from sim_bridge.build import plant_and_instruments
    from sternplane.sitl.request import read_devices, read_scenario, read_truth

    rate = whole_number("rate", rate, least=1)
    request = request_of(scenario, config, seed=seed, set=set)
    flown = read_scenario(request)
    devices = read_devices(request, flown).within(rate)
    plant, _ = plant_and_instruments(read_truth(request), devices, flown, request.seed, rate)
    return plant
