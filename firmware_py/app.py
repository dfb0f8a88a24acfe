"""The vehicle's composition root: a configuration in, an autopilot out.

A configuration is plain tables, as they stand in the files, so that a log's header can carry it whole:
{"vehicle": vehicle.toml, "autopilot": autopilot.toml, "files": what to call them in errors,
"mission": {"waypoints": [[x, y, z, u], ...]}, "kept": {...} of an earlier run, or {}}.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from firmware_py.adapters.files import read_toml
from firmware_py.allocation import Allocator
from firmware_py.autopilot import Autopilot
from firmware_py.control.control import Control, ControlParams
from firmware_py.estimation.navigation import Kept, Navigation, NavigationParams
from firmware_py.guidance.guidance import Guidance, GuidanceParams
from firmware_py.marine import Origin
from firmware_py.params import ParamError, load, param
from firmware_py.records.order import Mission, Waypoint
from firmware_py.safety.gate import Gate
from firmware_py.safety.supervisor import SafetyParams, Supervisor
from firmware_py.schedule import step_ns
from firmware_py.vehicle.vehicle import Vehicle

Configuration = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class OriginParams:
    """Where the local frame touches the earth."""

    latitude: float = param(unit="deg", low=-85.0, high=85.0, doc="Latitude, north positive.")
    longitude: float = param(unit="deg", low=-180.0, high=180.0, doc="Longitude, east positive.")


@dataclass(frozen=True, slots=True)
class AutopilotParams:
    """autopilot.toml, whole."""

    origin: OriginParams
    rate: int = param(100, unit="Hz", low=50, high=1000, doc="Base rate of the cycle.")
    estimation: NavigationParams = field(default_factory=NavigationParams)
    safety: SafetyParams = field(default_factory=SafetyParams)
    guidance: GuidanceParams = field(default_factory=GuidanceParams)
    control: ControlParams = field(default_factory=ControlParams)

    def __post_init__(self) -> None:
        try:
            step_ns(self.rate)
        except ValueError as error:
            raise ParamError(f"rate_hz: {error}") from None


def read_configuration(folder: Path, over: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The tables of a configuration folder; `over` is laid upon autopilot.toml.

    Raises:
        ParamError: a file is missing or is not TOML.
    """
    if not folder.is_dir():
        raise ParamError(f"{folder}: there is no such configuration folder; configs/npsauv2 is an example")
    autopilot = merge(read_toml(folder / "autopilot.toml"), over or {})
    files = {name: str(folder / f"{name}.toml") for name in ("vehicle", "autopilot")}
    if over:
        files["autopilot"] += " under the scenario's [autopilot]"
    return {"files": files, "vehicle": read_toml(folder / "vehicle.toml"), "autopilot": autopilot}


def autopilot_params(configuration: Configuration) -> AutopilotParams:
    """autopilot.toml, checked.

    Raises:
        ParamError: an error that names the file and the key.
    """
    return load(AutopilotParams, configuration["autopilot"], configuration["files"]["autopilot"])


def vehicle(configuration: Configuration) -> Vehicle:
    """vehicle.toml, checked.

    Raises:
        ParamError: an error that names the file and the key.
    """
    return load(Vehicle, configuration["vehicle"], configuration["files"]["vehicle"])


def build(configuration: Configuration) -> Autopilot:
    """The autopilot of a configuration, as it is before the first tick.

    Raises:
        ParamError: a configuration that cannot be flown, with file and key.
    """
    params, boat = autopilot_params(configuration), vehicle(configuration)
    mission = Mission(tuple(Waypoint(*point) for point in configuration["mission"]["waypoints"]))
    estimator = Navigation(params.estimation, Origin(params.origin.latitude, params.origin.longitude))
    if configuration["kept"]:
        estimator.resume(Kept(**configuration["kept"]))
    return Autopilot(
        estimator=estimator,
        supervisor=Supervisor(params.safety, has_mission=bool(mission.waypoints)),
        guidance=Guidance(params.guidance, mission),
        control=Control(params.control, boat),
        allocator=Allocator(boat),
        gate=Gate(
            params.safety.gate,
            delta_max=tuple(fin.delta_max for fin in boat.fins),
            rate_max=tuple(fin.rate_max for fin in boat.fins),
            n_max=boat.propeller.n_max,
        ),
    )


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `over` laid upon it, table by table."""
    merged = dict(base)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = merge(below, value) if isinstance(below, Mapping) and isinstance(value, Mapping) else value
    return merged
