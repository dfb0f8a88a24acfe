"""Reading of regular files only: to read a FIFO would wait for a writer, and a device may never end."""

from __future__ import annotations

import errno
from pathlib import Path


def read_regular(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        OSError: it is missing, not regular or not readable.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    return path.read_bytes()
