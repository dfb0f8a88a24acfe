"""What a vehicle keeps from one run to the next, in a folder of its own."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from firmware_py.estimation.navigation import Kept
from tools.errors import UsageError

FILE = "navigation.json"


def load(folder: Path) -> dict[str, float]:
    """What was kept there; empty for a folder that is new.

    Raises:
        UsageError: the file is not what `save` writes.
    """
    path = folder / FILE
    try:
        kept = json.loads(path.read_text(encoding="utf-8"), parse_int=float)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"--state: {path} cannot be read ({error}); remove it to start anew") from None
    fields = set(Kept._fields)
    if not isinstance(kept, Mapping) or set(kept) != fields or not all(_number(value) for value in kept.values()):
        raise UsageError(f"--state: {path} must hold a finite number for each of {', '.join(sorted(fields))}")
    return dict(kept)


def save(folder: Path, kept: Kept) -> None:
    """Keeps it, whole or not at all.

    Raises:
        UsageError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        fresh = folder / f"{FILE}.new"
        with fresh.open("w", encoding="utf-8") as file:
            file.write(json.dumps(kept._asdict(), indent=2, allow_nan=False) + "\n")
            file.flush()
            os.fsync(file.fileno())
        fresh.replace(folder / FILE)
    except OSError as error:
        raise UsageError(f"--state {folder}: cannot be written ({error.strerror}); choose another folder") from None


def _number(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)
