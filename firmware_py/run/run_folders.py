"""Folders of runs."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from pathlib import Path

from firmware_py.adapters.storage.log_names import LOG_FILE, flight_number
from firmware_py.adapters.storage.regular_file import folder_error
from firmware_py.run.usage_error import UsageError

__all__ = ["LOG_FILE", "flight_folder", "numbered_folder", "point_latest", "refuse_impossible", "run_folder"]

_LEFT_BESIDE = ("summary.json", "report.html")
"""What is left beside a log; it replaces any file, but no folder."""
_AT_ONCE = 10
"""Flights that begin in one moment find a number each, before it is given up."""


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
        why = folder_error(out or Path("runs"), error)
        raise UsageError(f"{where}: cannot be made ({why}); choose another folder with --out") from None
    if not os.access(out, os.W_OK | os.X_OK):
        raise UsageError(f"{where}: cannot be written; choose another folder with --out")
    return out


def refuse_impossible(out: Path | None) -> None:
    """Refuse what `run_folder` would refuse, as far as that shows before anything is made.

    Raises:
        UsageError: as `run_folder`.
    """
    folder = out or Path("runs")
    above = next(path for path in (folder, *folder.absolute().parents) if os.path.lexists(path))
    where = f"--out {out}" if out is not None else "runs/"
    if not above.is_dir():
        why = folder_error(folder.absolute(), NotADirectoryError())
        raise UsageError(f"{where}: cannot be made ({why}); choose another folder with --out")
    if not os.access(above, os.W_OK | os.X_OK):
        raise UsageError(f"{where}: cannot be written; choose another folder with --out")


def flight_folder(out: Path | None) -> Path:
    """`run_folder` for a log that nothing may overwrite: a new folder in `out` if there is a log in it already.

    So it is where a folder has the name of what is left beside the log.

    Raises:
        UsageError: it cannot be made, or not be written.
    """
    folder = run_folder(out)
    if not os.path.lexists(folder / LOG_FILE) and not any((folder / name).is_dir() for name in _LEFT_BESIDE):
        return folder
    try:
        return _stamped(folder)
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written ({error.strerror}); choose another folder") from None


def numbered_folder(logs: Path) -> Path:
    """Return the folder of the next flight in `logs`, NUMBER-DATE-TIME: numbers go up whatever the clock shows.

    It is made, unless that cannot be: a vehicle that starts by itself, perhaps under water, flies without a log too.
    """
    stamp, number = time.strftime("%Y%m%d-%H%M%S"), 0
    with contextlib.suppress(OSError):
        logs.mkdir(parents=True, exist_ok=True)
        for _ in range(_AT_ONCE):
            number = 1 + max(map(flight_number, os.listdir(logs)), default=0)
            with contextlib.suppress(FileExistsError):
                (logs / f"{number:05d}-{stamp}").mkdir()
                break
    return logs / f"{max(number, 1):05d}-{stamp}"


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
