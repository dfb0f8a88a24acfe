"""Names of files that are made from titles."""

from __future__ import annotations

import re


def file_name(title: str) -> str:
    """Return a title as the name of a file: what is neither a letter, a digit nor one of _.+=- becomes one _."""
    return re.sub(r"[^\w.+=-]+", "_", title)
