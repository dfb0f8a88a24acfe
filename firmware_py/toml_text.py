"""One value as a person writes it behind `KEY=`, and back: as in TOML, but what is no TOML is a text without quotes."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from typing import Any

from firmware_py.error_text import quoted
from firmware_py.params import ParamError


def value_of(text: str) -> Any:
    """Return a value that is written as in TOML; any other text is a text."""
    text = text.strip()
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text


def refuse_times(value: Any, where: str) -> None:
    """Refuse a date or a time in a value, which TOML has and no key takes.

    Raises:
        ParamError: which it is; `where` stands before it.
    """
    if isinstance(value, list | tuple | Mapping):
        for one in value.values() if isinstance(value, Mapping) else value:
            refuse_times(one, where)
    elif not isinstance(value, str | int | float):  # TOML has nothing else
        said = "is a date or time, which no key takes; a text of it needs quotes"
        raise ParamError(f"{where}: {value} {said}, '\"{value}\"'")


def text_of(value: Any) -> str:
    """Return the text of which `value_of` makes a value again.

    Args:
        value: a number, a truth value, a text, or a list or table of them; numbers and arrays of numpy too.

    Raises:
        ParamError: it is none of these.
    """
    return value if isinstance(value, str) and value and value_of(value) == value else _toml(value)


def _toml(value: Any) -> str:
    if hasattr(value, "tolist"):  # of numpy
        value = value.tolist()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join([f'{_quote(str(name))} = {_toml(one)}' for name, one in value.items()])}}}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _quote(value)
    if isinstance(value, int | float):
        return repr(value)
    raise ParamError(f"{quoted(value)}: must be a number, true or false, a text, or a list of these")


def _quote(text: str) -> str:
    """Return a text in quotes; TOML escapes one character more than JSON."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
