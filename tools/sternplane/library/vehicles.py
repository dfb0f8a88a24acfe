"""A configuration: a vehicle as its autopilot believes it to be, and as it is simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firmware_py.adapters.installation import configuration_folder
from firmware_py.settings import setting_text
from sternplane.library.kernels import ready

if TYPE_CHECKING:
    from firmware_py.reconfiguration import AutopilotParams
    from firmware_py.vehicle.vehicle import Vehicle
    from sim_bridge.devices.devices import DevicesParams
    from sim_bridge.plant.truth import Truth

Settings = Mapping[str, Any]
"""Single values laid upon configuration files, such as {"vehicle.M_q": -0.005, "truth.current": 0.2}: `FILE.KEY` as for
`--set` on the command line, in the unit that the key names."""


@dataclass(frozen=True, slots=True)
class Configuration:
    """A configuration folder, read and checked.

    Attributes:
        folder: with the files.
        vehicle: vehicle.toml: geometry, mass and coefficients that the autopilot believes in.
        autopilot: autopilot.toml.
        truth: truth.toml: the vehicle that is simulated.
        sensors: sensors.toml: its instruments.
    """

    folder: Path
    vehicle: Vehicle
    autopilot: AutopilotParams
    truth: Truth
    sensors: DevicesParams


def load(config: str | PathLike[str] = "npsauv2", *, set: Settings | None = None) -> Configuration:
    """Read a configuration.

    Args:
        config: a folder, or the name of a shipped vehicle: "npsauv2", "remus100", "torpedo_x".
        set: single values laid upon its files.

    Raises:
        ParamError: in one line, which file and key is wrong, and what would be right.
    """
    ready()
    from firmware_py import config_files
    from sternplane.sitl.request import FlightRequest, parse_settings, read_devices, read_scenario, read_truth

    request = FlightRequest(config=configuration_folder(config), settings=texts_of(set))
    settings = parse_settings(request.settings)
    tables = config_files.read_configuration(request.config, settings=settings)
    return Configuration(
        request.config,
        config_files.vehicle(tables),
        config_files.autopilot_params(tables),
        read_truth(request),
        read_devices(request, read_scenario(request)),
    )


def texts_of(settings: Settings | None) -> tuple[str, ...]:
    """Return settings as `--set` has them."""
    return tuple([setting_text(key, value) for key, value in (settings or {}).items()])
