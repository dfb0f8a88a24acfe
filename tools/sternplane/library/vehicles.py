"""A configuration: a vehicle as its autopilot believes it to be, and as it is simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firmware_py.adapters.installation import configuration_folder, shipped_vehicles
from firmware_py.error_text import quoted
from firmware_py.params import ParamError
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

    request = FlightRequest(config=folder_of(config), settings=texts_of(set))
    settings = parse_settings(request.settings)
    tables = config_files.read_configuration(request.config, settings=settings)
    return Configuration(
        request.config,
        config_files.vehicle(tables),
        config_files.autopilot_params(tables),
        read_truth(request),
        read_devices(request, read_scenario(request)),
    )


def folder_of(config: str | PathLike[str]) -> Path:
    """Return the folder of a configuration by what a person calls it.

    Raises:
        ParamError: it is no name and no path.
    """
    if not isinstance(config, str | PathLike):
        known = ", ".join(shipped_vehicles())
        raise ParamError(f"config = {quoted(config)}: must be a folder, or the name of a shipped vehicle: {known}")
    return configuration_folder(config)


def texts_of(settings: Settings | None) -> tuple[str, ...]:
    """Return settings as `--set` has them.

    Raises:
        ParamError: they are no dictionary, or have a value that no file can have.
    """
    given = mapping_of("set", settings, "{'vehicle.M_q': -0.05}")
    return tuple([setting_text(key, value) for key, value in given.items()])


def mapping_of(name: str, given: Mapping[str, Any] | None, example: str) -> Mapping[str, Any]:
    """Return an argument that is a dictionary, or None for an empty one.

    Raises:
        ParamError: it is another thing.
    """
    if given is not None and not isinstance(given, Mapping):
        raise ParamError(f"{name} = {quoted(given)}: must be a dictionary, such as {example}")
    return given or {}
