"""The vehicle's composition root: a configuration in, an autopilot out.

A configuration is plain tables, as they stand in the files, so that a log's header can carry it whole:
{"vehicle": vehicle.toml, "autopilot": autopilot.toml, "files": what to call them in errors,
"mission": {"waypoints": [[x, y, z, u], ...]}, "kept": {...} of an earlier run, or {}}.
"""

from __future__ import annotations

import os
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
from firmware_py.mavlink.node import MavlinkParams
from firmware_py.params import ParamError, load, naming, param
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
    mavlink: MavlinkParams = field(default_factory=MavlinkParams)

    def __post_init__(self) -> None:
        try:
            step_ns(self.rate)
        except ValueError as error:
            raise ParamError(f"rate_hz: {error}") from None


@dataclass(frozen=True, slots=True)
class WaypointParams:
    """One [[waypoints]] of mission.toml."""

    x: float = param(unit="m", low=-1e5, high=1e5, doc="North of the origin.")
    y: float = param(unit="m", low=-1e5, high=1e5, doc="East of the origin.")
    depth: float = param(unit="m", low=0, high=6000, doc="To be at from here.")
    speed: float = param(unit="m/s", low=0, high=10, doc="To get here with; 0 is the cruising speed.")


@dataclass(frozen=True, slots=True)
class MissionParams:
    """mission.toml, whole: what a vehicle that is on its own may be sent to fly."""

    waypoints: tuple[WaypointParams, ...] = ()


def read_mission(folder: Path) -> list[list[float]]:
    """The waypoints of a configuration's mission.toml as `build` takes them; none if there is no such file.

    Raises:
        ParamError: an error that names the file and the key.
    """
    path = folder / "mission.toml"
    if not path.exists():
        return []
    mission = load(MissionParams, read_toml(path), str(path))
    return [[point.x, point.y, point.depth, point.speed] for point in mission.waypoints]


def read_configuration(folder: Path, over: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The tables of a configuration folder; `over` is laid upon autopilot.toml.

    Raises:
        ParamError: a file is missing or is not TOML, or autopilot.toml, alone or under `over`, is wrong.
    """
    if not os.path.isdir(folder):
        raise ParamError(f"{folder}: there is no such configuration folder; configs/npsauv2 is an example")
    files = {name: folder / f"{name}.toml" for name in ("vehicle", "autopilot")}
    return {
        "files": {name: str(path) for name, path in files.items()},
        "vehicle": read_toml(files["vehicle"]),
        "autopilot": read_table(AutopilotParams, files["autopilot"], over or {}),
    }


def read_table(cls: type[Any], path: Path, over: Mapping[str, Any]) -> dict[str, Any]:
    """The table of a file with the scenario's table `over` laid upon it, checked with and without.

    Raises:
        ParamError: the file is wrong by itself, or `over` makes it so; the error tells which.
    """
    table = read_toml(path)
    load(cls, table, str(path))
    if over:
        table = merge(table, over)
        load(cls, table, f"{path} under the scenario's [{path.stem}]")
    return table


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
    with naming(configuration["files"]["autopilot"]):
        supervisor = Supervisor(params.safety, has_mission=bool(mission.waypoints))
        guidance = Guidance(params.guidance, mission)
    with naming(configuration["files"]["vehicle"]):
        control, allocator = Control(params.control, boat), Allocator(boat)
        gate = Gate(
            params.safety.gate,
            delta_max=tuple(fin.delta_max for fin in boat.fins),
            rate_max=tuple(fin.rate_max for fin in boat.fins),
            n_max=boat.propeller.n_max,
        )
    return Autopilot(
        estimator=estimator, supervisor=supervisor, guidance=guidance, control=control, allocator=allocator, gate=gate
    )


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `over` laid upon it, table by table."""
    merged = dict(base)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = merge(below, value) if isinstance(below, Mapping) and isinstance(value, Mapping) else value
    return merged
