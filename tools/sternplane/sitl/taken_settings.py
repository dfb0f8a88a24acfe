"""What `--set` lays upon the files of all flights of a command: which keys are left to it, and what was set."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from firmware_py.run.usage_error import UsageError
from firmware_py.settings import Setting, plain_settings, setting_text
from sternplane.sitl.request import parse_settings


class Takes(NamedTuple):
    """Which keys a command leaves to the user.

    Attributes:
        keys: files and tables of which any key may be set.
        why: no other may, for the error text.
        fixed: keys and tables below `keys` that it sets itself in every flight.
    """

    keys: tuple[str, ...]
    why: str
    fixed: tuple[str, ...] = ()


def taken(texts: Sequence[str], takes: Takes) -> tuple[str, ...]:
    """Return the settings that a command is given.

    Raises:
        ParamError: unknown or ambiguous.
        UsageError: of a key that is not left to the user.
    """
    for setting in parse_settings(texts):
        if not _below(setting.key, takes.keys):
            raise UsageError(f"--set {setting.key}: {takes.why}")
        if _below(setting.key, (*takes.fixed, "truth.current_m_s", "truth.current_towards_deg")):
            raise UsageError(f"--set {setting.key}: the flights set this themselves")
    return tuple(texts)


def _below(key: str, tables: Sequence[str]) -> bool:
    return any(key == table or key.startswith(f"{table}.") for table in tables)


def beside(scenario: str, texts: Sequence[str]) -> tuple[str, ...]:
    """Return the settings without those of keys that the text of a scenario has: these are what is asked there."""
    own: Mapping[str, Any] = tomllib.loads(scenario)
    return tuple([text for text in texts if not _says(own, *parse_settings([text]))])


def _says(scenario: Mapping[str, Any], setting: Setting) -> bool:
    value: Any = scenario.get(setting.file)
    for part in setting.path:
        if not isinstance(value, Mapping):
            return False
        value = value.get(part)
    return value is not None


def plain(texts: Sequence[str]) -> dict[str, Any]:
    """Return settings as results.json has them: whole key to value."""
    return plain_settings(parse_settings(texts))


def told(texts: Sequence[str]) -> list[str]:
    """Return the line of a page that says what was set; none where nothing was."""
    named = ", ".join([setting_text(key, value) for key, value in plain(texts).items()])
    return [f"Set in all flights but those that ask for another value: {named}."] if named else []
