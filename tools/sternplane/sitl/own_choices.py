"""Parts of one's own that a scenario or a setting chooses, checked so that errors name who chose them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from firmware_py.chosen_parts import chosen
from firmware_py.config_files import Configuration
from firmware_py.own_parts import KINDS
from firmware_py.reconfiguration import AutopilotParams
from firmware_py.settings import Setting, lay_settings, of_file

_CHOICES = {(kind.table, name) for kind in KINDS.values() for name in (kind.key.partition(".")[2], "own")}
"""Keys of autopilot.toml that name a part of one's own or have its parameters."""


def refuse_missing_parts(
    configuration: Configuration, over: Mapping[str, Any], settings: Sequence[Setting], scenario: str
) -> None:
    """Refuse a part of one's own that is not there or has wrong parameters: `app.build` would blame autopilot.toml.

    Args:
        configuration: with all that is laid upon it.
        over: what the scenario lays upon autopilot.toml.
        settings: of single keys.
        scenario: what to call it in errors.

    Raises:
        ParamError: in one line, who chose the part, and what is wrong with it.
    """
    where = by_file = configuration["files"]["autopilot"]
    if any(name in over.get(table, {}) for table, name in _CHOICES):
        where = f"{where} under [autopilot] of {scenario}"
    chosen_by = [one for one in of_file(settings, "autopilot") if one.path[:2] in _CHOICES]
    _, where = lay_settings(AutopilotParams, configuration["autopilot"], chosen_by, where)
    if where != by_file:
        chosen({**configuration, "files": {**configuration["files"], "autopilot": where}})
