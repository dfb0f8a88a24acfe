"""A configuration folder: its files read and checked, as the tables that a log's header carries whole.

A configuration is {"vehicle": vehicle.toml, "autopilot": autopilot.toml, "files": what to call them in errors,
"mission": as `records.mission.plain` gives it, "kept": {...} of an earlier run, or {}}; "fence" and "rally", as
`records.fence` has them, where there are such; "shared_nodes" where nodes of the io file have several roles, as
`node_roles.shared_bits` returns them. Where stations have changed something in an earlier run, "autopilot" has it so,
and "changed" has the value of each such key in the files.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firmware_py.adapters.installation import no_configuration
from firmware_py.adapters.storage.toml_files import merge as merge
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.error_text import quoted
from firmware_py.mavlink.parameters import store
from firmware_py.mission_check import refuse_mission
from firmware_py.own_parts import KINDS
from firmware_py.params import ParamError, choice_names, dump, load
from firmware_py.part_name import is_part_name
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.records.fence import NO_FENCE
from firmware_py.records.mission import Mission
from firmware_py.records.mission_tables import ItemTable, WaypointTable, mission_of, mission_to_plain
from firmware_py.settings import Setting, lay_settings, of_file
from firmware_py.vehicle.manoeuvrability import ManoeuvrabilityModel
from firmware_py.vehicle.vehicle import Vehicle

Configuration = Mapping[str, Any]
FILES: Mapping[str, type[Any]] = {"vehicle": Vehicle, "autopilot": AutopilotParams}
"""What each file is loaded into: those whose keys can be set (`settings`)."""
_NUMBERS = (int, float)


@dataclass(frozen=True, slots=True)
class MissionParams:
    """mission.toml, whole: what a vehicle that is on its own may be sent to fly."""

    waypoints: tuple[WaypointTable, ...] = ()
    items: tuple[ItemTable, ...] = ()

    def __post_init__(self) -> None:
        mission_of(self.waypoints, self.items)


def read_mission(folder: Path, settings: Sequence[Setting] = ()) -> dict[str, Any]:
    """The mission of a configuration's mission.toml as `build` takes it; an empty one if there is no such file.

    It is checked against autopilot.toml and what is set, but not against what stations have changed: a vehicle that
    starts again under water must start.

    Raises:
        ParamError: an error that names the file and the key.
    """
    path = folder / "mission.toml"
    if not path.exists():
        return mission_to_plain(Mission())
    tables = load(MissionParams, read_toml(path), str(path))
    mission, key = mission_of(tables.waypoints, tables.items), "waypoints" if tables.waypoints else "items"
    configuration = read_configuration(folder, settings=settings)
    able = ManoeuvrabilityModel(vehicle(configuration)).of(None, ())
    refuse_mission(mission, autopilot_params(configuration), NO_FENCE, str(path), key, able)
    return mission_to_plain(mission)


def read_configuration(
    folder: Path,
    over: Mapping[str, Any] | None = None,
    state: Path | None = None,
    factors: Mapping[str, Any] | None = None,
    settings: Sequence[Setting] = (),
) -> dict[str, Any]:
    """The tables of a configuration folder.

    Args:
        folder: with the files.
        over: is laid upon autopilot.toml.
        state: where what stations changed is kept, which is laid upon both.
        factors: multiply numbers of vehicle.toml.
        settings: of single keys of both, upon all but what stations changed; `refuse_changed` refuses those of these.

    Raises:
        ParamError: a file is missing or is not TOML, or autopilot.toml, alone or under what is laid upon it, is wrong,
            or vehicle.toml times its factors, or either with what is set; vehicle.toml as it stands is checked later.
    """
    if not os.path.isdir(folder):
        raise no_configuration(folder)
    files = {name: folder / f"{name}.toml" for name in ("vehicle", "autopilot")}
    configuration = {
        "files": {name: str(path) for name, path in files.items()},
        "vehicle": _multiplied(files["vehicle"], factors) if factors else read_toml(files["vehicle"]),
        "autopilot": _autopilot(files["autopilot"], over or {}, of_file(settings, "autopilot")),
        "changed": {},
    }
    for name, cls in FILES.items():
        if of_this := of_file(settings, name):
            configuration[name], where = lay_settings(cls, configuration[name], of_this, str(files[name]))
            load(cls, configuration[name], where)
    return with_kept_changes(configuration, state)


def _autopilot(path: Path, over: Mapping[str, Any], settings: Sequence[Setting]) -> dict[str, Any]:
    """Return the table of autopilot.toml under `over`; parameters of a part of one's own go with the part.

    So another one that `over` or the settings put in its place has no parameters but those that they give.
    """
    file, chosen = read_table(AutopilotParams, path, {}), {".".join(one.path): one.value for one in settings}
    table = _under(AutopilotParams, file, path, over)
    for kind in KINDS.values():
        key = kind.key.partition(".")[2]
        was, laid = file.get(kind.table, {}).get(key), table.get(kind.table, {})
        if is_part_name(was, choice_names(kind.built_in)) and chosen.get(kind.key, laid[key]) != was:
            table[kind.table] = {**laid, "own": over.get(kind.table, {}).get("own", {})}
    return table


def with_kept_changes(configuration: Configuration, state: Path | None) -> dict[str, Any]:
    """The configuration with what stations changed in an earlier run laid upon it.

    Raises:
        ParamError: the changes cannot be used; the error names their file.
    """
    path = state / store.FILE if state is not None else None
    if path is None or not path.exists():
        return dict(configuration)
    base = configuration["autopilot"]
    changes = read_toml(path)
    load(AutopilotParams, merge(base, changes), str(path))
    was = dump(load(AutopilotParams, base, configuration["files"]["autopilot"]))
    return {
        **configuration,
        "files": {**configuration["files"], "autopilot": f"{path} over {configuration['files']['autopilot']}"},
        "autopilot": merge(base, changes),
        "changed": {key: below(was, key) for key in _dotted(changes)},
    }


def refuse_changed(settings: Sequence[Setting], state: Path | None) -> None:
    """Refuse to set what a station has changed in an earlier run: one of the two would be lost without a word.

    Raises:
        ParamError: which key, and what to do. Changes that cannot be read are no matter of this.
    """
    path = state / store.FILE if state is not None else None
    if not settings or path is None or not path.exists():
        return
    try:
        changed = {tuple(key.split(".")) for key in _dotted(read_toml(path))}
    except ParamError:
        return
    for setting in settings:
        if setting.file == "autopilot" and any(key[: len(setting.path)] == setting.path[: len(key)] for key in changed):
            raise ParamError(
                f"--set {setting.key}: a station has changed it in an earlier run, which holds; leave one of them away "
                f"({path}, or --state)"
            )


def _dotted(table: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _dotted(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def below(table: Mapping[str, Any], key: str) -> Any:
    """Return what stands in a table at a dotted key."""
    head, _, rest = key.partition(".")
    return below(table[head], rest) if rest else table[head]


def read_table(cls: type[Any], path: Path, over: Mapping[str, Any]) -> dict[str, Any]:
    """The table of a file with the scenario's table `over` laid upon it, checked with and without.

    Raises:
        ParamError: the file is wrong by itself, or `over` makes it so; the error tells which.
    """
    table = read_toml(path)
    load(cls, table, str(path))
    return _under(cls, table, path, over)


def _under(cls: type[Any], table: dict[str, Any], path: Path, over: Mapping[str, Any]) -> dict[str, Any]:
    if over:
        table = merge(table, over)
        load(cls, table, f"{path} under the scenario's [{path.stem}]")
    return table


def _multiplied(path: Path, factors: Mapping[str, Any]) -> dict[str, Any]:
    """vehicle.toml with numbers multiplied, checked with and without."""
    table, where = read_toml(path), f"{path} times the scenario's [vehicle_factors]"
    load(Vehicle, table, str(path))
    table = _times(table, factors, where)
    load(Vehicle, table, where)
    return table


def _times(table: Mapping[str, Any], factors: Mapping[str, Any], where: str) -> dict[str, Any]:
    product = dict(table)
    for key, factor in factors.items():
        value = table.get(key)
        if isinstance(value, Mapping) and isinstance(factor, Mapping):
            product[key] = _times(value, factor, f"{where}: {key}")
        elif type(value) in _NUMBERS and type(factor) in _NUMBERS:
            try:
                product[key] = value * factor
            except OverflowError as error:  # an integer that no double holds
                raise ParamError(f"{where}: {quoted(key)}: the factor {quoted(factor)} is too large") from error
        else:
            raise ParamError(f"{where}: {quoted(key)} is no number of vehicle.toml with a factor for it")
    return product


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
