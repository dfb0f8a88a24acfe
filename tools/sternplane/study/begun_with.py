"""With which settings the folder of a study was begun: it goes on with these alone."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from firmware_py.run.usage_error import UsageError
from firmware_py.settings import setting_text
from sternplane.campaign.files import write
from sternplane.sitl.taken_settings import plain

FILE = "settings.json"


def refuse_other(folder: Path, runs: str, texts: Sequence[str]) -> None:
    """Refuse a folder that was begun with other settings; else note these there.

    Args:
        folder: of the study.
        runs: what it keeps of its flights there, a file or a folder.
        texts: the settings.

    Raises:
        UsageError: it was begun with others, or cannot be written.
    """
    path, here = folder / FILE, plain(texts)
    there: Any = {} if _kept(folder / runs) else here
    if path.exists():
        try:
            there = json.loads(path.read_bytes())
        except (OSError, ValueError, RecursionError):
            raise UsageError(f"{path}: cannot be read; choose another --out") from None
    if there != here:
        raise UsageError(f"{folder}: was begun with {_named(there)}, here with {_named(here)}; choose another --out")
    write(path, json.dumps(here) + "\n")


def _kept(path: Path) -> bool:
    """Return whether there is a run."""
    return any(path.iterdir()) if path.is_dir() else path.exists() and path.stat().st_size > 0


def _named(settings: Any) -> str:
    if not isinstance(settings, Mapping) or not settings:
        return "nothing set"
    return " ".join([f"--set {setting_text(key, value)}" for key, value in settings.items()])
