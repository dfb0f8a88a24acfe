"""The files of a campaign: their names, made from titles, and how they are written."""

from __future__ import annotations

import re
from pathlib import Path

from firmware_py.adapters.storage.atomic_file import write_atomically
from firmware_py.run.usage_error import UsageError


def file_name(title: str) -> str:
    """Return a title as the name of a file: what is neither a letter, a digit nor one of _.+=- becomes one _."""
    return re.sub(r"[^\w.+=-]+", "_", title)


def write(path: Path, content: str | bytes) -> None:
    """Write a file so that whoever reads it at any time finds the old one or the new one.

    Raises:
        UsageError: it cannot be written.
    """
    try:
        write_atomically(path, content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror}); choose another --out") from None
