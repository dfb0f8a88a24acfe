"""Reading of configuration files (TOML), and one laid upon another."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.params import ParamError

_WHY_MAX = 200
"""Characters of a decoder's reason."""


def read_toml(path: Path) -> dict[str, Any]:
    """Return the table in a TOML file.

    Raises:
        ParamError: the file is missing, not regular, not readable or not TOML; the text names it.
    """
    text = ""
    try:
        text = read_regular(path).decode()
        return tomllib.loads(text)
    except OSError as error:
        raise ParamError(f"{path}: cannot be read ({error.strerror})") from None
    except (ValueError, RecursionError) as error:  # ValueError: not TOML, not UTF-8, or an integer of 4,300 digits
        raise ParamError(f"{path}: is not TOML ({_first_sentence(error, text)})") from None


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `over` laid upon it, table by table."""
    merged = dict(base)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = merge(below, value) if isinstance(below, Mapping) and isinstance(value, Mapping) else value
    return merged


def _first_sentence(error: Exception, text: str) -> str:
    """Return why; of a text that a decoder repeats whole only the beginning."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is not UTF-8"
    if isinstance(error, ValueError) and not isinstance(error, tomllib.TOMLDecodeError):
        most = sys.get_int_max_str_digits()
        found = re.search(rf"[0-9_]{{{most + 1},}}", text)
        where = f" at line {text.count(chr(10), 0, found.start()) + 1}" if found else ""
        return f"a number{where} has more than {most} digits"
    why = str(error)
    return why if len(why) <= _WHY_MAX else f"{why[:_WHY_MAX]} ..."
