"""Which settings of runs differ: of vehicle and autopilot every one, of what was simulated what the logs have.

Settings that a file leaves out count with their defaults, so that only what really differs is told. Of scenario, sea,
sensors and simulated vehicle a log has names, the true coefficients, what `--set` laid upon the files, and a digest of
each file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py import config_files
from firmware_py.params import ParamError, dump
from sternplane.logs.run import Run

_HEADER = ("scenario", "description", "seed", "pace", "link", "faults", "notes", "version", "git")
MISSING = "–"
DIGEST = ": digest of what the file says"
"""Behind its name; it is compared only where all logs have one, of a scenario of the same name."""
_LOGGED_WHOLE = ("autopilot", "vehicle")
"""Tables of which a log has every value, so that what `--set` laid upon them needs no row of its own."""


class Difference(NamedTuple):
    """A setting, and its value in each run."""

    key: str
    values: list[str]


def differences(logs: Sequence[Run]) -> list[Difference]:
    """Return the settings that are not the same in all runs, in their order."""
    settings = [dict(_settings(log)) for log in logs]
    keys = dict.fromkeys(key for one in settings for key in one)
    found = [Difference(key, [one.get(key, MISSING) for one in settings]) for key in keys]
    return [one for one in found if len(set(one.values)) > 1 and not (DIGEST in one.key and MISSING in one.values)]


def may_differ_unseen(logs: Sequence[Run]) -> bool:
    """Return whether runs may have flown by files whose values no log has, such as another sea.

    Where all have digests of these files, they tell. Else they may where a scenario is a file of one's own, which
    changes under its name, and where folder or revision differ.
    """
    headers = [log.header for log in logs]
    if all(header.get("digests") for header in headers):
        return False
    if any(str(header.get("scenario") or "").endswith(".toml") for header in headers):
        return True
    folders = {Path(str(one.get("configuration", {}).get("files", {}).get("autopilot", ""))).parent for one in headers}
    return len(folders) > 1 or len({header.get("git") for header in headers}) > 1


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
    for name, digest in header.get("digests", {}).items():
        named = f"scenario {header.get('scenario')}" if name == "scenario" else f"{name}.toml"
        yield f"{named}{DIGEST}", digest
    for key, value in header.get("settings", {}).items():
        if key.partition(".")[0] not in _LOGGED_WHOLE:
            yield f"set {key}", value_text(value)


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
