"""Writes files whole: whoever reads one at any time finds the old one or the new one. Brings others to the disk."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file so that even after a power failure either the old or the new one is there.

    Of several processes that write into one folder each waits for the others.

    Raises:
        OSError: it cannot be written; the old one stays.
    """
    fresh = path.with_name(f"{path.name}.new")
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)  # given up when the process ends, however it does
        fresh.unlink(missing_ok=True)  # what a killed writer left, or a FIFO, which would wait for a reader
        try:
            with fresh.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            fresh.replace(path)
        except BaseException:
            fresh.unlink(missing_ok=True)
            raise
        os.fsync(folder)
    finally:
        os.close(folder)


def to_disk(path: Path, *, data_only: bool = False) -> None:
    """Bring what was written of a file, or the names of a folder, to the disk; with `data_only` not its times.

    Raises:
        OSError: the disk does not take it, or it is gone.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fdatasync(descriptor) if data_only else os.fsync(descriptor)
    finally:
        os.close(descriptor)
