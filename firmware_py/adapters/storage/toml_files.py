"""Files that people write: read whole, with errors that name them."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from firmware_py.params import ParamError


def read_toml(path: Path) -> dict[str, Any]:
    """The table in a TOML file.

    Raises:
        ParamError: no such file, not readable, or not TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ParamError(f"{path}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ParamError(f"{path}: is not TOML ({error})") from None
