"""Errors as a terminal may have them: one line, and nothing of what was typed moves its cursor or colours it."""

from __future__ import annotations

import argparse
import errno
import re
from collections.abc import Callable
from typing import NoReturn

from firmware_py.error_text import shortened
from firmware_py.foreign_text import visible
from firmware_py.run.command_line import Parser, one_line
from firmware_py.run.usage_error import UsageError

_OF_A_PATH = {errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR, errno.EACCES, errno.EPERM, errno.EROFS}
"""What the system says of a path that a person gave, whatever is done with it."""
_DIGITS = 30
"""Of a whole number: Python refuses to write out those of thousands."""


class PlainParser(Parser):
    """A parser whose errors show every character that was typed."""

    def exit(self, status: int = 0, message: str | None = None) -> NoReturn:
        """Print a message, and exit."""
        super().exit(status, message and f"{visible(message.rstrip())}\n")


def with_plain_errors(run: Callable[[], int]) -> int:
    """Run a command, and return its exit status.

    Raises:
        UsageError: in place of every error of the user's, and of a path that no file can have.
    """
    try:
        return run()
    except OSError as error:
        if error.errno not in _OF_A_PATH or error.filename is None:
            raise
        said = f"{error.filename}: cannot be used ({error.strerror}); choose another path"
    except Exception as error:
        from firmware_py.run.errors import BAD_INPUT  # imports all that can fail: not needed to print a help text

        if not isinstance(error, BAD_INPUT):
            raise
        said = str(error)
    raise UsageError(visible(one_line(said))) from None


def whole_number(text: str) -> int:
    """Return the number of an option; for argparse.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    if not re.fullmatch(rf"[+-]?[0-9]{{1,{_DIGITS}}}", text):
        raise argparse.ArgumentTypeError(f"{shortened(text)}: must be a whole number of at most {_DIGITS} digits")
    return int(text)
