"""A table of derivatives and particulars, as it was published: a CSV or TOML file, read but not yet understood."""

from __future__ import annotations

import contextlib
import csv
import io
import itertools
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.error_text import quoted
from firmware_py.foreign_text import visible
from firmware_py.params import ParamError
from sternplane.vehicles.propeller_curves import is_curve

_NAMES, _VALUES, _UNITS = ("name", "symbol", "coefficient", "parameter"), ("value",), ("unit", "units")
_MOST = 1000
"""Rows of a table."""
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]")
"""Characters that may act on a terminal; tabs and line ends do not."""


class Entry(NamedTuple):
    """A row: its name as published, a number or text, and its unit where the table has one."""

    name: str
    value: float | str | bool
    unit: str = ""


def read_entries(path: Path) -> tuple[Entry, ...]:
    """Return the rows of a table; lists, such as propeller curves, are left to `read_lists`.

    In TOML each key is a name; the names of tables only group them. A CSV file has columns `name`, `value` and, if it
    likes, `unit`; further columns are notes.

    Raises:
        ParamError: the file cannot be read, has a name twice, too many rows, a value that is neither a number nor a
            text, or a control character, which no TOML file may have.
    """
    with _refused(path):
        found = _from_csv(path) if path.suffix.lower() == ".csv" else _from_toml(read_toml(path), path)
        entries = tuple(itertools.islice(found, _MOST + 1))
    if len(entries) > _MOST:
        raise ParamError(f"{path}: more than {_MOST:,} rows are no table of a vehicle's derivatives")
    for entry in entries:
        if control := next((text for text in map(str, entry) if _CONTROL.search(text)), None):
            raise ParamError(f"{path}: {quoted(control)} has a control character, which cannot be seen; take it out")
    names = Counter(entry.name for entry in entries)
    for name, count in names.items():
        if count > 1:
            raise ParamError(f"{path}: {quoted(name)} stands there {count} times; a name has one value")
    if not entries:
        raise ParamError(f"{path}: no row; write a name and a value, such as Yuv,-28.6")
    return entries


def read_lists(path: Path) -> dict[str, list[float]]:
    """Return the columns of a CSV file, or the lists of numbers in a TOML file, by name.

    Raises:
        ParamError: the file cannot be read, or a column is not all numbers.
    """
    if path.suffix.lower() != ".csv":
        return {key: _numbers(value, key, path) for key, value in _lists(read_toml(path))}
    with _refused(path):
        rows = [row for row in csv.reader(io.StringIO(_text(path))) if any(cell.strip() for cell in row)]
    if len(rows) < 2 or any(len(row) != len(rows[0]) for row in rows):
        raise ParamError(f"{path}: must have a head, such as J,K_T,K_Q, and rows of as many numbers")
    columns = zip(*rows[1:], strict=True)
    return {key.strip(): _numbers(list(column), key, path) for key, column in zip(rows[0], columns, strict=True)}


@contextlib.contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Say in one line what a reader of CSV or of numbers stumbles over."""
    try:
        yield
    except csv.Error as error:
        raise ParamError(f"{path}: is not CSV ({error})") from None
    except OverflowError:
        raise ParamError(f"{path}: has a number beyond 1e308") from None


def _from_toml(table: Mapping[str, Any], path: Path) -> Iterator[Entry]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _from_toml(value, path)
        elif isinstance(value, bool | str):
            yield Entry(key, value)
        elif isinstance(value, int | float):
            yield Entry(key, float(value))
        elif not (isinstance(value, list) and is_curve(key)):
            said = "must be a number or a text; lists are for a propeller's J, K_T and K_Q"
            raise ParamError(f"{path}: {quoted(key)} = {quoted(value)}: {said}")


def _from_csv(path: Path) -> Iterator[Entry]:
    rows = csv.DictReader(io.StringIO(_text(path)), skipinitialspace=True)
    heads = {(head or "").strip().lower(): head for head in rows.fieldnames or ()}
    name, value, unit = (next((heads[key] for key in keys if key in heads), None) for keys in (_NAMES, _VALUES, _UNITS))
    if (name is None or value is None) and any(mark in (rows.fieldnames or ("",))[0] for mark in ";\t"):
        raise ParamError(f"{path}: columns are separated by commas, and a number has a point: name,value,unit")
    if name is None or value is None:
        raise ParamError(f"{path}: its first line must name the columns: name,value,unit (unit may be left out)")
    for row in rows:
        key, raw = (row[name] or "").strip(), (row[value] or "").strip()
        if not key or key.startswith("#"):
            continue
        try:
            yield Entry(key, float(raw.replace("−", "-")), (row.get(unit) or "").strip() if unit else "")
        except ValueError:
            yield Entry(key, raw)


def _lists(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _lists(value)
        elif isinstance(value, list):
            yield key, value


def _numbers(values: Any, key: str, path: Path) -> list[float]:
    try:
        numbers = [float(value) for value in values]
    except (TypeError, ValueError, OverflowError):
        numbers = [math.nan]
    if not all(map(math.isfinite, numbers)):
        raise ParamError(f"{path}: {visible(key.strip())}: must be finite numbers only")
    return numbers


def _text(path: Path) -> str:
    try:
        text = read_regular(path).decode("utf-8-sig")
    except OSError as error:
        raise ParamError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise ParamError(f"{path}: byte {error.start} is not UTF-8") from None
    return "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))
