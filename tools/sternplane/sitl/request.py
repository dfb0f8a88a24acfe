"""What a person asks for of a simulated flight, and the files that it names, with what is set upon them."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import difflib
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from firmware_py import config_files
from firmware_py.adapters.fitting import shared_nodes
from firmware_py.adapters.installation import configs
from firmware_py.adapters.io_params import IoParams
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.error_text import shortened
from firmware_py.params import ParamError, load, param, prefix_errors, toml_key
from firmware_py.run.kept_passport import FROM_STATE, PassportChoice
from firmware_py.run.options import io_file
from firmware_py.run.usage_error import UsageError
from firmware_py.settings import Setting, lay_settings, of_file, parse_setting
from firmware_py.vehicle.fins import Fin
from sim_bridge.build import refuse_unsimulated
from sim_bridge.devices.devices import DevicesParams
from sim_bridge.plant.environment import EnvironmentParams
from sim_bridge.plant.truth import Truth
from sim_bridge.scenarios import Scenario, parse, scenario_path
from sim_bridge.truth_file import truth_source

SCENARIOS = configs() / "scenarios"
CONFIG = configs() / "npsauv2"
FILES: Mapping[str, type[Any]] = {
    **config_files.FILES,
    "truth": Truth,
    "sensors": DevicesParams,
    "io": IoParams,
    "scenario": Scenario,
}
"""The files of which single keys can be set (`firmware_py.settings`)."""


@dataclass(frozen=True, slots=True)
class FlightRequest:
    """What a person asked for."""

    scenario: str = "demo"
    config: Path = CONFIG
    bus: str = "virtual"
    pace: str = "max"
    seed: int = 1
    io: Path | None = None
    """The io file; None is the configuration's io_sitl.toml."""
    faults: tuple[str, ...] = ()
    """As `faults.fault` writes them, beside the scenario's own."""
    link: str = "can"
    """As `hil_link.parse_hil_link` reads it: the bus, or a PX4-compatible simulator's interface in its place."""
    state: Path | None = None
    """What the vehicle kept of an earlier run; None is nothing."""
    passport: PassportChoice = FROM_STATE
    """What it learned there, and begins with."""
    table: Mapping[str, Any] | None = None
    """The scenario itself, as its file would have it, in place of one of that name."""
    settings: tuple[str, ...] = ()
    """Single values of files, FILE.KEY=VALUE each, as `parse_settings` reads them."""


@dataclass(frozen=True, slots=True)
class _Flow:
    """The current as speed and direction, which the scenario has as a vector."""

    current: float = param(0.0, unit="m/s", low=0.0, high=10.0, doc="Speed; to the north if the scenario has none.")
    current_towards: float = param(
        0.0, unit="deg", low=-360.0, high=360.0, doc="Where it flows to, from north to east."
    )


def requested(options: argparse.Namespace) -> FlightRequest:
    """Return the request of a command's options; `plant` has no state, and no passport.

    Raises:
        UsageError: there is no such seed.
    """
    if options.seed < 0:
        raise UsageError(f"--seed {options.seed}: must be 0 or more")
    return FlightRequest(
        scenario=options.scenario,
        config=options.config,
        bus=options.bus,
        pace=options.pace,
        seed=options.seed,
        io=options.io,
        faults=tuple(options.fault),
        link=options.link,
        state=getattr(options, "state", None),
        passport=PassportChoice(getattr(options, "passport", None), getattr(options, "no_passport", False)),
        settings=tuple(options.settings),
    )


def parse_settings(texts: Sequence[str]) -> tuple[Setting, ...]:
    """Return what is set, of each key the last.

    Raises:
        ParamError: in one line, what is wrong, and what is meant probably.
    """
    return tuple({setting.key: setting for setting in map(_parse, texts)}.values())


def _parse(text: str) -> Setting:
    """Return one setting; truth has the scenario's environment too."""
    key = text.partition("=")[0].strip()
    name = key.removeprefix("truth.")
    if name != key and name in _names(_Flow):
        setting = parse_setting(text, {"truth": _Flow})
        load(_Flow, {setting.path[0]: setting.value}, "--set truth")
        return setting
    if name != key and name.partition(".")[0] in _names(EnvironmentParams):
        return parse_setting(f"scenario.environment.{text.strip().removeprefix('truth.')}", FILES)
    try:
        return parse_setting(text, FILES)
    except ParamError:
        if whole := _without_file(text):
            said = f"did you mean {' or '.join(whole)}?"
            raise ParamError(f"--set {shortened(key)}: begins with no file; {said}") from None
        meant = difflib.get_close_matches(name, _names(_Flow) | _names(EnvironmentParams), n=1, cutoff=0.8)
        if name == key or not meant:
            raise
        raise ParamError(f"--set {shortened(key)}: is unknown; did you mean truth.{meant[0]}?") from None


def _without_file(text: str) -> list[str]:
    """Return the whole keys of a setting whose key begins below a file, such as control.law; [] of any other."""
    if text.partition(".")[0] in FILES:
        return []
    found = []
    for file in FILES:
        with contextlib.suppress(ParamError):
            found.append(parse_setting(f"{file}.{text.strip()}", FILES).key)
    return found


def _names(cls: type[Any]) -> set[str]:
    return {name for field in dataclasses.fields(cls) for name in (field.name, toml_key(field))}


def read_io(request: FlightRequest) -> IoParams:
    """Read the io file.

    Raises:
        ParamError: in one line, which key is wrong, and what would be right.
    """
    io: IoParams = _read(IoParams, io_file(request.config, request.io), "io", parse_settings(request.settings))
    if request.bus:
        io.refuse_second_bus_on(request.bus)
    return io


def fitted_nodes(request: FlightRequest, io: IoParams, fins: Sequence[Fin]) -> dict[str, list[int]]:
    """Return what a configuration says of the nodes with several roles, see `fitting.shared_nodes`.

    Raises:
        ParamError: the io file does not fit these fins, or has a device that the plant does not have.
    """
    with prefix_errors(str(io_file(request.config, request.io))):
        refuse_unsimulated(io.lines)
        return shared_nodes(io, fins)


def read_truth(request: FlightRequest) -> Truth:
    """Read truth.toml, and what it derives from; raises as `read_io`."""
    settings = [one for one in parse_settings(request.settings) if one.path[0] not in _names(_Flow)]
    table, where = truth_source(request.config / "truth.toml")
    return load(Truth, *lay_settings(Truth, table, of_file(settings, "truth"), where))


def read_devices(request: FlightRequest, scenario: Scenario) -> DevicesParams:
    """Read sensors.toml with the scenario's upon it; raises as `read_io`."""
    path, settings = request.config / "sensors.toml", parse_settings(request.settings)
    devices: DevicesParams = _read(DevicesParams, path, "sensors", settings, scenario.sensors)
    return devices


def scenario_place(request: FlightRequest) -> str:
    """Return what errors call the scenario: its file, or its name where there is none.

    Raises:
        ParamError: there is no such scenario.
    """
    return request.scenario if request.table is not None else str(scenario_path(request.scenario, SCENARIOS))


def read_scenario(request: FlightRequest) -> Scenario:
    """Read the scenario, with the faults that were asked for; raises as `read_io`."""
    where, settings = scenario_place(request), parse_settings(request.settings)
    table = _scenario_table(request)
    laid, where = lay_settings(Scenario, table, of_file(settings, "scenario"), where)
    if flow := {one.path[0]: one.value for one in of_file(settings, "truth") if one.path[0] in _names(_Flow)}:
        parse(laid, where)
        laid["environment"] = {**laid.get("environment", {}), "current_ned_m_s": _flowing(laid, **flow)}
    scenario = parse(laid, where)
    return dataclasses.replace(scenario, faults=(*scenario.faults, *request.faults))


def _scenario_table(request: FlightRequest) -> Mapping[str, Any]:
    return read_toml(Path(scenario_place(request))) if request.table is None else request.table


def digests(request: FlightRequest) -> dict[str, str]:
    """Return a digest of what each file of the simulation says, before `--set`; comments and order do not count.

    A log has them in place of these files: two flights by one name can be told apart.
    """
    tables = {
        "scenario": _scenario_table(request),
        "truth": truth_source(request.config / "truth.toml")[0],
        "sensors": read_toml(request.config / "sensors.toml"),
    }
    texts = {name: json.dumps(table, sort_keys=True, default=str) for name, table in tables.items()}
    return {name: hashlib.sha256(text.encode()).hexdigest()[:16] for name, text in texts.items()}


def _flowing(
    scenario: Mapping[str, Any], current_m_s: float | None = None, current_towards_deg: float | None = None
) -> list[float]:
    """Return the scenario's current with another speed or direction."""
    north, east, down = scenario.get("environment", {}).get("current_ned_m_s", (0.0, 0.0, 0.0))
    speed = math.hypot(north, east) if current_m_s is None else current_m_s
    towards = math.atan2(east, north) if current_towards_deg is None else math.radians(current_towards_deg)
    return [speed * math.cos(towards), speed * math.sin(towards), down]


def _read(
    cls: type[Any],
    path: Path,
    file: str,
    settings: Sequence[Setting],
    over: Mapping[str, Any] = MappingProxyType({}),
) -> Any:
    table = config_files.read_table(cls, path, over)
    return load(cls, *lay_settings(cls, table, of_file(settings, file), str(path)))
