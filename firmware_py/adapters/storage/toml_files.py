"""Reading of configuration files (TOML)."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from firmware_py.params import ParamError


def read_toml(path: Path) -> dict[str, Any]:
    """Return the table in a TOML file.

    Raises:
        ParamError: the file is missing, not regular, not readable or not TOML; the text names it.
    """
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):  # to read a FIFO would wait for a writer
            raise ParamError(f"{path}: cannot be read (it is not a regular file)")
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ParamError(f"{path}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ParamError(f"{path}: is not TOML ({error})") from None
