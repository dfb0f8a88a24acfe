"""Which settings of runs differ: of vehicle and autopilot every one, the scenario, and what was simulated.

Settings that a file leaves out count with their defaults, so that only what really differs is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py import config_files
from firmware_py.params import ParamError, dump
from sternplane.logs.run import Run

_HEADER = ("scenario", "description", "seed", "pace", "link", "faults", "notes", "version", "git")
MISSING = "–"


class Difference(NamedTuple):
    """A setting, and its value in each run."""

    key: str
    values: list[str]


def differences(logs: Sequence[Run]) -> list[Difference]:
    """Return the settings that are not the same in all runs, in their order."""
    settings = [dict(_settings(log)) for log in logs]
    keys = dict.fromkeys(key for one in settings for key in one)
    found = [Difference(key, [one.get(key, MISSING) for one in settings]) for key in keys]
    return [one for one in found if len(set(one.values)) > 1]


def _settings(log: Run) -> Iterator[tuple[str, str]]:
    """Yield all settings of a run, flat."""
    header, configuration = log.header, log.header.get("configuration", {})
    for key in _HEADER:
        if key in header:
            yield key, value_text(header[key])
    for key, path in configuration.get("files", {}).items():
        yield f"{key} file", str(path)
    yield from _flat("autopilot", _whole(configuration, "autopilot", config_files.autopilot_params))
    yield from _flat("vehicle", _whole(configuration, "vehicle", config_files.vehicle))
    yield from _flat("changed by a station before", configuration.get("changed", {}))
    if log.changes:
        yield "changed by stations in flight", f"{len(log.changes)} times"
    yield from _flat("mission", header.get("mission", {}))
    yield from _flat("truth", header.get("truth", {}))


def _whole(configuration: Mapping[str, Any], table: str, parse: Callable[[Any], Any]) -> Mapping[str, Any]:
    """Return a table with its defaults; as it was logged where this version cannot read it."""
    try:
        found: Mapping[str, Any] = dump(parse(configuration))
    except (KeyError, TypeError, ParamError):
        found = configuration.get(table, {})
    return found


def _flat(key: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _flat(f"{key}.{name}", inner)
    elif isinstance(value, list | tuple) and value and not any(isinstance(one, int | float | str) for one in value):
        for i, inner in enumerate(value):
            yield from _flat(f"{key}[{i}]", inner)
    else:
        yield key, value_text(value)


def value_text(value: Any) -> str:
    """Return a setting as people read it."""
    if isinstance(value, list | tuple):
        return ", ".join(map(value_text, value)) or MISSING
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
