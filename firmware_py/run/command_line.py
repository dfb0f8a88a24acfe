"""Conventions of the command line: every error is one line on stderr, and the exit status says what happened."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from typing import Any, NoReturn

from firmware_py.foreign_text import visible
from firmware_py.run.terminal import fitting, say
from firmware_py.run.version import version_line

BAD = 2
"""The exit status of bad input."""
_INTERRUPTED = 130
_WORD_MAX, _LINE_MAX = 240, 2000
"""Characters of a word, such as a path, and of a whole error."""
_LONG_WORD = re.compile(rf"\S{{{_WORD_MAX},}}")


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and name the help of the command that was given."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.set_defaults(prog=self.prog)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return the options; refuse what is none of the command's."""
        options, rest = self.parse_known_args(args, namespace)
        if rest:
            unknown = one_line(f"unrecognized arguments: {' '.join(rest)}")
            self._refuse(unknown, options.prog)
        return options

    def error(self, message: str) -> NoReturn:
        """Print what is wrong, and exit."""
        self._refuse(one_line(message), self.prog)

    def _refuse(self, why: str, prog: str) -> NoReturn:
        self.exit(BAD, fitting(f"sternplane: {why}; see `{prog} --help`", sys.stderr) + "\n")


def one_line(text: str) -> str:
    """Return a text as one line that a person can read, of which nothing acts on a terminal.

    Words and lines that are too long are cut in their middle.
    """
    words = _LONG_WORD.sub(lambda word: _cut(word[0], _WORD_MAX), text)
    return visible(_cut(" ".join(words.split()), _LINE_MAX))


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most - most // 4]} ... {text[-most // 5 :]}"


def add_version(parser: argparse.ArgumentParser) -> None:
    """Add --version, which asks git for the commit when it is given."""
    parser.add_argument("--version", action=_Version, nargs=0, help="show version and commit, and exit")


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print(version_line())
        parser.exit()


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
        say("sternplane: interrupted")
        return _INTERRUPTED
    except Exception as error:
        from firmware_py.run.errors import BAD_INPUT  # imports all that can fail: not needed to print a help text

        if not isinstance(error, BAD_INPUT):
            raise
        say(f"sternplane: {one_line(str(error))}")
        return BAD
    return status
