"""Writes a vehicle file, or another table: what a tool has learned of a vehicle, in a form that can be flown."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.adapters.storage.recorder import LogError
from firmware_py.params import load
from firmware_py.vehicle.vehicle import Vehicle


def write(path: Path, table: Mapping[str, Any], comment: str) -> None:
    """Writes vehicle.toml whole or not at all; what can be read at `path` afterwards is `table`, to the last bit.

    Args:
        path: the file, replaced if it is there.
        table: as `tomllib` reads a vehicle file, with other numbers in it.
        comment: where the numbers come from; stands at the top.

    Raises:
        ParamError: the table is not a vehicle's; nothing is written.
        LogError: the file cannot be written.
    """
    load(Vehicle, table, str(path))
    text = text_of(table, comment)
    try:
        write_atomically(path, text.encode())
    except OSError as error:
        raise LogError(f"{path}: cannot be written ({error.strerror}); choose another --out") from None


def text_of(table: Mapping[str, Any], comment: str) -> str:
    """Return a table as TOML, which reads as it is to the last bit; `comment` stands at the top."""
    lines = [*(f"# {line}".rstrip() for line in comment.splitlines()), "", *_table(table, "")]
    text = "\n".join(lines) + "\n"
    if tomllib.loads(text) != table:
        raise AssertionError(f"{comment}: would read otherwise than it is written")
    return text


def _table(table: Mapping[str, Any], name: str) -> Iterator[str]:
    """The lines of a table: its own values first, as TOML wants it, then the tables below it."""
    below = {key: value for key, value in table.items() if isinstance(value, Mapping) or _is_tables(value)}
    yield from (f"{key} = {_value(value)}" for key, value in table.items() if key not in below)
    for key, value in below.items():
        path = f"{name}.{key}" if name else key
        header = f"[{path}]" if isinstance(value, Mapping) else f"[[{path}]]"
        for inner in [value] if isinstance(value, Mapping) else value:
            yield from ("", header, *_table(inner, path))


def _is_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _value(value: Any) -> str:
    """A number, text, truth value or list of them. Python's shortest form of a float is exact, and TOML's too."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False)
