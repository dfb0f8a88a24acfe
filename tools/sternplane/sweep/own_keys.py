"""Keys of laws of one's own, `autopilot.control.own.*`: of the laws of a sweep they are for such parts alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from firmware_py.own_parts import KINDS
from firmware_py.params import ParamError, choice_names
from sternplane.sitl.request import parse_settings

_BUILT_IN = choice_names(KINDS["law"].built_in)
_OWN = f"autopilot.{KINDS['law'].table}.own."
"""Before the names of its parameters."""


def is_own(law: str) -> bool:
    """Return whether a law is none of the built-in ones."""
    return law.lower() not in _BUILT_IN


def takes(law: str, key: str) -> bool:
    """Return whether a law has a key, the whole one with the file before it; another own law's may be unknown to it."""
    return is_own(law) or not key.startswith(_OWN)


def taken(law: str, settings: Iterable[str]) -> tuple[str, ...]:
    """Return those of the settings, KEY=VALUE each, that a law has."""
    return tuple([text for text in settings if takes(law, parse_settings([text])[0].key)])


def refuse_untaken(laws: Sequence[str], keys: Iterable[str], option: str) -> None:
    """Refuse a key that none of the laws has.

    Raises:
        ParamError: which it is.
    """
    for key in keys:
        if laws and not any(takes(law, key) for law in laws):
            raise ParamError(f"{option} {key}: --law {','.join(laws)} names no part of one's own that it would be for")
