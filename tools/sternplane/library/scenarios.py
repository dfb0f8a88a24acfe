"""A scenario by its name, by its file, or as a table in Python; and the request that a flight of it is."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from firmware_py.error_text import quoted
from firmware_py.params import ParamError
from firmware_py.run.usage_error import UsageError
from sternplane.library.vehicles import Settings, folder_of, texts_of

if TYPE_CHECKING:
    from sternplane.sitl.request import FlightRequest

Scenario = str | PathLike[str] | Mapping[str, Any]
"""The name of a shipped scenario, a .toml file, or what such a file would hold, as a dictionary."""
_UNNAMED = "a scenario of one's own"


def request_of(
    scenario: Scenario,
    config: str | PathLike[str],
    *,
    seed: int,
    faults: Sequence[str] = (),
    over: Mapping[str, Any] | None = None,
    set: Settings | None = None,
) -> FlightRequest:
    """Return what is asked for of a flight; `over` is laid upon the scenario.

    Raises:
        ParamError: there is no such scenario, or an argument is of the wrong kind.
        UsageError: the seed is none.
    """
    seed = whole_number("seed", seed, least=0)
    from firmware_py import config_files
    from firmware_py.adapters.storage.toml_files import read_toml
    from sim_bridge.scenarios import scenario_path
    from sternplane.sitl.request import SCENARIOS, FlightRequest

    table: Mapping[str, Any] | None = scenario if isinstance(scenario, Mapping) else None
    name = _UNNAMED if isinstance(scenario, Mapping) else _name_of(scenario)
    if over:
        table = config_files.merge(read_toml(scenario_path(name, SCENARIOS)) if table is None else table, over)
    folder, settings = folder_of(config), texts_of(set)
    struck = list_of("faults", faults, "texts, such as ['jam:rudder_upper@20']", str)
    return FlightRequest(name, folder, seed=seed, faults=struck, table=table, settings=settings)


def _name_of(scenario: str | PathLike[str]) -> str:
    if not isinstance(scenario, str | PathLike):
        said = "must be the name of a scenario, a .toml file, or a dictionary with what such a file holds"
        raise ParamError(f"scenario = {quoted(scenario)}: {said}")
    return fspath(scenario)


def list_of(name: str, given: Iterable[Any] | str, what: str, kind: type[Any] = object) -> tuple[Any, ...]:
    """Return an argument that is a list; a text alone is one of one.

    Raises:
        ParamError: it is none, or has an entry of another kind.
    """
    found = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, Iterable) else None
    if found is None or not all(isinstance(one, kind) for one in found):
        raise ParamError(f"{name} = {quoted(given)}: must be a list of {what}")
    return found


def whole_number(name: str, value: Any, least: int) -> int:
    """Return an argument that is a whole number, of numpy too.

    Raises:
        UsageError: it is none, or is too small.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise UsageError(f"{name} = {quoted(value)}: must be a whole number, {least} or more")
    return number
