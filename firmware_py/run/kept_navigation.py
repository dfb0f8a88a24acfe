"""Navigation saved from one run to the next: position, its sigma, the pressure at the surface."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from firmware_py.adapters.storage.state_store import write_atomically
from firmware_py.estimation.navigation.navigation import KeptNavigation
from firmware_py.run.usage_error import UsageError

FILE = "navigation.json"
BOUNDS = {"x": (-1e7, 1e7), "y": (-1e7, 1e7), "position_std": (1e-6, 1e7), "surface_pressure": (3e4, 1.3e5)}
"""Bounds of the saved values, m and Pa: wider than at the end of any run, and safe to start from."""


def load_navigation(folder: Path) -> dict[str, float]:
    """Return the saved navigation; empty for a new folder.

    Raises:
        UsageError: the file is not what `save` writes, or the folder is none.
    """
    path = folder / FILE
    try:
        kept = json.loads(path.read_text(encoding="utf-8"), parse_int=float)
    except FileNotFoundError:
        return {}
    except NotADirectoryError as error:
        raise UsageError(f"--state {folder}: cannot be read ({error.strerror}); choose another folder") from None
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"--state: {path} cannot be read ({error}); remove it to start anew") from None
    if not isinstance(kept, Mapping) or set(kept) != set(BOUNDS):
        raise UsageError(f"--state: {path} must hold a number for each of {', '.join(BOUNDS)}; remove it to start anew")
    for name, (low, high) in BOUNDS.items():
        if not (isinstance(kept[name], float) and low <= kept[name] <= high):
            wanted = f"must be a number in [{low:g}, {high:g}]"
            raise UsageError(f"--state: {path}: {name} = {kept[name]!r}: {wanted}; remove the file to start anew")
    return dict(kept)


def save(folder: Path, kept: KeptNavigation) -> None:
    """Save the navigation atomically.

    Raises:
        UsageError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder, FILE, (json.dumps(kept._asdict(), indent=2, allow_nan=False) + "\n").encode())
    except OSError as error:
        raise UsageError(f"--state {folder}: cannot be written ({error.strerror}); choose another folder") from None
