"""What a person may type that no file and no number can be: one line says so."""

from __future__ import annotations

import argparse
import errno
import re
from collections.abc import Callable

from firmware_py.error_text import shortened
from firmware_py.run.usage_error import UsageError

_OF_A_PATH = {errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR, errno.EACCES, errno.EPERM, errno.EROFS}
"""What the system says of a path that a person gave, whatever is done with it."""
_DIGITS = 30
"""Of a whole number: Python refuses to write out those of thousands."""


def with_plain_errors(run: Callable[[], int]) -> int:
    """Run a command, and return its exit status.

    Raises:
        UsageError: in place of what the system says of a path that no file can have.
    """
    try:
        return run()
    except OSError as error:
        if error.errno not in _OF_A_PATH or error.filename is None:
            raise
        raise UsageError(f"{error.filename}: cannot be used ({error.strerror}); choose another path") from None


def whole_number(text: str) -> int:
    """Return the number of an option; for argparse.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    if not re.fullmatch(rf"[+-]?[0-9]{{1,{_DIGITS}}}", text):
        raise argparse.ArgumentTypeError(f"{shortened(text)}: must be a whole number of at most {_DIGITS} digits")
    return int(text)


def bounded_number(low: float, high: float) -> Callable[[str], float]:
    """Return what reads a number in a range; for argparse."""

    def number(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = low - 1.0
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r}: must be in [{low:g}, {high:g}]")
        return value

    return number
