"""Folders of runs."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from pathlib import Path

from firmware_py.run.usage_error import UsageError

LOG_FILE = "log.mcap"
"""The log, in the folder of its run."""


def run_folder(out: Path | None) -> Path:
    """Make the folder of a run: `out`, or a new one below runs/ where the command was called.

    Raises:
        UsageError: it cannot be made, or not be written.
    """
    where = f"--out {out}" if out is not None else "runs/"
    try:
        if out is None:
            return _stamped(Path("runs"))
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{where}: cannot be made ({error.strerror}); choose another folder with --out") from None
    if not os.access(out, os.W_OK | os.X_OK):
        raise UsageError(f"{where}: cannot be written; choose another folder with --out")
    return out


def flight_folder(out: Path | None) -> Path:
    """`run_folder` for a log that nothing may overwrite: a new folder in `out` if there is a log in it already.

    Raises:
        UsageError: it cannot be made, or not be written.
    """
    folder = run_folder(out)
    if not os.path.lexists(folder / LOG_FILE):
        return folder
    try:
        return _stamped(folder)
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({error.strerror}); choose another folder") from None


def _stamped(parent: Path) -> Path:
    """Make a folder in `parent`, named by the time."""
    parent.mkdir(exist_ok=True)
    folder = parent / time.strftime("%Y%m%d-%H%M%S")
    try:
        folder.mkdir()
    except FileExistsError:  # another run began in the same second
        folder = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=parent))
        folder.chmod(0o755)
    return folder


def point_latest(folder: Path) -> None:
    """Make runs/latest point at a run below runs/; errors are ignored."""
    if folder.parent == Path("runs"):
        fresh = folder.with_name(f".{folder.name}")
        with contextlib.suppress(OSError):
            fresh.symlink_to(folder.name)
            fresh.replace(folder.parent / "latest")
