"""Lines for people: on a terminal folded between words, what is left below the words; elsewhere whole."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import textwrap
from collections.abc import Callable
from typing import TextIO

_HEAD = re.compile(r"sternplane: | *\d+\.\d\d s  ")
"""What stands before the words: the program, or the time of an event."""


def say(line: str) -> None:
    """Print a line on stderr; a closed terminal does not end a flight."""
    with contextlib.suppress(OSError, ValueError):
        print(fitting(line, sys.stderr), file=sys.stderr, flush=True)


def to_all(*takers: Callable[[str], None]) -> Callable[[str], None]:
    """Return what hands a sentence to all of these."""

    def tell(sentence: str) -> None:
        for taker in takers:
            taker(sentence)

    return tell


def fitting(line: str, out: TextIO) -> str:
    """Return a line as `out` shows it without breaking a word that could stay whole."""
    try:
        width = os.get_terminal_size(out.fileno()).columns  # 0 where a serial console does not know it
    except (OSError, ValueError, AttributeError):
        return line
    return folded(line, width) if width else line


def folded(line: str, width: int) -> str:
    """Return a line folded to so many columns."""
    if len(line) <= width:
        return line
    head = _HEAD.match(line)
    indent = " " * head.end() if head and head.end() < width // 2 else ""
    return textwrap.fill(line, width, subsequent_indent=indent, break_on_hyphens=False)
