"""Where runs are left."""

from __future__ import annotations

import contextlib
import tempfile
import time
from pathlib import Path

from tools.errors import UsageError


def run_folder(out: Path | None) -> Path:
    """The folder of a run, made: `out`, or a new one below runs/ here, at which runs/latest then points.

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
        _point(runs / "latest", folder.name)
        return folder
    except OSError as error:
        where = f"--out {out}" if out is not None else "runs/"
        raise UsageError(f"{where}: cannot be made ({error.strerror}); choose another folder with --out") from None


def _point(name: Path, target: str) -> None:
    """Makes the link `name` point at `target`, whatever it pointed at; a convenience that never stops a run."""
    fresh = name.with_name(f".{target}")
    with contextlib.suppress(OSError):
        fresh.symlink_to(target)
        fresh.replace(name)
