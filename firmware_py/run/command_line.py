"""Conventions of the command line: every error is one line on stderr, and the exit status says what happened."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import NoReturn

from firmware_py import __version__

BAD = 2
"""The exit status of bad input."""
_INTERRUPTED = 130


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        """Print what is wrong, and exit."""
        self.exit(BAD, f"sternplane: {message}; see `{self.prog} --help`\n")


def add_version(parser: argparse.ArgumentParser) -> None:
    """Add --version."""
    parser.add_argument("--version", action="version", version=f"sternplane {__version__}")


def status_of(run: Callable[[], int]) -> int:
    """Run a command, and print every user error in one line.

    Returns:
        The exit status: what `run` returned, 2 for bad input, 130 if it was interrupted.
    """
    try:
        status = run()
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read our output has closed it
        sys.stdout = None
        return 1
    except KeyboardInterrupt:
        print("sternplane: interrupted", file=sys.stderr)
        return _INTERRUPTED
    except Exception as error:
        from firmware_py.run.errors import BAD_INPUT  # imports all that can fail: not needed to print a help text

        if not isinstance(error, BAD_INPUT):
            raise
        print(f"sternplane: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD
    return status
