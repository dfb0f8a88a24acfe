"""Reading of regular files only: to read a FIFO would wait for a writer, and a device may never end."""

from __future__ import annotations

import errno
from pathlib import Path

MOST = 1 << 24
"""Bytes of a file that is read whole."""


def read_regular(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        OSError: it is missing, not regular, not readable or too large.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    with path.open("rb") as file:
        content = file.read(MOST + 1)
    if len(content) > MOST:
        raise OSError(errno.EFBIG, f"it has more than {MOST >> 20} MiB", str(path))
    return content
