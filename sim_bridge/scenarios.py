"""A scenario: initial state, environment, scheduled orders, faults, and when it is complete."""

from __future__ import annotations

import dataclasses
import enum
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.error_text import did_you_mean, quoted, shortened
from firmware_py.marine import Eta, Nu
from firmware_py.params import ParamError, load, param
from firmware_py.records.mission import Mission
from firmware_py.records.mission_tables import ItemTable, WaypointTable, mission_of
from firmware_py.records.order import Arming, Mode
from sim_bridge.faults.catalogue import FORM
from sim_bridge.faults.fault import Fault, parse_fault
from sim_bridge.plant.environment import EnvironmentParams


class Completes(enum.Enum):
    """The condition for a scenario to count as completed."""

    SURFACED = enum.auto()
    """The vehicle surfaced and disarmed itself; the run ends there."""
    TIME = enum.auto()
    """It was still armed, and not surfacing, when the time was over."""


@dataclass(frozen=True, slots=True)
class InitialState:
    """The plant at t = 0."""

    x: float = param(0.0, unit="m", low=-1e5, high=1e5, doc="North of the origin.")
    y: float = param(0.0, unit="m", low=-1e5, high=1e5, doc="East of the origin.")
    depth: float = param(0.0, unit="m", low=-5, high=6000, doc="Of the body's origin.")
    phi: float = param(0.0, unit="deg", low=-180, high=180, doc="Roll.")
    theta: float = param(0.0, unit="deg", low=-89, high=89, doc="Pitch.")
    psi: float = param(0.0, unit="deg", low=-180, high=360, doc="Heading.")
    u: float = param(0.0, unit="m/s", low=-10, high=10, doc="Surge over the ground.")
    v: float = param(0.0, unit="m/s", low=-10, high=10, doc="Sway over the ground.")
    w: float = param(0.0, unit="m/s", low=-10, high=10, doc="Heave over the ground.")
    n: float = param(0.0, unit="rpm", low=-10000, high=10000, doc="Shaft speed.")

    @property
    def eta(self) -> Eta:
        """Return position and attitude."""
        return Eta(self.x, self.y, self.depth, self.phi, self.theta, self.psi)

    @property
    def nu(self) -> Nu:
        """Return the body velocity; the rates are zero."""
        return Nu(self.u, self.v, self.w, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ScenarioOrder:
    """One order of the scripted operator; a key that is not given changes nothing. Sticks, once moved, are held."""

    t: float = param(unit="s", low=0, high=1e6, doc="Time of the order: the first tick that is not before it.")
    arming: Arming = Arming.KEEP
    mode: Mode | None = None
    depth: float = param(math.nan, unit="m", low=0, high=6000, doc="To hold.")
    heading: float = param(math.nan, unit="deg", low=-180, high=360, doc="To hold.")
    speed: float = param(math.nan, unit="m/s", low=-10, high=10, doc="To hold.")
    delta_s: float = param(math.nan, unit="deg", low=-90, high=90, doc="Stick: stern plane.")
    delta_r: float = param(math.nan, unit="deg", low=-90, high=90, doc="Stick: rudder.")
    n: float = param(math.nan, unit="rpm", low=-10000, high=10000, doc="Stick: propeller.")


@dataclass(frozen=True, slots=True)
class Zigzag:
    """The zigzag (Kempf): the rudder is reversed each time the heading is `heading` off the base course."""

    t: float = param(unit="s", low=0, high=1e6, doc="First execute.")
    delta_r: float = param(20.0, unit="deg", low=1, high=90, doc="Rudder angle, to one side and the other.")
    heading: float = param(20.0, unit="deg", low=1, high=90, doc="Deviation at which the rudder is reversed.")


_OVERRIDES = ("autopilot", "vehicle_factors", "sensors")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One scenario file. `autopilot` and `sensors` override values of autopilot.toml and sensors.toml.

    `vehicle_factors` multiply numbers of vehicle.toml: what the autopilot believes, not what is simulated.
    """

    description: str = param(doc="What the scenario is for; `sternplane scenarios` and the report show it.")
    completes: Completes
    duration: float = param(unit="s", low=1, high=1e6, doc="Time limit of the run.")
    environment: EnvironmentParams = field(default_factory=EnvironmentParams)
    start: InitialState = field(default_factory=InitialState)
    orders: tuple[ScenarioOrder, ...] = ()
    zigzag: Zigzag | None = None
    watch: float = param(
        0.0, unit="s", low=0, high=3600, doc="For so long a vehicle that surfaced and disarmed itself is watched."
    )
    waypoints: tuple[WaypointTable, ...] = ()
    items: tuple[ItemTable, ...] = ()
    faults: tuple[str, ...] = param((), doc=f"What fails, each {FORM}.")
    autopilot: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}), compare=False)
    vehicle_factors: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}), compare=False)
    sensors: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}), compare=False)

    def __post_init__(self) -> None:
        if any(later.t < earlier.t for earlier, later in zip(self.orders, self.orders[1:], strict=False)):
            raise ParamError("orders are not in order of t_s")
        if not self.mission.items and any(order.mode is Mode.MISSION for order in self.orders):
            raise ParamError('mode = "mission" is ordered, but there are no [[waypoints]] or [[items]]')
        depth, bottom = self.start.depth, self.environment.bottom_at(self.start.x)
        if depth > bottom:
            raise ParamError(f"start: depth_m = {depth:g} is below the bottom, which is {bottom:g} m deep there")
        if over := [fault.text for fault in self.injected if fault.t > self.duration]:
            longest = f"the scenario lasts {self.duration:g} s"
            remedy = f"choose T below {self.duration:g}, or a longer scenario.duration_s"
            raise ParamError(f"fault {shortened(over[0])}: {longest}; {remedy}")

    @property
    def injected(self) -> tuple[Fault, ...]:
        """Return the faults."""
        return tuple(parse_fault(text) for text in self.faults)

    @property
    def mission(self) -> Mission:
        """Return the mission that the vehicle loads."""
        return mission_of(self.waypoints, self.items)

    @property
    def bottoms(self) -> tuple[float, ...]:
        """Return the depth of the bottom at each item of the mission, m; NaN for an item that is no place."""
        at = self.environment.bottom_at
        return tuple(at(x) if math.isfinite(x := getattr(item, "x", math.nan)) else x for item in self.mission.items)


def parse(table: Mapping[str, Any], where: str) -> Scenario:
    """Return the scenario of a TOML table.

    Raises:
        ParamError: one line that names `where`, the key and what would be right.
    """
    table = dict(table)
    overrides = {name: table.pop(name, {}) for name in _OVERRIDES}
    for name, values in overrides.items():
        if not isinstance(values, Mapping):
            raise ParamError(f"{where}: {name} must be a table")
    changes: dict[str, Any] = {name: MappingProxyType(dict(values)) for name, values in overrides.items()}
    return dataclasses.replace(load(Scenario, table, where), **changes)


def known(folder: Path) -> tuple[str, ...]:
    """Return the names of the scenarios in a folder."""
    return tuple(sorted(path.stem for path in folder.glob("*.toml")))


def scenario_path(name: str, folder: Path) -> Path:
    """Return the file of the scenario `name` of a folder, or the file `name` if it ends in .toml.

    A file of that folder may be called configs/scenarios/NAME.toml, or scenarios/NAME.toml, wherever the program was
    started; one that exists goes before.

    Raises:
        ParamError: unknown; the known ones are listed.
    """
    is_file = name.endswith(".toml")
    if not is_file and name not in known(folder):
        meant = did_you_mean(name, known(folder))
        also = f"; {meant}" if meant else ""
        raise ParamError(f"unknown scenario {quoted(name)}; known: {', '.join(known(folder)) or 'none'}{also}")
    path = Path(name) if is_file else folder / f"{name}.toml"
    of_folder = path.parts[:-1] in ((folder.name,), (folder.parent.name, folder.name))
    return folder / path.name if of_folder and not os.path.lexists(path) and path.stem in known(folder) else path


def load_scenario(name: str, folder: Path) -> Scenario:
    """Read the scenario of a `scenario_path`.

    Raises:
        ParamError: unknown, unreadable or wrong.
    """
    path = scenario_path(name, folder)
    return parse(read_toml(path), str(path))
