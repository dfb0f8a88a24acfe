"""Where runs are left."""

from __future__ import annotations

import contextlib
import tempfile
import time
from pathlib import Path

from sternplane.cli.errors import UsageError


def run_folder(out: Path | None) -> Path:
    """The folder of a run, made: `out`, or a new one below runs/ where the command was called.

    Raises:
        UsageError: it cannot be made.
    """
    try:
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
            return out
        runs = Path("runs")
        runs.mkdir(exist_ok=True)
        folder = runs / time.strftime("%Y%m%d-%H%M%S")
        if folder.exists():  # another run began in the same second
            folder = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=runs))
        folder.mkdir(exist_ok=True)
        return folder
    except OSError as error:
        where = f"--out {out}" if out is not None else "runs/"
        raise UsageError(f"{where}: cannot be made ({error.strerror}); choose another folder with --out") from None


def point_latest(folder: Path) -> None:
    """Makes runs/latest point at a run that was left below runs/; a convenience that never stops anything."""
    if folder.parent == Path("runs"):
        fresh = folder.with_name(f".{folder.name}")
        with contextlib.suppress(OSError):
            fresh.symlink_to(folder.name)
            fresh.replace(folder.parent / "latest")
