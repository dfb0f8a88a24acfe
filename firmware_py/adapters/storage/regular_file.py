"""Reads regular files only, for a FIFO waits for a writer, a device may never end; makes folders, or says why not."""

from __future__ import annotations

import errno
import os
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


class FolderError(Exception):
    """A folder that cannot be made; its text says which, and why."""


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, unless it is there.

    Raises:
        FolderError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FolderError(f"{folder}: cannot be made ({folder_error(folder, error)})") from None


def folder_error(folder: Path, error: OSError) -> str:
    """Return why a folder cannot be made or written: what else is in its place or above it, or the system's words."""
    for path in (folder, *folder.parents):
        if os.path.lexists(path):
            if path.is_dir():
                break
            return f"{'it' if path == folder else path} is {_kind(path)}, not a folder"
    return error.strerror or str(error)


def _kind(path: Path) -> str:
    if not path.exists():
        return "a link that leads nowhere"
    kinds = {"a file": path.is_file(), "a FIFO": path.is_fifo(), "a socket": path.is_socket()}
    return next((kind for kind, is_it in kinds.items() if is_it), "a device")
