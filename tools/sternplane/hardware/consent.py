"""A yes at the terminal before anything moves."""

from __future__ import annotations

import sys

from firmware_py.foreign_text import visible
from firmware_py.run.usage_error import UsageError


def refuse_unasked(yes: bool, what: str) -> None:
    """Refuse where nobody can be asked; `yes`: it was said beforehand; `what` is done, such as "the fins are moved".

    Raises:
        UsageError: there is no terminal.
    """
    if not yes and not (sys.stdin and sys.stdin.isatty()):
        raise UsageError(f"{what} only after a yes; there is no terminal to ask at, so give --yes")


def ask(what: str, otherwise: str) -> None:
    """Ask whether `what` may be, a sentence.

    Raises:
        UsageError: it may not; `otherwise` says what has become of it, such as "nothing has moved".
    """
    print(f"{visible(what)} Type yes to go on: ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() != "yes":
        raise UsageError(f"that was not yes; {otherwise}")
