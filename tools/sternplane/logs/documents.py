"""Writes reports and results: whoever reads one at any time finds the old one or the new one, whole."""

from __future__ import annotations

from pathlib import Path


def write_document(path: Path, text: str) -> None:
    """Replace a file.

    Raises:
        OSError: it cannot be written; the old one stays.
    """
    fresh = path.with_name(f"{path.name}.new")
    fresh.unlink(missing_ok=True)  # what a killed writer left, or a FIFO, which would wait for a reader
    try:
        with fresh.open("x", encoding="utf-8") as file:
            file.write(text)
        fresh.replace(path)
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise
